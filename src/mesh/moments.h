// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/mass_properties.h>

#include <Eigen/Core>

#include <cstdint>

namespace encage {

/// Integrals of 1, x and x x^T over the signed tetrahedra that triangles span with an apex; x is relative to the apex.
struct Moments {
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

/// Integrates over triangles 0 to count - 1, summed in this order; corner(triangle, k) returns a corner.
template <class Corner>
Moments integrate(std::int64_t count, const Corner& corner, const Eigen::Vector3d& apex) {
  Moments m;
  for (std::int64_t t = 0; t < count; ++t) {
    const Eigen::Vector3d a = corner(t, 0) - apex, b = corner(t, 1) - apex, c = corner(t, 2) - apex;
    const Eigen::Vector3d sum = a + b + c;
    const double six_volumes = a.dot(b.cross(c));
    m.volume += six_volumes;
    m.first += six_volumes * sum;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j) {
        m.second(i, j) += six_volumes * (a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + sum[i] * sum[j]);
      }
    }
  }
  m.volume /= 6;
  m.first /= 24;
  m.second /= 120;
  m.second = m.second.selfadjointView<Eigen::Lower>();
  return m;
}

/// Returns the body of these moments, without its radius. Throws Error if the volume or a moment is not positive.
MassProperties body_of(const Moments& moments, const Eigen::Vector3d& apex);

}  // namespace encage

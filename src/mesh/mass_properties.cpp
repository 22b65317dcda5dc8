// SPDX-License-Identifier: Apache-2.0
#include "src/mesh/principal_frame.h"

#include <encage/mass_properties.h>

#include <algorithm>
#include <cmath>

namespace encage {
namespace {

/// Integrals of 1, x and x x^T over the signed tetrahedra.
struct Moments {
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

Moments integrate(const TriangleMesh& mesh, const Eigen::Vector3d& apex) {
  Moments m;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d a = mesh.corner(t, 0) - apex, b = mesh.corner(t, 1) - apex, c = mesh.corner(t, 2) - apex;
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

}  // namespace

MassProperties mass_properties(const TriangleMesh& mesh) {
  if (!is_closed(mesh)) throw Error("mass properties: the mesh is not closed");
  const Eigen::AlignedBox3d box = bounds(mesh);
  const Eigen::Vector3d apex = box.center();
  if (box.isEmpty() || !apex.allFinite()) throw Error("mass properties: the mesh is empty or not finite");
  const Moments m = integrate(mesh, apex);
  if (!(m.volume > 0)) throw Error("mass properties: the mesh encloses no positive volume");

  MassProperties body;
  const Eigen::Vector3d shift = m.first / m.volume;
  const Eigen::Matrix3d covariance = m.second - m.volume * shift * shift.transpose();
  body.mass = m.volume;
  body.centre = apex + shift;
  const double trace = covariance(0, 0) + covariance(1, 1) + covariance(2, 2);
  body.inertia = trace * Eigen::Matrix3d::Identity() - covariance;
  const PrincipalFrame frame = principal_frame(body.inertia);
  body.axes = frame.axes;
  body.moments = frame.values;
  if (!(body.moments[0] > 0)) throw Error("mass properties: the mesh is too thin to have three positive moments");
  double squared_radius = 0;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      squared_radius = std::max(squared_radius, (mesh.corner(t, k) - body.centre).squaredNorm());
    }
  }
  body.radius = std::sqrt(squared_radius);
  return body;
}

}  // namespace encage

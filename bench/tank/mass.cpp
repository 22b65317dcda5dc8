// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/mass.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace encage::tank {
namespace {

// Off-diagonal entries below this share of the trace are rounding: axes stay as they are.
constexpr double negligible = 0x1p-52;
constexpr int most_sweeps = 32;  // convergence is quadratic: 6 are usual

/// Rotates a (both triangles) and the columns of v by the angle that makes a(p, q) zero.
void rotate(Eigen::Matrix3d& a, Eigen::Matrix3d& v, int p, int q) {
  const double theta = (a(q, q) - a(p, p)) / (2 * a(p, q));
  const double t = (theta < 0 ? -1.0 : 1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1));
  const double c = 1 / std::sqrt(t * t + 1);
  const double s = t * c;
  const double shift = t * a(p, q);
  const int r = 3 - p - q;
  const double ap = a(r, p), aq = a(r, q);
  a(p, p) -= shift;
  a(q, q) += shift;
  a(p, q) = a(q, p) = 0;
  a(r, p) = a(p, r) = c * ap - s * aq;
  a(r, q) = a(q, r) = s * ap + c * aq;
  for (int k = 0; k < 3; ++k) {
    const double vp = v(k, p), vq = v(k, q);
    v(k, p) = c * vp - s * vq;
    v(k, q) = s * vp + c * vq;
  }
}

/// One sign for each axis, whatever the rotations did: its largest entry is positive.
Eigen::Vector3d oriented(const Eigen::Vector3d& axis) {
  Eigen::Index largest = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::abs(axis[k]) > std::abs(axis[largest])) largest = k;
  }
  return axis[largest] < 0 ? Eigen::Vector3d(-axis) : axis;
}

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

PrincipalFrame principal_frame(const Eigen::Matrix3d& symmetric) noexcept {
  Eigen::Matrix3d a = symmetric.selfadjointView<Eigen::Lower>();
  Eigen::Matrix3d v = Eigen::Matrix3d::Identity();
  const double small = negligible * (std::abs(a(0, 0)) + std::abs(a(1, 1)) + std::abs(a(2, 2)));
  bool done = false;
  for (int sweep = 0; sweep < most_sweeps && !done; ++sweep) {
    done = true;
    for (const auto& [p, q] : {std::array{0, 1}, std::array{0, 2}, std::array{1, 2}}) {
      if (!(std::abs(a(p, q)) > small)) continue;
      rotate(a, v, p, q);
      done = false;
    }
  }
  std::array<int, 3> order = {0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return a(i, i) < a(j, j); });
  PrincipalFrame frame;
  for (int k = 0; k < 3; ++k) frame.values[k] = a(order[k], order[k]);
  frame.axes.col(0) = oriented(v.col(order[0]));
  frame.axes.col(1) = oriented(v.col(order[1]));
  frame.axes.col(2) = frame.axes.col(0).cross(frame.axes.col(1));
  return frame;
}

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

}  // namespace encage::tank

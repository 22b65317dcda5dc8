// SPDX-License-Identifier: Apache-2.0
#include "src/mesh/principal_frame.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>

namespace encage {
namespace {

// Off-diagonal entries below this fraction of the trace are rounding errors, and the axes stay unchanged.
constexpr double negligible = 0x1p-52;
constexpr int most_sweeps = 32;  // convergence is quadratic: 6 sweeps are usual

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

/// Fixes the sign of each axis: its largest entry is positive.
Eigen::Vector3d oriented(const Eigen::Vector3d& axis) {
  Eigen::Index largest = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::abs(axis[k]) > std::abs(axis[largest])) largest = k;
  }
  return axis[largest] < 0 ? Eigen::Vector3d(-axis) : axis;
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

}  // namespace encage

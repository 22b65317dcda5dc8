// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <algorithm>

namespace encage {

/// Parameters of closest points on two segments, 0 at their starts and 1 at their ends, up to rounding.
struct SegmentParameters {
  double s = 0, t = 0;
};

/// Computes closest points of the segments p0 + s u and q0 + t v, where `w` is p0 - q0.
inline SegmentParameters closest_parameters(const Eigen::Vector3d& u, const Eigen::Vector3d& v,
                                            const Eigen::Vector3d& w) {
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), uw = u.dot(w), vw = v.dot(w);
  const double determinant = uu * vv - uv * uv;
  const auto ratio = [](double numerator, double denominator) {
    return denominator > 0 ? std::clamp(numerator / denominator, 0.0, 1.0) : 0.0;
  };
  // Computes closest points of the lines and clamps them to the first segment, then to the second; the first parameter
  // is then computed again from the second.
  const double first = ratio(uv * vw - vv * uw, determinant);
  const double t = ratio(uv * first + vw, vv);
  return {ratio(uv * t - uw, uu), t};
}

}  // namespace encage

// SPDX-License-Identifier: Apache-2.0
#include "broadphase/motion/pair_motion.h"

#include <algorithm>

namespace encage {
namespace {

AffineMap between(const std::array<AffineMap, 2>& ends, double t) {
  if (t == 0) return ends[0];
  if (t == 1) return ends[1];
  return {(1 - t) * ends[0].linear + t * ends[1].linear, (1 - t) * ends[0].offset + t * ends[1].offset};
}

}  // namespace

PairMotion PairMotion::part(double t0, double t1) const {
  if (at_rest) return *this;
  return {{between(a, t0), between(a, t1)}, {between(b, t0), between(b, t1)}, false};
}

double PairMotion::displacement(double radius_a, double radius_b) const {
  if (at_rest) return 0;
  return (b[1].offset - b[0].offset - a[1].offset + a[0].offset).norm() +
         radius_a * (a[1].linear - a[0].linear).norm() + radius_b * (b[1].linear - b[0].linear).norm();
}

PairMotion pair_motion(const LocalFrame& a, const Motion& motion_a, const LocalFrame& b,
                       const Motion& motion_b) noexcept {
  const double scale_a = motion_a.scale, scale_b = motion_b.scale;
  const AffineMap start = relative_frame(a, {motion_a.start, scale_a}, b, {motion_b.start, scale_b});
  PairMotion pair;
  pair.b[0] = start;
  pair.at_rest = motion_a.at_rest() && motion_b.at_rest();
  if (pair.at_rest) {
    pair.a[1] = pair.a[0];
    pair.b[1] = pair.b[0];
    return pair;
  }
  const Eigen::Matrix3d to_frame = motion_a.start.linear().transpose();
  pair.a[1].linear = to_frame * motion_a.end.linear();
  pair.b[1] = {to_frame * motion_b.end.linear(),
               to_frame * origin_offset(a, {motion_a.end, scale_a}, b, {motion_b.end, scale_b})};
  return pair;
}

double required_distance(const LocalFrame& a, const Motion& motion_a, const LocalFrame& b, const Motion& motion_b,
                         double margin) noexcept {
  const auto required = [&](const Eigen::Isometry3d& pose_a, const Eigen::Isometry3d& pose_b) {
    return required_distance(a, {pose_a, motion_a.scale}, b, {pose_b, motion_b.scale}, margin);
  };
  const double start = required(motion_a.start, motion_b.start);
  if (motion_a.at_rest() && motion_b.at_rest()) return start;
  return std::max({start, required(motion_a.start, motion_b.end), required(motion_a.end, motion_b.start),
                   required(motion_a.end, motion_b.end)});
}

}  // namespace encage

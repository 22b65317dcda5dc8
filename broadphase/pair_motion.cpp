// SPDX-License-Identifier: Apache-2.0
#include "broadphase/pair_motion.h"

#include "broadphase/frame.h"

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

PairMotion pair_motion(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b) noexcept {
  const PairFrame start = relative_frame(a, motion_a.start, b, motion_b.start);
  PairMotion pair;
  pair.b[0] = {start.rotation, start.translation};
  pair.at_rest = motion_a.at_rest() && motion_b.at_rest();
  if (pair.at_rest) {
    pair.a[1] = pair.a[0];
    pair.b[1] = pair.b[0];
    return pair;
  }
  const Eigen::Matrix3d to_frame = motion_a.start.linear().transpose();
  const Eigen::Vector3d offset = (motion_b.end.translation() - motion_a.end.translation()) +
                                 (motion_b.end.linear() * b.origin - motion_a.end.linear() * a.origin);
  pair.a[1].linear = to_frame * motion_a.end.linear();
  pair.b[1] = {to_frame * motion_b.end.linear(), to_frame * offset};
  return pair;
}

double required_distance(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                         double margin) noexcept {
  const double start = required_distance(a, motion_a.start, b, motion_b.start, margin);
  if (motion_a.at_rest() && motion_b.at_rest()) return start;
  return std::max({start, required_distance(a, motion_a.start, b, motion_b.end, margin),
                   required_distance(a, motion_a.end, b, motion_b.start, margin),
                   required_distance(a, motion_a.end, b, motion_b.end, margin)});
}

}  // namespace encage

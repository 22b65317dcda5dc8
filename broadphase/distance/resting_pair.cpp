// SPDX-License-Identifier: Apache-2.0
#include "broadphase/distance/resting_pair.h"

#include "src/limits.h"

namespace encage {
namespace {

AffineMap between(const AffineMap& host, const AffineMap& guest) {
  const Eigen::Matrix3d inverse = host.linear.inverse();
  return {inverse * guest.linear, inverse * (guest.offset - host.offset)};
}

}  // namespace

RestingPair::RestingPair(const LocalFrame& local_a, const Motion& motion_a, const LocalFrame& local_b,
                         const Motion& motion_b) noexcept
    : scale_a(motion_a.scale), scale_b(motion_b.scale) {
  a.linear = motion_a.start.linear();
  b.linear = motion_b.start.linear();
  b.offset = origin_offset(local_a, {motion_a.start, scale_a}, local_b, {motion_b.start, scale_b});
  origin = a.linear * (scale_a * local_a.origin) + motion_a.start.translation();
  const double size = scale_a * local_a.reach() + scale_b * local_b.reach();
  const double between_bodies = (motion_b.start.translation() - motion_a.start.translation()).norm();
  // The constant keeps underflow from making bodies look nearer than they are.
  error = 32 * eps * (size + between_bodies) + 1e-140;
}

AffineMap RestingPair::b_to_a() const noexcept { return between(a, b); }
AffineMap RestingPair::a_to_b() const noexcept { return between(b, a); }

}  // namespace encage

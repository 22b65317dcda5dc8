// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/query/posed_part.h"

#include <encage/queries.h>

namespace encage {

/// The side on which a point of the local frame lies. `fine` is null if there is no fine mesh in memory. `slack`, in
/// the world, bounds how far point and surface may be off; `clear` says that the surface is known to be farther.
PointSide side_of(const PosedPart& part, const Surface* fine, const Eigen::Vector3d& p, double slack,
                  bool clear) noexcept;

/// The side of a point with respect to a whole body, of which all points within `reach` of it are as far from the
/// surface as rounding: outside and inside are proven. Everything is usable.
PointSide side_of(const Shape& shape, const Motion& motion, const Eigen::Vector3d& point) noexcept;

}  // namespace encage

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/contact/nearest_point.h"
#include "broadphase/query/posed_part.h"

#include <encage/queries.h>

#include <array>

namespace encage {

/// The point of a primitive's surface that is nearest to a point of the world. The primitive has a convex radius.
struct RoundedPoint {
  double lower = 0, upper = 0;  ///< bounds of the signed distance, negative inside; world units
  Eigen::Vector3d point;        ///< of the surface, in the world
  SurfacePoint core;            ///< of the core, in the local frame

  PointSide side() const { return lower > 0 ? PointSide::outside : upper < 0 ? PointSide::inside : PointSide::unknown; }
};

RoundedPoint nearest_on_rounded(const PosedPart& part, const Eigen::Vector3d& point) noexcept;

/// Where a ray enters and leaves a primitive that has a convex radius.
struct RoundedHits {
  int count = 0;  ///< of `hits`, by increasing t
  std::array<RayHit, 2> hits;
  bool unknown = false;  ///< the search has not ended; there is no hit before `from`
  double from = 0;
};

/// Finds the hits in the ray's range. `back` says whether the place where the ray leaves counts. Triangles are those of
/// the core, numbered through the whole body. The ray is usable.
RoundedHits cast_at_rounded(const PosedPart& part, const Ray& ray, bool back) noexcept;

}  // namespace encage

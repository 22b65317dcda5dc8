// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/distance/resting_pair.h"
#include "broadphase/shape/shape.h"

#include <encage/separated.h>

#include <cstdint>
#include <limits>

namespace encage {

struct SurfaceDistanceOptions {
  double limit = std::numeric_limits<double>::infinity();  ///< the search ignores larger distances
  double tolerance = 0;                                    ///< fraction of the distance by which the bounds may differ
  double vertex_error = 0;        ///< how far vertices may be off; used only for the proof that surfaces cross
  TrianglePair hint{-1, -1};      ///< tested first, if in range
  std::int64_t* steps = nullptr;  ///< what it may take, as in visit_near_leaves(); unlimited if there is none
};

/// Result in the frame of a RestingPair.
struct SurfaceDistance {
  double lower = 0;  ///< no larger than the distance or the limit
  double upper = std::numeric_limits<double>::infinity();
  Eigen::Vector3d point_a = Eigen::Vector3d::Zero(), point_b = Eigen::Vector3d::Zero();
  std::int32_t triangle_a = -1, triangle_b = -1;  ///< that contain the points; -1 if nothing is below the limit
  bool exhausted = false;                         ///< the steps ended: the bounds may differ by more than the tolerance
  bool crossing = false;  ///< the surfaces are proven to cross, even if vertices are off by `vertex_error`
};

/// Bounds the distance of two surfaces, interiors left out, rounding included.
SurfaceDistance surface_distance(const ScaledSurface& a, const ScaledSurface& b, const RestingPair& pair,
                                 const SurfaceDistanceOptions& options) noexcept;

}  // namespace encage

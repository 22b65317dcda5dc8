// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/distance/resting_pair.h"
#include "broadphase/shape/shape.h"

#include <encage/separated.h>

#include <cstdint>
#include <limits>

namespace encage {

struct SurfaceDistanceOptions {
  double limit = std::numeric_limits<double>::infinity();  ///< larger distances are not asked for
  double tolerance = 0;                                    ///< part of the distance by which bounds may differ
  double vertex_error = 0;    ///< how far vertices may be off, only to prove that surfaces cross
  TrianglePair hint{-1, -1};  ///< looked at first, if in range
};

/// In the frame of a RestingPair.
struct SurfaceDistance {
  double lower = 0;  ///< no larger than the distance or the limit
  double upper = std::numeric_limits<double>::infinity();
  Eigen::Vector3d point_a = Eigen::Vector3d::Zero(), point_b = Eigen::Vector3d::Zero();
  std::int32_t triangle_a = -1, triangle_b = -1;  ///< that have the points; -1: nothing below the limit
  bool crossing = false;                          ///< proven to cross, even where vertices are off by `vertex_error`
};

/// Distance of two surfaces, interiors left out: rounding included.
SurfaceDistance surface_distance(const ScaledSurface& a, const ScaledSurface& b, const RestingPair& pair,
                                 const SurfaceDistanceOptions& options) noexcept;

}  // namespace encage

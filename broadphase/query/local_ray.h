// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/query/posed_part.h"
#include "broadphase/separation/containment.h"
#include "broadphase/separation/triangle_pair.h"

#include <encage/queries.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

namespace encage {

/// True if queries may use the ray.
inline bool is_usable(const Ray& ray) noexcept {
  return ray.origin.cwiseAbs().maxCoeff() <= largest_length && ray.origin.allFinite() && ray.direction.allFinite() &&
         !ray.direction.isZero(0) && !std::isnan(ray.t_min) && !std::isnan(ray.t_max);
}

/// A ray in the local frame of a surface, beginning near the middle of the surface. Points of it are origin + p *
/// direction; its parameter p grows by |d|max per unit of Ray::t, d being the direction in the world.
struct LocalRay {
  Eigen::Vector3d origin, direction;
  double low, high;  ///< range of the parameter
  double error;      ///< local units: bounds the error of coordinates across `axes[0]`, rounding of corners included
  double along;      ///< local units: hits whose place along `axes[0]` is less certain are looked at closely
  double certain;    ///< the same in units of the parameter
  double length;     ///< parameters of the surface lie within +- length
  std::array<int, 3> axes;      ///< along the direction's largest coordinate, then the two that follow
  std::array<double, 2> shear;  ///< direction[axes[1 and 2]] / direction[axes[0]]
  double per_axis;              ///< 1 / direction[axes[0]]
  bool ignore_back_faces;

  double shift, size, t_min, t_max;
  /// Converts a parameter to Ray::t.
  double t(double parameter) const {
    constexpr double most = std::numeric_limits<double>::max();
    return std::clamp(std::clamp((parameter + shift) / size, t_min, t_max), -most, most);
  }
};

/// Maps a ray to a surface's frame; no value if it is proven to miss the ball around the surface.
std::optional<LocalRay> local_ray(const PosedPart& part, const Surface& surface, const Ray& ray,
                                  const RayOptions& options) noexcept;

/// The ray from a point in the surface's box, which is exact.
LocalRay local_ray(const Surface& surface, const WindingRay& ray, const Eigen::Vector3d& point) noexcept;

/// A triangle as a ray sees it: its corners sheared so that the ray runs along the first coordinate.
struct SeenTriangle {
  std::array<double, 3> x, y, z;  ///< relative to the ray's origin
  std::array<double, 3> weight;   ///< edge functions: twice the areas opposite the corners, as seen
  double determinant;             ///< their sum; normal . direction = determinant / per_axis
  double tolerance;               ///< bounds the error of a weight
  double extent;                  ///< of x

  SeenTriangle(const LocalRay& ray, const TriangleD& corners);
  /// True if the place where the ray meets the plane is certain.
  bool steep(const LocalRay& ray) const {
    return std::abs(determinant) > 4 * tolerance && 4 * tolerance * extent <= std::abs(determinant) * ray.along;
  }
  double parameter(const LocalRay& ray) const {
    return (x[0] + (weight[1] * (x[1] - x[0]) + weight[2] * (x[2] - x[0])) / determinant) * ray.per_axis;
  }
};

/// Decides about a triangle that the ray passes near an edge, along its plane, or near an end of the range. Returns the
/// parameter of the hit, or no value if it is proven that the ray misses.
std::optional<double> look_closely(const LocalRay& ray, const TriangleD& corners) noexcept;

/// Fills in all of the hit but its triangle.
RayHit describe_hit(const PosedPart& part, const LocalRay& ray, const TriangleD& corners, double parameter) noexcept;

}  // namespace encage

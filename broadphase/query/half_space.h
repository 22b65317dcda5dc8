// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/queries.h>

#include <optional>
#include <span>

// A half-space answers the queries of <encage/queries.h> here. Rounding is at most 1e-13 times the sum of |offset|
// and of the norm of what is asked.
namespace encage {

/// Where a usable ray with t_min <= t_max meets the plane; no value if it is proven to miss it. A ray that hardly
/// approaches the plane meets it where it may first be there.
std::optional<RayHit> plane_hit(const HalfSpace& half_space, const Ray& ray, const RayOptions& options) noexcept;

/// Both for a finite point. The point on the plane has no triangle; `upper` is finite if it is nearer than the limit.
PointSide plane_side(const HalfSpace& half_space, const Eigen::Vector3d& point) noexcept;
ClosestPoint closest_on_plane(const HalfSpace& half_space, const Eigen::Vector3d& point, double limit) noexcept;

/// True unless the convex hull of finite points, at least one, widened by `radius`, is proven to have no point in
/// common with the half-space.
bool reaches_plane(const HalfSpace& half_space, std::span<const Eigen::Vector3d> hull, double radius) noexcept;
/// True unless two half-spaces are proven to have no point in common. Two planes that are not parallel to the last bit
/// cross somewhere.
bool half_spaces_meet(const HalfSpace& a, const HalfSpace& b) noexcept;

}  // namespace encage

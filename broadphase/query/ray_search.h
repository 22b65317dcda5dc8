// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/query/local_ray.h"
#include "broadphase/separation/containment.h"

#include <cstdint>
#include <optional>

namespace encage {

/// A triangle that a ray meets, and where.
struct FoundHit {
  double t = infinity;          ///< as in RayHit
  double parameter = infinity;  ///< of the local ray
  std::int32_t triangle = -1;   ///< of the surface

  bool before(const FoundHit& other) const { return t < other.t || (t == other.t && triangle < other.triangle); }
};

/// Finds the first triangle that a ray meets. False, and `found` as it was, if there is none before `found`, of which t
/// and the parameter bound the search.
bool first_hit(const Surface& surface, const LocalRay& ray, FoundHit& found) noexcept;

/// Calls visit(context, hit) for all triangles that a ray meets until it returns false; returns false if it did.
bool every_hit(const Surface& surface, const LocalRay& ray, bool (*visit)(void* context, const FoundHit& hit),
               void* context);

/// Winding number of a closed surface about a point in its box, counted along a ray, exactly; no value if rounding
/// leaves it undecided. The same as locate() counts, several boxes and triangles at a time.
std::optional<int> winding_number(const Surface& surface, const WindingRay& ray, const Eigen::Vector3d& point) noexcept;

}  // namespace encage

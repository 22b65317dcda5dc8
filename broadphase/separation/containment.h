// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/shape/shape.h"

#include <array>
#include <optional>

namespace encage {

/// Kind of the interior of a body.
enum class Interior {
  none,
  enclosed,  ///< by the fine mesh, which is closed
  unknown,
};

inline Interior interior(const SimpleShape& shape) {
  if (shape.hollow) return Interior::none;
  return shape.solid == Solid::surface_only || !shape.fine.closed ? Interior::unknown : Interior::enclosed;
}

/// True for a body whose interior is unknown when only its cages are tested.
inline bool unknown_in_cage(const SimpleShape& shape) { return shape.solid == Solid::surface_only && !shape.hollow; }

/// True for the core of a primitive that has no inside.
inline bool flat_core(const SimpleShape& shape) { return shape.primitive && shape.hollow; }

enum class Side { outside, inside, unknown };

/// A ray runs along +`axis` and drifts by `slope1`, `slope2` along the two following axes.
struct WindingRay {
  int axis;
  double slope1, slope2;
};

// The rays are skew, so that those through vertices of axis-aligned models rarely meet edges. There are several,
// because a ray that meets an edge decides nothing. No slope exceeds 1/2: the error bounds of locate() rely on it.
inline constexpr std::array<WindingRay, 6> rays = {{{0, 0.3719, 0.1427},
                                                    {1, 0.2917, -0.4513},
                                                    {2, -0.1733, 0.3391},
                                                    {0, -0.4271, 0.2239},
                                                    {1, 0.1193, 0.3847},
                                                    {2, 0.4651, -0.2683}}};

/// Returns the sign with which a ray from `p` crosses a triangle: 0 if it misses, no value if rounding leaves it
/// undecided.
std::optional<int> crossing(const WindingRay& ray, const std::array<Eigen::Vector3d, 3>& triangle,
                            const Eigen::Vector3d& p) noexcept;

/// Locates a point with respect to a closed surface: it is inside where the winding number is not zero. The answer is
/// exact for the point and the float32 triangles as given, and `unknown` if rounding leaves it undecided.
Side locate(const Surface& surface, const Eigen::Vector3d& point) noexcept;

/// True only if every component of `guest` is proven to lie outside the solid that `host` bounds. Requires surfaces
/// that are known not to touch: one point then stands for its component. `to_host` maps guest's frame to host's.
bool all_outside(const ScaledSurface& host, const ScaledSurface& guest, const AffineMap& to_host) noexcept;

/// For a host with an unknown interior: false only if every part of the guest has a vertex that is proven to stay
/// outside the host's box during the whole interval. The maps lead to the common frame, with errors up to `slack`.
bool could_hold(const SimpleShape& host, double host_scale, const std::array<AffineMap, 2>& host_maps,
                const SimpleShape& guest, double guest_scale, const std::array<AffineMap, 2>& guest_maps,
                double slack) noexcept;

}  // namespace encage

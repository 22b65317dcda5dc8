// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/shape/shape.h"

#include <array>

namespace encage {

/// What a body is beside its surface.
enum class Interior {
  none,
  enclosed,  ///< by the fine mesh, which is closed
  unknown,
};

inline Interior interior(const SimpleShape& shape) {
  if (shape.hollow) return Interior::none;
  return shape.solid == Solid::surface_only || !shape.fine.closed ? Interior::unknown : Interior::enclosed;
}

/// Of a body of which only cages are looked at.
inline bool unknown_in_cage(const SimpleShape& shape) { return shape.solid == Solid::surface_only && !shape.hollow; }

enum class Side { outside, inside, unknown };

/// A ray runs along +`axis` and drifts by `slope1`, `slope2` along the two axes that follow.
struct Ray {
  int axis;
  double slope1, slope2;
};

// Skew, so that rays through vertices of axis-aligned models rarely meet edges;
// several, because one that meets an edge decides nothing. No slope exceeds 1/2:
// the error bounds of locate() rely on it.
inline constexpr std::array<Ray, 6> rays = {{{0, 0.3719, 0.1427},
                                             {1, 0.2917, -0.4513},
                                             {2, -0.1733, 0.3391},
                                             {0, -0.4271, 0.2239},
                                             {1, 0.1193, 0.3847},
                                             {2, 0.4651, -0.2683}}};

/// Where a point lies with respect to a closed surface: inside where the winding
/// number is not zero. Exact for the point and the float32 triangles as given;
/// `unknown` if rounding leaves it open.
Side locate(const Surface& surface, const Eigen::Vector3d& point) noexcept;

/// True only if every component of `guest` is proven to lie outside the solid
/// that `host` bounds. Call it where the surfaces are known not to touch: one
/// point then stands for its component. `to_host` maps guest's frame to host's.
bool all_outside(const ScaledSurface& host, const ScaledSurface& guest, const AffineMap& to_host) noexcept;

/// For a host whose interior is unknown: false only if of every part of the guest some vertex is proven to stay
/// outside the host's box during the whole interval. The maps lead to the common frame, with errors up to `slack`.
bool could_hold(const SimpleShape& host, double host_scale, const std::array<AffineMap, 2>& host_maps,
                const SimpleShape& guest, double guest_scale, const std::array<AffineMap, 2>& guest_maps,
                double slack) noexcept;

}  // namespace encage

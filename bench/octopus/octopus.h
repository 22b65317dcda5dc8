// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <cstdint>

namespace encage::octopus {

inline constexpr std::int64_t default_octopus_faces = 500'000;
inline constexpr std::int64_t fewest_octopus_faces = 10'000;  ///< arms would lose their tips below
inline constexpr std::int64_t most_octopus_faces = 8'000'000;

/// An octopus with `faces` triangles within 1 %: one closed 2-manifold of genus 0, free of self-intersection, oriented
/// outward. z is up and it looks along -y. Its centre of mass (uniform density) is at 0 up to rounding, its
/// circumradius is 1, its vertices are exact in float32. The same bytes on every machine. Throws Error if `faces` is
/// out of range.
TriangleMesh make_octopus(std::int64_t faces = default_octopus_faces);

}  // namespace encage::octopus

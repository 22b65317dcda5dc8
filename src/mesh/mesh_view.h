// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace encage {

/// A mesh in float32 that belongs to somebody else, e.g. one that lies in a mapped asset.
struct MeshView {
  std::span<const std::array<float, 3>> vertices;
  std::span<const std::array<std::uint32_t, 3>> triangles;
};

/// Checks that the mesh is not empty, its vertices are finite and its indices in range. Throws Error, its message
/// starting with `place`.
void check_mesh(const MeshView& mesh, const std::string& place);

}  // namespace encage

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "src/asset/rules.h"
#include "src/tree/mesh_tree.h"

#include <encage/mesh.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

// What queries need of a mesh, beside its vertices and triangles. Derived from
// these alone; an asset stores it, so that loading builds nothing.
namespace encage {

/// Which features a triangle owns: bits 0 to 2 its vertices, bits 3 to 5 its edges (k, k + 1). Every
/// vertex that a triangle uses and every edge is owned by the first triangle
/// that has it, and by no other.
using OwnedFeatures = std::uint8_t;

/// Triangles that are connected through shared vertices.
struct MeshPart {
  std::int32_t vertex;                   ///< one vertex, which stands for the part
  std::array<std::int32_t, 6> extremes;  ///< vertices with the least and largest x, y, z
  std::int32_t closed;  ///< 1: every directed edge occurs as often as its opposite; 0: it has a boundary
};
static_assert(sizeof(MeshPart) == 32);

/// The arrays of one mesh, in place.
struct MeshArraysView {
  MeshView mesh;
  MeshTreeView tree;
  std::span<const OwnedFeatures> owned;  ///< one a triangle
  std::span<const MeshPart> parts;       ///< by first triangle
};

/// The arrays of one mesh, owned.
struct MeshArrays {
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  MeshTree tree;
  std::vector<OwnedFeatures> owned;
  std::vector<MeshPart> parts;

  MeshArraysView view() const { return {{vertices, triangles}, tree, owned, parts}; }
};

/// Throws Error, its message starting with `place`: no triangles, indices out of
/// range, vertices that are not finite or not exact in float32.
MeshArrays make_mesh_arrays(const TriangleMesh& mesh, const std::string& place);

/// Proves what a query relies on for its safety (check_tree(), indices in range,
/// one entry a triangle); linear time. Throws Error, its message starting with `place`.
void check_arrays(const MeshArraysView& arrays, const std::string& place);

}  // namespace encage

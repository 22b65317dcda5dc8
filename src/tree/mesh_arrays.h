// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "src/mesh/mesh_view.h"
#include "src/tree/mesh_tree.h"

#include <encage/mesh.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

// Arrays that queries need besides the vertices and triangles of a mesh. They are derived from these alone; an asset
// stores them, so that loading builds nothing.
namespace encage {

/// The features that a triangle owns: its vertices in bits 0 to 2, its edges (k, k + 1) in bits 3 to 5. The first
/// triangle that has a vertex or an edge owns it, and no other one does.
using OwnedFeatures = std::uint8_t;

/// A set of triangles connected through shared vertices.
struct MeshPart {
  std::int32_t vertex;                   ///< one vertex, which stands for the part
  std::array<std::int32_t, 6> extremes;  ///< vertices with the least and largest x, y, z
  std::int32_t closed;  ///< 1: every directed edge occurs as often as its opposite; 0: the part has a boundary
};
static_assert(sizeof(MeshPart) == 32);

/// Views of the arrays of one mesh.
struct MeshArraysView {
  MeshView mesh;
  MeshTreeView tree;
  std::span<const OwnedFeatures> owned;  ///< one per triangle
  std::span<const MeshPart> parts;       ///< sorted by first triangle
};

/// The arrays of one mesh, owned.
struct MeshArrays {
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  MeshTree tree;
  std::vector<OwnedFeatures> owned;
  std::vector<MeshPart> parts;

  MeshArraysView view() const { return {{vertices, triangles}, tree, owned, parts}; }
  std::int64_t bytes() const noexcept {  ///< of all elements
    const auto of = [](const auto& all) { return static_cast<std::int64_t>(all.size() * sizeof(all[0])); };
    return of(vertices) + of(triangles) + of(tree.nodes) + of(tree.leaves) + of(owned) + of(parts);
  }
};

/// Computes the arrays. Throws Error, its message starting with `place`, if there are no triangles, indices are out of
/// range, or vertices are not finite or not exact in float32.
MeshArrays make_mesh_arrays(const TriangleMesh& mesh, const std::string& place);

/// Checks everything that a query needs to be safe: check_tree(), indices in range, one entry per triangle. Linear
/// time. Throws Error, its message starting with `place`.
void check_arrays(const MeshArraysView& arrays, const std::string& place);

}  // namespace encage

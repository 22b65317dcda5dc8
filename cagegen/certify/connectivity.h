// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <cstdint>
#include <string>
#include <vector>

namespace encage::proof {

/// What the vertex indices alone say about a mesh.
struct Connectivity {
  std::vector<std::int32_t> component;  ///< label of every triangle, as triangle_components() gives it
  int component_count = 0;
  /// Every directed edge occurs as often as its reverse: the surface has no boundary.
  bool closed = false;
  /// An edge that breaks `closed`, as "edge 3-7".
  std::string open_edge;
  /// Empty if the mesh is a closed, consistently oriented manifold, in edges and in vertices; otherwise the first
  /// reason why not, e.g. "edge 3-7 borders 3 triangles".
  std::string defect;
  /// Sum over the components by Euler's formula; meaningful if `defect` is empty.
  int genus = 0;
};

/// The indices must be valid. Linear time.
Connectivity connectivity(const TriangleMesh& mesh);

}  // namespace encage::proof

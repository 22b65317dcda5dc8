// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <cstdint>
#include <vector>

namespace encage::proof {

/// Bounding-box tree over the triangles of one mesh, split at the median of the longest axis. The certificate's own:
/// nothing here is shared with the makers of cages. Boxes are exact (minima and maxima of coordinates).
struct BoxTree {
  struct Node {
    double low[3];
    double high[3];
    std::int32_t first;  ///< leaf: first entry of `order`; inner node: children are first, first + 1
    std::int32_t count;  ///< triangles of a leaf, 0 for an inner node
  };

  std::vector<Node> nodes;          ///< nodes[0] is the root; children follow their parent
  std::vector<std::int32_t> order;  ///< triangle indices, ascending inside each leaf

  /// The mesh needs at least one triangle and valid indices.
  explicit BoxTree(const TriangleMesh& mesh);
};

}  // namespace encage::proof

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "src/tree/mesh_tree.h"

namespace encage {

/// Fits the boxes and slabs of a tree to vertices that have moved. The triangles stay in their leaves, so the tree gets
/// worse as they part. Slabs keep their normals or take the mean normals of their triangles. Vertices must be finite.
/// Linear time, with three visits of each triangle.
void refit_tree(MeshTree& tree, const MeshView& mesh);

}  // namespace encage

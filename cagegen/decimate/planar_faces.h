// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <cstdint>
#include <optional>

namespace encage::makers {

/// The same surface with as few triangles as its planar faces need: triangles that lie in one plane, but for
/// `tolerance`, become a face, vertices on its straight edges go, and it is triangulated anew. What is curved stays as
/// it is. `mesh` must be a closed oriented manifold without degenerate triangles. No value if the result is not one,
/// or has more than `most` triangles, or for meshes of more than 200,000, which are hardly ever planar.
std::optional<TriangleMesh> merge_planar_faces(const TriangleMesh& mesh, double tolerance, std::int64_t most);

}  // namespace encage::makers

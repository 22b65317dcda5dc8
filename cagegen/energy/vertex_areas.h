// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

namespace encage {

/// A third of the area of its triangles, for every vertex.
Eigen::VectorXd vertex_areas(const TriangleMesh& mesh);

}  // namespace encage

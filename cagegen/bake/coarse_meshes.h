// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/bake.h>

#include <vector>

namespace encage {

/// The coarse meshes made by the user, in the frame of the source and rounded to float32. Throws Error naming level,
/// mesh, element and reason for one that could not become a cage whatever it encloses.
std::vector<TriangleMesh> local_coarse_meshes(const BakeOptions& options, const SourceMesh& source);

}  // namespace encage

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/bake.h>

#include <string>
#include <vector>

namespace encage {

/// The coarse meshes made by the user, in the frame of the source and rounded to float32. Throws Error naming level,
/// mesh, element and reason for one that could not become a cage whatever it encloses.
std::vector<TriangleMesh> local_coarse_meshes(const BakeOptions& options, const SourceMesh& source);

/// The user's decimator, whose results are checked and rounded to float32: throws Error if one has too many triangles,
/// or is not a closed, oriented manifold without self-intersection. Empty if `decimator` is.
Decimator checked_decimator(const Decimator& decimator, const std::string& name);

}  // namespace encage

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/shape.h>

#include <filesystem>

namespace encage::replay {

/// The mesh that all engines get, and Encage's shape of it.
struct ReplayBody {
  TriangleMesh mesh;  ///< body frame; with the caps, where the source was open
  ShapePtr shape;
  int levels = 0;      ///< cages
  bool closed = true;  ///< the mesh bounds a solid
};

/// Reads a mesh and, unless the path is empty, an asset with its cages and fine mesh. Throws Error, also if the asset
/// was baked from another mesh.
ReplayBody load_body(const std::filesystem::path& mesh, const std::filesystem::path& cages);

}  // namespace encage::replay

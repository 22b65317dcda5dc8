// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/tool/bake_mesh.h"

#include <encage/bake.h>

#include <filesystem>
#include <functional>
#include <string>

namespace encage::tool {

/// Bakes the collision meshes of a robot description (URDF), an asset each.
struct RobotArguments {
  std::filesystem::path input;   ///< "-" for standard input
  std::filesystem::path output;  ///< a folder; empty: the input's name without extension, in the current folder
  std::filesystem::path json;    ///< may be empty
  BakeOptions options;
  bool verbose = false;  ///< note what the makers try
};

/// Whether a format is that of a robot description.
bool is_robot(const std::string& format);

/// Reads and bakes everything before anything is written. Equal meshes of equal scale are baked once. Calls `print` for
/// each asset written. Returns the exit status. Throws Error, which names the description and the link, or the mesh.
int bake_robot(const RobotArguments& arguments,
               const std::function<void(const std::string& mesh, const std::filesystem::path& asset,
                                        const BakedMesh& baked)>& print);

}  // namespace encage::tool

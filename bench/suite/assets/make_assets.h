// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/bake.h>

#include <cstdint>
#include <filesystem>
#include <vector>

namespace encage::assets {

struct AssetFiles {
  std::vector<std::filesystem::path> files;
  std::int64_t bytes = 0;      ///< of all files
  std::int64_t triangles = 0;  ///< of all fine meshes
};

struct AssetOptions {
  int count = 2000;
  int bases = 40;         ///< that are baked; the others are variants of these
  int triangles = 50000;  ///< of a mesh, about
};

/// Assets in `folder`, every one with another mesh. What is there under its name is taken for what it is; nothing else
/// is touched. Throws Error or Cancelled.
void make_assets(const std::filesystem::path& folder, const AssetOptions& options, const BakeContext& context);

/// What make_assets() has made.
AssetFiles find_assets(const std::filesystem::path& folder, const AssetOptions& options);

}  // namespace encage::assets

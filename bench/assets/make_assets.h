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

/// `count` assets in `folder`, every one with another mesh: `bases` are baked, the others are variants of these. What
/// is there under its name is taken for what it is; nothing else is touched. Throws Error or Cancelled.
void make_assets(const std::filesystem::path& folder, int count, int bases, const BakeContext& context);

/// What make_assets() has made.
AssetFiles find_assets(const std::filesystem::path& folder, int count, int bases);

}  // namespace encage::assets

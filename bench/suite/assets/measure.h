// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/suite/assets/scene.h"

#include <encage/shape_cache.h>

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace encage::assets {

/// A way to keep assets.
struct Way {
  std::string name;
  LoadMode mode = LoadMode::map;
  std::int64_t budget = 0;  ///< 0: everything stays in memory
};

struct AssetRunOptions {
  DriftSceneOptions scene;
  int steps = 300;
  double margin = 0;
  bool cold = false;  ///< asks the system to forget the files before
};

/// One way once, in a process of its own: what it needs until the first answer, per step afterwards, and of memory. The
/// pairs of every step and, now and then, their triangles are hashed. Times are wall clock. Keys as in command.cpp.
nlohmann::ordered_json run_way(const Way& way, const std::vector<std::filesystem::path>& files,
                               const AssetRunOptions& options);

}  // namespace encage::assets

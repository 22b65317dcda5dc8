// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace encage::bullet_bench {

struct SceneArguments {
  std::vector<std::string> scenes, methods;  ///< no methods: all there are
  std::vector<std::int64_t> seeds;           ///< none: the scene's
  double seconds = 0;                        ///< 0: the scene's
  std::int64_t octopus_triangles = 50'000;
  std::filesystem::path poses, json;
  int poses_every = 2;
};

/// Runs the scenes by the methods and reports. True if Encage's contacts, where they are among the methods, make every
/// scene do what it should.
bool run_scenes(const SceneArguments& arguments);

}  // namespace encage::bullet_bench

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/bullet/scene_run.h"

#include <nlohmann/json.hpp>

#include <iosfwd>
#include <string>
#include <vector>

namespace encage::bullet_bench {

/// All runs of a scene by one method.
struct MethodRuns {
  std::string method;
  std::vector<nlohmann::ordered_json> details;  ///< of the shapes, by mesh
  std::vector<SceneRun> runs;                   ///< by seed

  bool holds() const;  ///< in all runs
};

struct SceneResult {
  std::string scene;
  std::vector<std::int64_t> triangles;  ///< by mesh
  std::vector<MethodRuns> methods;
};

/// Lengths in metres, times in milliseconds; medians over the seeds.
nlohmann::ordered_json to_json(const SceneResult& result);
/// A table; lengths in millimetres.
void print(std::ostream& out, const SceneResult& result);

}  // namespace encage::bullet_bench

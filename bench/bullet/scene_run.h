// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/bullet/contact_method.h"
#include "bench/bullet/penetration.h"
#include "bench/bullet/scene_world.h"
#include "bench/bullet/scenes.h"

#include <encage/cage.h>
#include <encage/poses.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace encage::bullet_bench {

/// A scene with what all methods share, and one method's shapes are made for.
class PreparedScene {
 public:
  explicit PreparedScene(Scene scene);

  const Scene scene;
  std::vector<SceneBodyModel> models;                     ///< by mesh
  std::vector<std::unique_ptr<PenetrationProbe>> probes;  ///< by mesh, in its own frame
};

/// One run of a scene by one method.
struct SceneRun {
  std::uint64_t seed = 0;
  double detect_ms = 0, step_ms = 0;                 ///< CPU time, means over the steps
  double last_detect_ms = 0;                         ///< mean of the last second
  double start_penetration = 0;                      ///< before the first step; 0 if the scene is as it should be
  double max_penetration = 0, last_penetration = 0;  ///< metres: largest of all steps, of the last second
  double rms_linear = 0, rms_angular = 0;            ///< of the last second
  double points_per_pair = 0;                        ///< last second: contact points per pair that has one
  double touching_pairs = 0;                         ///< last second, per step
  Verdict verdict;
  Hash pose_hash{};             ///< of the bodies at the end
  std::vector<PoseStep> poses;  ///< every `poses_every`-th step, the start included
};

struct RunOptions {
  double seconds = 0;  ///< at least one; 0: the scene's
  int poses_every = 0;
};

SceneRun run_scene(const PreparedScene& prepared, const ContactMethod& method,
                   const std::vector<std::unique_ptr<MethodShape>>& shapes, std::uint64_t seed,
                   const RunOptions& options);

}  // namespace encage::bullet_bench

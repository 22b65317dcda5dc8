// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/scene_run.h"

#include "bench/common/recorded_poses.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace encage::bullet_bench {
namespace {

constexpr int penetration_every = 2;  // steps, before the last second

double deepest(const PreparedScene& prepared, const std::vector<SceneBody>& bodies,
               const std::vector<Eigen::Isometry3d>& poses) {
  double depth = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const PenetrationProbe& probe = *prepared.probes[bodies[i].mesh];
    for (std::size_t j = 0; j < i; ++j) {
      depth = std::max(depth, penetration(probe, poses[i], *prepared.probes[bodies[j].mesh], poses[j]));
    }
    if (!bodies[i].moves) continue;
    for (const HalfSpace& plane : prepared.scene.planes) depth = std::max(depth, probe.below(poses[i], plane));
  }
  return depth;
}

PoseStep pose_step(std::int64_t step, const std::vector<Eigen::Isometry3d>& poses) {
  PoseStep result{step, {}};
  for (std::size_t i = 0; i < poses.size(); ++i) result.bodies.push_back({static_cast<std::int32_t>(i), poses[i]});
  return result;
}

}  // namespace

PreparedScene::PreparedScene(Scene of) : scene(std::move(of)) {
  for (const TriangleMesh& mesh : scene.meshes) {
    models.emplace_back(mesh);
    probes.push_back(std::make_unique<PenetrationProbe>(mesh));
  }
}

SceneRun run_scene(const PreparedScene& prepared, const ContactMethod& method,
                   const std::vector<std::unique_ptr<MethodShape>>& shapes, std::uint64_t seed,
                   const RunOptions& options) {
  const std::vector<SceneBody> bodies = prepared.scene.place(seed);
  SceneWorld world(prepared.scene, bodies, prepared.models, method, shapes);
  SceneRun run;
  run.seed = seed;
  SceneHistory history;
  const auto record = [&](int step) {
    history.poses.push_back(world.poses());
    if (options.poses_every > 0 && step % options.poses_every == 0) {
      run.poses.push_back(pose_step(step, history.poses.back()));
    }
  };
  record(0);
  run.start_penetration = deepest(prepared, bodies, history.poses.back());
  const double seconds = options.seconds > 0 ? options.seconds : prepared.scene.seconds;
  const int steps = std::max(steps_per_second, static_cast<int>(std::lround(seconds * steps_per_second)));
  StepContacts contacts;
  for (int step = 1; step <= steps; ++step) {
    const bool last_second = step > steps - steps_per_second;
    const StepCost cost = world.step();
    run.detect_ms += cost.detect_ms / steps;
    run.step_ms += cost.step_ms / steps;
    record(step);
    if (last_second || step % penetration_every == 0) {
      const double depth = deepest(prepared, bodies, history.poses.back());
      run.max_penetration = std::max(run.max_penetration, depth);
      if (last_second) run.last_penetration = std::max(run.last_penetration, depth);
      if (step == steps) history.end_penetration = depth;
    }
    if (!last_second) continue;
    run.last_detect_ms += cost.detect_ms / steps_per_second;
    const StepMotion motion = world.motion();
    run.rms_linear += motion.linear / steps_per_second;
    run.rms_angular += motion.angular / steps_per_second;
    const StepContacts now = world.contacts();
    contacts.points += now.points;
    contacts.pairs += now.pairs;
  }
  run.rms_linear = std::sqrt(run.rms_linear);
  run.rms_angular = std::sqrt(run.rms_angular);
  run.touching_pairs = static_cast<double>(contacts.pairs) / steps_per_second;
  run.points_per_pair =
      contacts.pairs > 0 ? static_cast<double>(contacts.points) / static_cast<double>(contacts.pairs) : 0;
  run.verdict = prepared.scene.judge(history);
  run.pose_hash = bench::trajectory_hash({pose_step(steps, history.poses.back())});
  return run;
}

}  // namespace encage::bullet_bench

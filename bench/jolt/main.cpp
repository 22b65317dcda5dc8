// SPDX-License-Identifier: GPL-3.0-or-later
// encage-jolt: scenes of concave bodies in a Jolt world, with the adapter's contacts.

#include "bench/bullet/scene_report.h"
#include "bench/bullet/scene_run.h"
#include "bench/bullet/scenes.h"
#include "bench/common/command.h"
#include "bench/common/recorded_poses.h"
#include "bench/jolt/jolt_world.h"
#include "cagegen/cli/output_file.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <utility>

namespace encage::jolt_bench {
namespace {

using bullet_bench::steps_per_second;

constexpr const char* examples = R"(Examples:
  encage-jolt
  encage-jolt --scene bowls --settings default --seed 1 --json bowls.json

The scenes of encage-bullet in a world of Jolt's on one thread, in steps of 1/60 s. "default" has Jolt's settings as
they are; "fine" lets bodies sink into each other by 1 mm instead of 2 cm. "merged" is "default" with bodies whose
manifolds Jolt merges.

Exit status: 0; 1 if a scene does not hold with "fine"; 2 for bad input or usage.)";

const std::vector<JoltSettings>& all_settings() {
  static const std::vector<JoltSettings> all = {
      {.name = "default", .description = "Jolt's settings"},
      {.name = "fine", .description = "mPenetrationSlop 1 mm", .penetration_slop = 0.001},
      {.name = "merged", .description = "Jolt's settings, manifolds merged", .reduces = true},
  };
  return all;
}

struct JoltArguments {
  std::vector<std::string> scenes = {"chain", "bowls", "thin_bowls"};
  std::vector<std::string> settings = {"default", "fine"};
  std::vector<std::int64_t> seeds;
  double seconds = 0;
  std::int64_t octopus_triangles = 50'000;
  std::filesystem::path json;
};

double deepest(const bullet_bench::PreparedScene& prepared, const std::vector<bullet_bench::SceneBody>& bodies,
               const std::vector<Eigen::Isometry3d>& poses) {
  double depth = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto probe = [&](std::size_t k) -> const bullet_bench::PenetrationProbe& {
      return *prepared.probes[static_cast<std::size_t>(bodies[k].mesh)];
    };
    for (std::size_t j = 0; j < i; ++j) depth = std::max(depth, penetration(probe(i), poses[i], probe(j), poses[j]));
    if (!bodies[i].moves) continue;
    for (const HalfSpace& plane : prepared.scene.planes) depth = std::max(depth, probe(i).below(poses[i], plane));
  }
  return depth;
}

bullet_bench::SceneRun run_scene(const bullet_bench::PreparedScene& prepared, const JoltSettings& settings,
                                 std::uint64_t seed, double seconds) {
  const std::vector<bullet_bench::SceneBody> bodies = prepared.scene.place(seed);
  JoltWorld world(prepared.scene, bodies, settings);
  bullet_bench::SceneRun run;
  run.seed = seed;
  bullet_bench::SceneHistory history;
  history.poses.push_back(world.poses());
  run.start_penetration = deepest(prepared, bodies, history.poses.back());
  if (!(seconds > 0)) seconds = prepared.scene.seconds;
  const int steps = std::max(steps_per_second, static_cast<int>(std::lround(seconds * steps_per_second)));
  bullet_bench::StepContacts contacts;
  for (int step = 1; step <= steps; ++step) {
    const bool last_second = step > steps - steps_per_second;
    const bullet_bench::StepCost cost = world.step();
    run.detect_ms += cost.detect_ms / steps;
    run.step_ms += cost.step_ms / steps;
    history.poses.push_back(world.poses());
    if (last_second || step % 2 == 0) {
      const double depth = deepest(prepared, bodies, history.poses.back());
      run.max_penetration = std::max(run.max_penetration, depth);
      if (last_second) run.last_penetration = std::max(run.last_penetration, depth);
      if (step == steps) history.end_penetration = depth;
    }
    if (!last_second) continue;
    run.last_detect_ms += cost.detect_ms / steps_per_second;
    const bullet_bench::StepMotion motion = world.motion();
    run.rms_linear += motion.linear / steps_per_second;
    run.rms_angular += motion.angular / steps_per_second;
    const bullet_bench::StepContacts now = world.contacts();
    contacts.points += now.points;
    contacts.pairs += now.pairs;
  }
  run.rms_linear = std::sqrt(run.rms_linear);
  run.rms_angular = std::sqrt(run.rms_angular);
  run.touching_pairs = static_cast<double>(contacts.pairs) / steps_per_second;
  if (contacts.pairs > 0) {
    run.points_per_pair = static_cast<double>(contacts.points) / static_cast<double>(contacts.pairs);
  }
  run.verdict = prepared.scene.judge(history);
  PoseStep end{steps, {}};
  for (std::size_t i = 0; i < history.poses.back().size(); ++i) {
    end.bodies.push_back({static_cast<std::int32_t>(i), history.poses.back()[i]});
  }
  run.pose_hash = bench::trajectory_hash({end});
  return run;
}

void define(bench::CommandOptions& options, JoltArguments& a) {
  std::vector<std::string> names;
  for (const JoltSettings& settings : all_settings()) names.push_back(settings.name);
  options.add("--scene", a.scenes, "Scenes")
      .one_of(bullet_bench::scene_names())
      .shows_default("chain,bowls,thin_bowls")
      .type("NAME,…");
  options.add("--settings", a.settings, "Of Jolt").one_of(names).shows_default("default,fine").type("NAME,…");
  options.add("--seed", a.seeds, "Medians count. Else three of each scene").type("N,…");
  options.add("--seconds", a.seconds, "Simulated. Else 10, of the nut 5").within(1, 1e4).type("S");
  options.add("--triangles", a.octopus_triangles, "Of the heap's octopus").shows_default().type("N");
  options.json(a.json);
}

bool run(JoltArguments& a) {
  std::cout << "Steps of 1/60 s, gravity 9.81; medians over the seeds.\n";
  bool holds = true;
  nlohmann::ordered_json json;
  for (const std::string& name : a.scenes) {
    const bullet_bench::PreparedScene prepared(bullet_bench::make_contact_scene(name, a.octopus_triangles));
    bullet_bench::SceneResult result{name, {}, {}};
    for (const TriangleMesh& mesh : prepared.scene.meshes) result.triangles.push_back(mesh.triangles.rows());
    std::vector<std::uint64_t> seeds(a.seeds.begin(), a.seeds.end());
    if (seeds.empty()) seeds = prepared.scene.seeds;
    for (const JoltSettings& settings : all_settings()) {
      if (std::find(a.settings.begin(), a.settings.end(), settings.name) == a.settings.end()) continue;
      bullet_bench::MethodRuns runs{settings.name, {}, {}};
      runs.details.resize(prepared.scene.meshes.size());
      for (const std::uint64_t seed : seeds) runs.runs.push_back(run_scene(prepared, settings, seed, a.seconds));
      if (settings.name == "fine") holds &= runs.holds();
      json["settings"][settings.name] = settings.description;
      result.methods.push_back(std::move(runs));
    }
    print(std::cout, result);
    std::cout.flush();
    json["scenes"][name] = to_json(result);
  }
  if (!a.json.empty()) tool::write_json(a.json, json);
  return holds;
}

}  // namespace
}  // namespace encage::jolt_bench

int main(int argc, char** argv) {
  using namespace encage;
  return bench::run_command(
      bench::make_command<jolt_bench::JoltArguments>("encage-jolt", "Concave bodies in a Jolt world.",
                                                     jolt_bench::examples, jolt_bench::define, jolt_bench::run),
      argc, argv);
}

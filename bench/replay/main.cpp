// SPDX-License-Identifier: GPL-3.0-or-later
// encage-replay: recorded poses through collision engines, alone and behind Encage's tests.

#include "bench/common/command.h"
#include "bench/common/recorded_poses.h"
#include "bench/common/watch.h"
#include "bench/replay/continuous.h"
#include "bench/replay/engines.h"
#include "bench/replay/exact_touch.h"
#include "bench/replay/mesh_shape.h"
#include "bench/replay/replay.h"
#include "bench/replay/replay_report.h"
#include "cagegen/cli/output_file.h"

#include <encage/error.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace encage::replay {
namespace {

constexpr const char* examples = R"(Examples:
  encage-replay --mesh octopus.off --cages octopus.glb --poses bouncing.csv --every 40 --json replay.json
      which pairs of octopuses touch at every fortieth step, by every engine, alone and behind our tests
  encage-replay --mesh octopus.off --poses bouncing.csv --engines encage,fcl --continuous
      also how long Encage takes for the motion from each step to the next

Columns: "/ Encage": how many times slower than Encage alone; "with cages", "with full": behind our cages or our whole
test, and the gain; "perfect": behind a test that knows which pairs touch, and the gain, which no test can exceed;
"missed", "spurious": against exact arithmetic.

Exit status: 0 if all agree on the touching pairs, 1 if not, 2 for bad input or usage.)";

struct ReplayArguments {
  std::filesystem::path mesh, cages, poses, json;
  std::vector<std::string> engines = {"encage", "fcl", "fcl_obb", "fcl_float", "bullet", "ode", "embree"};
  std::vector<std::string> fronts = {"cages", "full"};
  std::int64_t every = 1;
  int runs = 3;
  int level = 0;
  bool continuous = false;
  bool free = false;
};

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ",") + name;
  return text;
}

void define(bench::CommandOptions& options, ReplayArguments& a) {
  options.add("--mesh", a.mesh, "Mesh of all bodies").required().type("FILE");
  options.add("--cages", a.cages, "Asset that encage bake made of the mesh").type("FILE.glb");
  options.poses(a.poses);
  options.add("--engines", a.engines, "Engines, separated by commas; embree: both ways to update its trees")
      .one_of(engine_names())
      .shows_default(joined(a.engines))
      .type(joined(engine_names()));
  options
      .add("--front", a.fronts,
           "What is asked before an engine: Encage's cages, or its full test; none: neither. Cages need --cages")
      .one_of({"cages", "full", "none"})
      .shows_default(joined(a.fronts))
      .type("cages,full,none");
  options.flag("--continuous", a.continuous, "Also Encage's continuous detection, from each step to the next one");
  options.flag("--free", a.free,
               "Leave out pairs that touch in the recorded step before, or in the first one, as if no bodies ever "
               "interpenetrated");
  options.every(a.every);
  options.runs(a.runs, "Runs; the median time of each step counts");
  options.add("--cage-level", a.level, "Cage level asked, 0 the finest").between(0, 63).type("K");
  options.json(a.json);
}

using Pairs = std::vector<BodyPair>;

/// What happens in the steps that are taken.
struct ReplayScene {
  std::vector<PoseStep> steps;
  std::vector<Pairs> touching;  ///< per step, sorted
  std::vector<Pairs> before;    ///< in the recorded step before it, or in the first one; only if asked for
};

ReplayScene make_scene(const ReplayArguments& a, const std::vector<PoseStep>& poses, const ReplayBody& body,
                       const std::function<void(double fraction)>& progress) {
  const ExactTouch exact(body.mesh, body.closed);
  ReplayScene scene;
  for (std::size_t i = 0; i < poses.size(); i += static_cast<std::size_t>(a.every)) {
    scene.steps.push_back(poses[i]);
    scene.touching.push_back(exact.touching(poses[i]));
    if (a.free) scene.before.push_back(i == 0 ? scene.touching.back() : exact.touching(poses[i - 1]));
    progress(static_cast<double>(i + 1) / static_cast<double>(poses.size()));
  }
  return scene;
}

/// What engines are asked, and what is true.
PairQuestion question_of(const ReplayScene& scene) {
  PairQuestion question{scene.steps, scene.touching, scene.before, {}};
  for (std::size_t i = 0; i < scene.before.size(); ++i) {
    std::erase_if(question.truth[i], [&](const BodyPair& pair) {
      return std::binary_search(scene.before[i].begin(), scene.before[i].end(), pair);
    });
  }
  return question;
}

/// Tests of ours that there are.
class Fronts {
 public:
  Fronts(const ReplayArguments& a, const ReplayBody& body) : cages_(body.shape, a.level), full_(body.shape) {
    const auto asked = [&](const char* name) { return std::count(a.fronts.begin(), a.fronts.end(), name) > 0; };
    if (asked("cages") && !a.cages.empty()) list_.push_back({"cages", &cages_});
    if (asked("full")) list_.push_back({"full", &full_});
  }
  Fronts(const Fronts&) = delete;
  Fronts& operator=(const Fronts&) = delete;

  const std::vector<Front>& list() const { return list_; }

 private:
  CageGate cages_;
  FineGate full_;
  std::vector<Front> list_;
};

void check_level(const ReplayArguments& a, const ReplayBody& body) {
  if (a.cages.empty() || a.level < body.levels) return;
  throw Error("--cage-level " + std::to_string(a.level) + ": there are only " + std::to_string(body.levels) +
              " levels");
}

std::vector<std::unique_ptr<Engine>> all_engines(const ReplayArguments& a, const ReplayBody& body) {
  std::vector<std::unique_ptr<Engine>> engines;
  for (const std::string& name : a.engines) {
    for (std::unique_ptr<Engine>& engine : make_engines(name, body)) engines.push_back(std::move(engine));
  }
  return engines;
}

bool run(ReplayArguments& a) {
  bench::check_outputs({a.json}, {a.mesh, a.cages, a.poses});
  const std::vector<PoseStep> poses = read_poses(a.poses);
  std::optional<bench::Recording> recording;
  if (a.continuous) recording = bench::recording_of(poses, 1, a.every, a.poses.string());
  const ReplayBody body = load_body(a.mesh, a.cages);
  check_level(a, body);
  const Fronts fronts(a, body);

  bench::Watch watch;
  const ReplayScene scene = make_scene(a, poses, body, watch.reporter("exact arithmetic"));
  PairQuestion question = question_of(scene);
  question.fronts = fronts.list();
  question.runs = a.runs;
  const Replay result = replay(all_engines(a, body), question, watch.reporter("replaying"));
  std::optional<Continuous> moving;
  if (recording) moving = continuous(*body.shape, *recording, scene.touching, a.runs, watch.reporter("continuous"));

  if (!a.json.empty()) {
    nlohmann::ordered_json json = {{"mesh", a.mesh.string()}, {"poses", a.poses.string()}, {"every", a.every}};
    if (!a.cages.empty()) json["cage_level"] = a.level;
    json.update(to_json(result, moving));
    tool::write_json(a.json, json);
  }
  std::cout << a.poses.filename().string() << ": " << result.steps << " steps, one thread, median of " << a.runs
            << " runs\n\n";
  print(std::cout, result, moving);
  // On stderr: it is why the status is not 0.
  print(std::cerr, "encage-replay: ", result.disagreements);
  return result.disagreements.empty();
}

}  // namespace
}  // namespace encage::replay

int main(int argc, char** argv) {
  using namespace encage;
  return bench::run_command(
      bench::make_command<replay::ReplayArguments>(
          "encage-replay",
          "Replays recorded poses through collision engines: which pairs touch, and how long it takes.",
          replay::examples, replay::define, replay::run),
      argc, argv);
}

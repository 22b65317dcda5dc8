// SPDX-License-Identifier: GPL-3.0-or-later
// encage-replay: recorded poses through collision engines, alone and behind Encage's cage test.

#include <encage/error.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "bench/replay/encage_engine.h"
#include "bench/replay/fcl_engine.h"
#include "bench/replay/mesh_shape.h"
#include "bench/replay/replay.h"
#include "cagegen/tool/interrupt.h"
#include "cagegen/tool/output_file.h"
#include "cagegen/tool/program.h"
#include "cagegen/tool/progress.h"

namespace encage::replay {
namespace {

constexpr const char* examples = R"(Examples:
  encage-replay --mesh octopus.off --cages octopus.glb --poses bouncing.csv --every 10 --json replay.json
      which pairs of octopuses touch at every tenth step, by every engine, alone and behind the cages
  encage-replay --mesh octopus.off --poses bouncing.csv --engines encage,fcl

Exit status: 0 if all agree on the touching pairs, 1 if not, 2 for bad input or usage.)";

struct Arguments {
  std::filesystem::path mesh, cages, poses, json;
  std::vector<std::string> engines = {"encage", "fcl"};
  std::int64_t every = 1;
  int runs = 3;
  int level = 0;
};

void define(CLI::App& app, Arguments& a) {
  app.footer(examples);
  app.add_option("--mesh", a.mesh, "Mesh of all bodies")->required()->type_name("FILE");
  app.add_option("--cages", a.cages, "Asset that encage bake made of the mesh; without, engines run alone")
      ->type_name("FILE.glb");
  app.add_option("--poses", a.poses, "Poses of the bodies, step by step")->required()->type_name("FILE.csv");
  app.add_option("--engines", a.engines, "Engines, separated by commas")
      ->delimiter(',')
      ->check(CLI::IsMember({"encage", "fcl"}).description(""))
      ->capture_default_str()
      ->type_name("encage,fcl");
  app.add_option("--every", a.every, "Take every K-th step only")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000'000}).description(""))
      ->type_name("K");
  app.add_option("--runs", a.runs, "Runs; the median time of each step counts")
      ->check(CLI::Range(1, 1000).description(""))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--cage-level", a.level, "Cage level asked, 0 the finest")
      ->check(CLI::Range(0, 63).description(""))
      ->type_name("K");
  app.add_option("--json", a.json, "Write everything as JSON")->type_name("FILE");
}

std::unique_ptr<Engine> make_engine(const std::string& name, const Body& body) {
  if (name == "encage") return std::make_unique<EncageEngine>(body.shape);
  return std::make_unique<FclEngine>(body.mesh);
}

std::vector<PoseStep> steps_of(const Arguments& a) {
  const std::vector<PoseStep> all = read_poses(a.poses);
  std::vector<PoseStep> steps;
  for (std::size_t i = 0; i < all.size(); i += static_cast<std::size_t>(a.every)) steps.push_back(all[i]);
  return steps;
}

nlohmann::ordered_json to_json(const Arguments& a, const Replay& replay) {
  nlohmann::ordered_json json = {{"mesh", a.mesh.string()}, {"poses", a.poses.string()}, {"steps", replay.steps}};
  if (!a.cages.empty()) json["cage_level"] = a.level;
  for (const EngineResult& engine : replay.engines) {
    json["engines"][engine.name] = {{"ms_per_step", engine.ms_per_step}, {"touching_pairs", engine.touching}};
    if (engine.with_cages_ms) json["with_cages"][engine.name] = {{"ms_per_step", *engine.with_cages_ms}};
  }
  json["disagreements"] = replay.disagreements.size();
  json["disagreeing_pairs"] = nlohmann::ordered_json::array();
  for (const Disagreement& d : replay.disagreements) {
    json["disagreeing_pairs"].push_back(
        {{"step", d.step}, {"body_a", d.pair.a}, {"body_b", d.pair.b}, {"touching", d.touching}});
  }
  return json;
}

void print(const Arguments& a, const Replay& replay) {
  std::cout << a.poses.string() << ": " << replay.steps << " steps, one thread\n\n"
            << "engine          ms/step   with cages    ratio   touching pairs\n";
  for (const EngineResult& engine : replay.engines) {
    std::array<char, 128> line;
    const double with = engine.with_cages_ms.value_or(0);
    std::snprintf(line.data(), line.size(), "%-10s %12.4f %12.4f %8.3f %16lld\n", engine.name.c_str(),
                  engine.ms_per_step, with, with > 0 ? engine.ms_per_step / with : 0,
                  static_cast<long long>(engine.touching));
    std::cout << line.data();
  }
}

// On stderr: it is why the status is not 0.
void print_disagreements(const std::vector<Disagreement>& disagreements) {
  for (const Disagreement& d : disagreements) {
    std::cerr << "encage-replay: step " << d.step << ", bodies " << d.pair.a << " and " << d.pair.b << " touch only by";
    for (const std::string& name : d.touching) std::cerr << ' ' << name;
    std::cerr << '\n';
  }
}

int run(const Arguments& a) {
  const tool::InterruptScope scope;
  for (const auto& read : {a.mesh, a.cages, a.poses}) {
    if (!a.json.empty()) tool::check_output(a.json, read);
  }
  const std::vector<PoseStep> steps = steps_of(a);
  const Body body = load_body(a.mesh, a.cages);
  if (!a.cages.empty() && a.level >= body.levels) {
    throw Error("--cage-level " + std::to_string(a.level) + ": there are only " + std::to_string(body.levels) +
                " levels");
  }
  std::vector<std::unique_ptr<Engine>> engines;
  for (const std::string& name : a.engines) engines.push_back(make_engine(name, body));
  const CageGate gate(body.shape, a.level);

  tool::Progress progress = tool::Progress::on_stderr();
  const Replay result = replay(engines, a.cages.empty() ? nullptr : &gate, steps, a.runs, [&](double fraction) {
    progress.update(fraction, "replaying");
    tool::throw_if_interrupted();
  });
  if (!a.json.empty()) tool::write_json(a.json, to_json(a, result));
  print(a, result);
  print_disagreements(result.disagreements);
  return result.disagreements.empty() ? tool::success : tool::answer_is_no;
}

}  // namespace
}  // namespace encage::replay

int main(int argc, char** argv) {
  CLI::App app("Replays recorded poses through collision engines: which pairs touch, and how long it takes.",
               "encage-replay");
  encage::replay::Arguments a;
  encage::replay::define(app, a);
  return encage::tool::run_program(app, argc, argv, [&] { return encage::replay::run(a); });
}

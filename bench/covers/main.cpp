// SPDX-License-Identifier: GPL-3.0-or-later
// encage-covers: what proves most pairs of bodies apart in the least time.

#include "bench/covers/report.h"
#include "broadphase/shape/shape.h"
#include "cagegen/cli/interrupt.h"
#include "cagegen/cli/output_file.h"
#include "cagegen/cli/program.h"
#include "cagegen/cli/progress.h"

#include <encage/error.h>

#include <CLI/CLI.hpp>

#include <filesystem>
#include <iostream>
#include <string>

namespace encage::covers {
namespace {

constexpr const char* examples = R"(Examples:
  encage-covers --asset octopus.glb --poses bouncing.csv --every 40 --json covers.json
      all pairs of octopuses whose world boxes overlap in every fortieth step, at rest and on the way to the next step

Cages: the asset's. Balls, boxes: around parts of the fine mesh, from the top of its tree. Times are those of surfaces
proven apart; what all share, e.g. the pair's common frame, is made before, and whether one body lies wholly inside the
other is not asked.

Exit status: 0; 1 if something proves resting bodies apart that the fine mesh does not; 2 for bad input or usage.)";

struct Arguments {
  std::filesystem::path asset, poses, json;
  CoverSizes sizes;
  std::int64_t every = 1;
  int runs = 5;
};

void define_sizes(CLI::App& app, const std::string& name, const std::string& what, std::vector<std::int64_t>& sizes) {
  app.add_option(name, sizes, "Numbers of " + what + ", separated by commas, at least")
      ->delimiter(',')
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{100'000'000}).description(""))
      ->capture_default_str()
      ->type_name("N,...");
}

void define(CLI::App& app, Arguments& a) {
  app.footer(examples);
  app.add_option("--asset", a.asset, "Asset of all bodies, with its fine mesh")->required()->type_name("FILE.glb");
  app.add_option("--poses", a.poses, "Poses of the bodies, step by step")->required()->type_name("FILE.csv");
  app.add_option("--every", a.every, "Take every K-th step only")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000'000}).description(""))
      ->type_name("K");
  app.add_option("--runs", a.runs, "Runs; the median time of each step counts")
      ->check(CLI::Range(1, 1000).description(""))
      ->capture_default_str()
      ->type_name("N");
  define_sizes(app, "--balls", "balls", a.sizes.balls);
  define_sizes(app, "--boxes", "boxes", a.sizes.boxes);
  app.add_option("--json", a.json, "Write everything as JSON")->type_name("FILE");
}

int run(const Arguments& a) {
  const tool::InterruptScope scope;
  for (const auto& read : {a.asset, a.poses}) {
    if (!a.json.empty()) tool::check_output(a.json, read);
  }
  const std::vector<PoseStep> poses = read_poses(a.poses);
  const ShapePtr shape = load_shape(a.asset);
  if (shape->simple().fine.empty()) throw Error(a.asset.string() + ": holds no fine mesh");
  const PairLists resting = make_pairs(*shape, poses, a.every, false);
  const PairLists moving = make_pairs(*shape, poses, a.every, true);
  const Contestants contestants = make_contestants(*shape, a.sizes);

  tool::Progress progress = tool::Progress::on_stderr();
  const auto report = [&](const char* what) {
    return [&progress, what](double fraction) {
      progress.update(fraction, what);
      tool::throw_if_interrupted();
    };
  };
  const Comparison at_rest = compare(contestants, resting, a.runs, report("resting"));
  const Comparison in_motion = compare(contestants, moving, a.runs, report("moving"));
  if (!a.json.empty()) {
    tool::write_json(a.json, {{"asset", a.asset.string()},
                              {"poses", a.poses.string()},
                              {"every", a.every},
                              {"runs", a.runs},
                              {"resting", to_json(at_rest)},
                              {"moving", to_json(in_motion)}});
  }
  print(std::cout, "At rest", at_rest);
  print(std::cout, "Moving to the next step", in_motion);
  if (at_rest.doubtful() == 0) return tool::success;
  std::cerr << "encage-covers: " << at_rest.doubtful() << " answers prove resting bodies apart that touch\n";
  return tool::answer_is_no;
}

}  // namespace
}  // namespace encage::covers

int main(int argc, char** argv) {
  CLI::App app("Compares what proves bodies apart: cages, covers of balls or boxes, the fine mesh.", "encage-covers");
  encage::covers::Arguments a;
  encage::covers::define(app, a);
  return encage::tool::run_program(app, argc, argv, [&] { return encage::covers::run(a); });
}

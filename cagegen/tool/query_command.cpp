// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/output_file.h"
#include "cagegen/tool/command.h"

#include <encage/asset.h>
#include <encage/poses.h>
#include <encage/separated.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

namespace encage::tool {
namespace {

constexpr const char* query_examples = R"(Examples:
  encage query octopus.glb --poses bouncing.csv
      every body of the pose file is an octopus
  encage query mug.glb spoon.glb --poses table.csv --margin 0.001 --json table.json
      the body with the lowest number is a mug, every other one a spoon; pairs that
      stay farther apart than 1 mm count as rejected; one JSON entry per step

Pose file: CSV, header step,body,x,y,z,qx,qy,qz,qw, one row per body present in a step.
Stages are asked in order: boxes, cages from coarse to fine, fine meshes; a stage is
asked only about pairs that no earlier one has rejected. A pair that no stage rejects
counts as touching: it touches as far as double precision can tell.

JSON: levels[] {faces_a, faces_b}, fine to coarse; steps[] {step, pairs, boxes, cages[],
touching}: pairs left over after each stage, cages[] in the order of levels[]; totals:
the sums over all steps and, as steps, their number.)";

struct QueryArguments {
  std::filesystem::path asset_a, asset_b, poses, json;
  bool continuous = false;
  bool per_step = false;
  double margin = 0;
  std::int64_t every = 1;
};

/// Pairs that are left over after each stage.
struct StageCounts {
  std::int64_t pairs = 0;
  std::int64_t boxes = 0;
  std::vector<std::int64_t> cages;  ///< fine to coarse
  std::int64_t touching = 0;

  explicit StageCounts(std::size_t levels) : cages(levels) {}

  void add(const Verdict& verdict) {
    ++pairs;
    if (verdict.separated && verdict.stage == Stage::box) return;
    ++boxes;
    for (std::size_t k = 0; k < cages.size(); ++k) {
      const bool rejected =
          verdict.separated && verdict.stage == Stage::cage && static_cast<std::size_t>(verdict.level) >= k;
      cages[k] += !rejected;
    }
    touching += !verdict.separated;
  }

  void add(const StageCounts& other) {
    pairs += other.pairs;
    boxes += other.boxes;
    for (std::size_t k = 0; k < cages.size(); ++k) cages[k] += other.cages[k];
    touching += other.touching;
  }
};

struct StepCounts {
  std::int64_t step = 0;
  StageCounts counts;
};

struct Level {
  std::int64_t faces_a = 0, faces_b = 0;
};

struct QueryResult {
  std::vector<Level> levels;  ///< fine to coarse; the shorter list goes on with its coarsest
  std::vector<StepCounts> steps;
  StageCounts totals{0};
};

std::vector<Level> paired_levels(const Shape& a, const Shape& b) {
  const auto faces = [](const Shape& shape, int k) -> std::int64_t {
    const int count = level_count(shape);
    return count > 0 ? level_triangles(shape, std::min(k, count - 1)) : 0;
  };
  std::vector<Level> levels;
  for (int k = 0; k < std::max(level_count(a), level_count(b)); ++k) levels.push_back({faces(a, k), faces(b, k)});
  return levels;
}

struct MovingBody {
  const Shape* shape;
  Motion motion;
};

/// The bodies of a step; in continuous mode those that the next step has as well. Throws Error for a motion that is no
/// motion of a step; `file` names the poses.
std::vector<MovingBody> bodies_of(const PoseStep& step, const PoseStep* next, const Shape& first, const Shape& others,
                                  std::int32_t first_body, const std::string& file) {
  std::vector<MovingBody> bodies;
  for (const BodyPose& body : step.bodies) {
    const Shape& shape = body.body == first_body ? first : others;
    if (!next) {
      bodies.push_back({&shape, Motion::resting(body.pose)});
      continue;
    }
    const auto end = std::lower_bound(next->bodies.begin(), next->bodies.end(), body.body,
                                      [](const BodyPose& p, std::int32_t number) { return p.body < number; });
    if (end == next->bodies.end() || end->body != body.body) continue;
    const Motion motion = {body.pose, end->pose};
    if (!is_usable(motion)) {
      throw Error(file + ": step " + std::to_string(step.step) + ": body " + std::to_string(body.body) +
                  " turns by 180 degrees or more until the next step");
    }
    bodies.push_back({&shape, motion});
  }
  return bodies;
}

QueryResult query(const QueryArguments& a) {
  const std::vector<PoseStep> poses = read_poses(a.poses == "-" ? "/dev/stdin" : a.poses);
  const ShapePtr first = load_shape(a.asset_a);
  const ShapePtr others = a.asset_b.empty() ? first : load_shape(a.asset_b);
  std::int32_t first_body = poses.front().bodies.front().body;
  for (const PoseStep& step : poses) first_body = std::min(first_body, step.bodies.front().body);

  QueryResult result;
  result.levels = paired_levels(*first, *others);
  result.totals = StageCounts(result.levels.size());
  const std::size_t end = a.continuous ? poses.size() - 1 : poses.size();
  for (std::size_t i = 0; i < end; i += static_cast<std::size_t>(a.every)) {
    const std::vector<MovingBody> bodies =
        bodies_of(poses[i], a.continuous ? &poses[i + 1] : nullptr, *first, *others, first_body, a.poses.string());
    StageCounts counts(result.levels.size());
    for (std::size_t p = 0; p < bodies.size(); ++p) {
      for (std::size_t q = p + 1; q < bodies.size(); ++q) {
        counts.add(separated(*bodies[p].shape, bodies[p].motion, *bodies[q].shape, bodies[q].motion,
                             {.margin = a.margin, .cages = CageUse::always}));
      }
    }
    result.totals.add(counts);
    result.steps.push_back({poses[i].step, counts});
  }
  return result;
}

std::string fixed(double value) {
  std::array<char, 64> text;
  std::snprintf(text.data(), text.size(), "%12.3f", value);
  return text.data();
}

std::string padded(std::string text) {
  text.resize(std::max<std::size_t>(text.size(), 34), ' ');
  return text;
}

std::string name_of(const Level& level) {
  std::string name = "cages of " + std::to_string(level.faces_a);
  if (level.faces_b != level.faces_a) name += " and " + std::to_string(level.faces_b);
  return name + " faces";
}

void print_means(const QueryArguments& a, const QueryResult& result) {
  std::cout << a.poses.string() << ": " << result.steps.size() << " steps"
            << (a.continuous ? ", moving to the next" : "") << ", margin " << a.margin << "\n\n"
            << padded("pairs per step, mean") << "        left    rejected\n";
  const double steps = static_cast<double>(std::max<std::size_t>(1, result.steps.size()));
  double before = static_cast<double>(result.totals.pairs);
  const auto row = [&](const std::string& stage, std::int64_t left) {
    const double now = static_cast<double>(left);
    std::cout << padded(stage) << fixed(now / steps) << fixed((before - now) / steps) << '\n';
    before = now;
  };
  std::cout << padded("all") << fixed(before / steps) << '\n';
  row("boxes", result.totals.boxes);
  for (std::size_t k = result.levels.size(); k-- > 0;) row(name_of(result.levels[k]), result.totals.cages[k]);
  row("fine meshes (left: touching)", result.totals.touching);
}

void print_steps(const QueryResult& result) {
  std::cout << "step,pairs,boxes";
  for (std::size_t k = result.levels.size(); k-- > 0;) std::cout << ",cages_" << result.levels[k].faces_a;
  std::cout << ",touching\n";
  for (const StepCounts& s : result.steps) {
    std::cout << s.step << ',' << s.counts.pairs << ',' << s.counts.boxes;
    for (std::size_t k = result.levels.size(); k-- > 0;) std::cout << ',' << s.counts.cages[k];
    std::cout << ',' << s.counts.touching << '\n';
  }
}

nlohmann::ordered_json to_json(const StageCounts& counts) {
  return {{"pairs", counts.pairs}, {"boxes", counts.boxes}, {"cages", counts.cages}, {"touching", counts.touching}};
}

nlohmann::ordered_json to_json(const QueryArguments& a, const QueryResult& result) {
  nlohmann::ordered_json json = {{"asset_a", a.asset_a.string()},
                                 {"asset_b", a.asset_b.empty() ? a.asset_a.string() : a.asset_b.string()},
                                 {"poses", a.poses.string()},
                                 {"continuous", a.continuous},
                                 {"margin", a.margin}};
  json["levels"] = nlohmann::ordered_json::array();
  for (const Level& level : result.levels) {
    json["levels"].push_back({{"faces_a", level.faces_a}, {"faces_b", level.faces_b}});
  }
  json["steps"] = nlohmann::ordered_json::array();
  for (const StepCounts& s : result.steps) {
    nlohmann::ordered_json step = {{"step", s.step}};
    step.update(to_json(s.counts));
    json["steps"].push_back(std::move(step));
  }
  json["totals"] = {{"steps", result.steps.size()}};
  json["totals"].update(to_json(result.totals));
  return json;
}

void run(const QueryArguments& a) {
  if (!(a.margin >= 0) || std::isinf(a.margin)) throw Error("--margin: must be a finite distance, 0 or more");
  if (a.every < 1) throw Error("--every: must be 1 or more");
  for (const std::filesystem::path& input : {a.asset_a, a.asset_b, a.poses}) {
    if (!a.json.empty()) check_output(a.json, input);
  }
  const QueryResult result = query(a);
  if (!a.json.empty()) write_json(a.json, to_json(a, result));
  if (a.per_step) {
    print_steps(result);
  } else {
    print_means(a, result);
  }
}

}  // namespace

void add_query(CLI::App& app, int& /*status*/) {
  CLI::App* query_app =
      app.add_subcommand("query", "Reject pairs of bodies on recorded poses; count what each stage rejects");
  query_app->footer(query_examples);
  const auto a = std::make_shared<QueryArguments>();
  query_app->add_option("A", a->asset_a, "Asset written by encage bake")->required()->type_name("A.glb");
  query_app->add_option("B", a->asset_b, "Asset of all bodies but the one with the lowest number")->type_name("B.glb");
  query_app->add_option("--poses", a->poses, "Poses of the bodies, step by step; - for standard input")
      ->required()
      ->type_name("FILE.csv");
  query_app->add_flag(
      "--continuous", a->continuous,
      "Each step stands for the motion to the next one: a pair is rejected if it stays apart all the way");
  query_app->add_option("--margin", a->margin, "Distance that has to be exceeded, in the unit of the assets")
      ->type_name("M");
  query_app->add_option("--every", a->every, "Take every K-th step only")->type_name("K");
  query_app->add_flag("--per-step", a->per_step, "Print CSV with one line per step instead of the means");
  add_json(*query_app, a->json, "Write the counts of every step as JSON; without FILE instead of the text");
  query_app->callback([a] { run(*a); });
}

}  // namespace encage::tool

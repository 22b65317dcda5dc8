// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench scale: which boxes overlap, of up to 100,000 bodies that move?

#include "bench/common/report.h"
#include "bench/common/statistics.h"
#include "bench/common/watch.h"
#include "bench/suite/commands.h"
#include "bench/suite/scale/measure.h"
#include "cagegen/cli/output_file.h"
#include "oracles/meshes.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>

namespace encage::scale {
namespace {

constexpr const char* examples = R"(Examples:
  encage-bench scale --scene gas --json gas.json
      1,000 to 100,000 bodies, all moving, in all engines
  encage-bench scale --bodies 10000 --asset octopus.glb --engines encage,encage_full
      the world's boxes, and the whole search

Times of the other engines are without the computation of the boxes, which they are given.
Exit status: 0 if all engines found the same pairs, 1 if not, 2 for bad input or usage.)";

struct ScaleArguments {
  std::vector<std::int64_t> bodies = {1000, 3000, 10'000, 30'000, 100'000};
  std::string scene_name = "gas";
  ScaleSceneOptions scene;
  RaceOptions measure;
  std::filesystem::path asset, json;
};

const std::map<std::string, ScaleSceneKind> scene_names = {{"gas", ScaleSceneKind::gas},
                                                           {"pile", ScaleSceneKind::pile},
                                                           {"flow", ScaleSceneKind::flow},
                                                           {"tenth", ScaleSceneKind::tenth}};

void define(bench::CommandOptions& options, ScaleArguments& a) {
  for (const BroadPhaseKind& kind : broad_phase_kinds()) {
    if (kind.boxes_only) a.measure.engines.push_back(kind.name);
  }
  std::vector<std::string> scenes;
  for (const auto& [name, kind] : scene_names) scenes.push_back(name);
  options.add("--bodies", a.bodies, "Numbers of bodies, separated by commas")
      .between(1, 10'000'000)
      .shows_default()
      .type("N,...");
  options.add("--scene", a.scene_name, "gas, pile, flow, or tenth: gas of which one body in ten moves")
      .one_of(scenes)
      .shows_default()
      .type("NAME");
  options.add("--speed", a.scene.speed, "Diameters of a body in a step").within(0, 10).shows_default().type("S");
  options.add("--engines", a.measure.engines, "Which ones, separated by commas; ratios are to the first")
      .shows_default()
      .type("NAME,...");
  options.asset(a.asset, "Asset of all bodies; without it, blocks of three sizes");
  options.steps(a.measure.steps, "Timed steps");
  options.runs(a.measure.runs, "Runs; each step counts with its median");
  options.json(a.json);
}

std::vector<ShapePtr> make_shapes(const ScaleArguments& a) {
  if (!a.asset.empty()) return {load_shape(a.asset)};
  std::vector<ShapePtr> shapes;
  for (const double size : {0.75, 1.0, 1.25}) {
    CageHierarchy block;
    block.fine = shapes::box(-size * Eigen::Vector3d(0.5, 0.375, 0.25), size * Eigen::Vector3d(0.5, 0.375, 0.25));
    shapes.push_back(make_shape(block));
  }
  return shapes;
}

// ---- Report --------------------------------------------------------------

const BroadPhaseTimes* find(const RaceResult& m, const std::string& engine) {
  const auto at = std::find_if(m.engines.begin(), m.engines.end(), [&](const auto& e) { return e.name == engine; });
  return at == m.engines.end() ? nullptr : &*at;
}

double exponent_of(const std::vector<RaceResult>& all, const std::string& engine) {
  std::vector<double> bodies, times;
  for (const RaceResult& m : all) {
    const BroadPhaseTimes* e = find(m, engine);
    if (e == nullptr) continue;
    bodies.push_back(static_cast<double>(m.bodies));
    times.push_back(e->ms);
  }
  return bench::growth_exponent(bodies, times);
}

nlohmann::ordered_json to_json(const ScaleArguments& a, const std::vector<RaceResult>& all) {
  nlohmann::ordered_json json = {{"scene", a.scene_name},     {"speed", a.scene.speed},
                                 {"asset", a.asset.string()}, {"steps", a.measure.steps},
                                 {"runs", a.measure.runs},    {"bodies", nlohmann::ordered_json::array()}};
  for (const RaceResult& m : all) {
    nlohmann::ordered_json row = {{"bodies", m.bodies},
                                  {"moved_per_step", m.moved},
                                  {"box_pairs_per_step", m.pairs},
                                  {"boxes_ms_per_step", m.boxes_ms},
                                  {"brute_force", m.brute_force}};
    for (const BroadPhaseTimes& e : m.engines) {
      row["engines"][e.name] = {
          {"ms_per_step", e.ms}, {"worst_ms", e.worst_ms}, {"pairs_per_step", e.pairs}, {"wrong_steps", e.wrong_steps}};
    }
    json["bodies"].push_back(row);
  }
  for (const std::string& engine : a.measure.engines) json["exponents"][engine] = exponent_of(all, engine);
  return json;
}

std::string number(double value) { return bench::format(value < 10 ? "%.2f" : "%.1f", value); }

/// As Markdown: a row for each engine, a column for each number of bodies.
void print(const ScaleArguments& a, const std::vector<RaceResult>& all) {
  const auto cells = [&](const std::string& head, const auto& cell, const std::string& last) {
    std::vector<std::string> row{head};
    for (const RaceResult& m : all) row.push_back(cell(m));
    row.push_back(last);
    return row;
  };
  const auto bodies = [](const RaceResult& m) { return std::to_string(m.bodies); };
  bench::MarkdownTable table(std::cout, cells(a.scene_name + ", ms a step", bodies, "exponent"));
  for (const std::string& engine : a.measure.engines) {
    const auto time = [&](const RaceResult& m) {
      const BroadPhaseTimes* e = find(m, engine);
      return e == nullptr ? std::string("–") : number(e->ms);
    };
    table.row(cells(engine, time, number(exponent_of(all, engine))));
  }
  const auto boxes = [](const RaceResult& m) { return number(m.boxes_ms); };
  const auto slowest = [](const RaceResult& m) { return number(m.engines.front().worst_ms); };
  const auto pairs = [](const RaceResult& m) { return number(m.pairs / static_cast<double>(m.bodies)); };
  const auto moving = [](const RaceResult& m) { return std::to_string(static_cast<std::int64_t>(m.moved)); };
  table.row(cells("world boxes alone", boxes, ""));
  table.row(cells("slowest step of the first", slowest, ""));
  table.row(cells("pairs of boxes a body", pairs, ""));
  table.row(cells("bodies that move", moving, ""));
}

bool run(ScaleArguments& a) {
  bench::check_outputs({a.json}, {a.asset});
  a.scene.kind = scene_names.at(a.scene_name);
  for (const std::string& engine : a.measure.engines) broad_phase_kind(engine);
  const std::vector<ShapePtr> shapes = make_shapes(a);
  bench::Watch watch;
  const auto turns = static_cast<double>(a.bodies.size() * a.measure.engines.size()) * a.measure.runs;
  int done = 0;
  std::vector<RaceResult> all;
  for (const std::int64_t bodies : a.bodies) {
    ScaleSceneOptions scene = a.scene;
    scene.bodies = bodies;
    all.push_back(
        race(scene, shapes, a.measure, [&] { watch.report(++done / turns, std::to_string(bodies) + " bodies"); }));
  }
  if (!a.json.empty()) tool::write_json(a.json, to_json(a, all));
  print(a, all);
  int wrong = 0;
  for (const RaceResult& m : all) {
    for (const BroadPhaseTimes& e : m.engines) {
      wrong += e.wrong_steps;
      if (e.wrong_steps == 0) continue;
      std::cerr << "encage-bench scale: " << e.name << ", " << m.bodies << " bodies: other pairs than expected in "
                << e.wrong_steps << " steps\n";
    }
  }
  return wrong == 0;
}

}  // namespace

bench::Command command() {
  return bench::make_command<ScaleArguments>(
      "scale", "Pairs of overlapping boxes of many moving bodies: how long do broad phases take?", examples, define,
      run);
}

}  // namespace encage::scale

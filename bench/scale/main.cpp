// SPDX-License-Identifier: GPL-3.0-or-later
// encage-scale: which boxes overlap, of up to 100,000 bodies that move?

#include "bench/scale/measure.h"
#include "cagegen/cli/interrupt.h"
#include "cagegen/cli/output_file.h"
#include "cagegen/cli/program.h"
#include "cagegen/cli/progress.h"
#include "oracles/meshes.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>

namespace encage::scale {
namespace {

constexpr const char* examples = R"(Examples:
  encage-scale --scene gas --json gas.json
      1,000 to 100,000 bodies, all moving, in all engines
  encage-scale --bodies 10000 --asset octopus.glb --engines encage,encage_full
      the world's boxes, and the whole search

Times of the other engines are without the computation of the boxes, which they are given.
Exit status: 0 if all engines found the same pairs, 1 if not, 2 for bad input or usage.)";

struct Arguments {
  std::vector<std::int64_t> bodies = {1000, 3000, 10'000, 30'000, 100'000};
  SceneOptions scene;
  MeasureOptions measure;
  std::filesystem::path asset, json;
};

const std::map<std::string, SceneKind> scene_names = {
    {"gas", SceneKind::gas}, {"pile", SceneKind::pile}, {"flow", SceneKind::flow}, {"tenth", SceneKind::tenth}};

std::string name(SceneKind kind) {
  return std::find_if(scene_names.begin(), scene_names.end(), [&](const auto& n) { return n.second == kind; })->first;
}

void define(CLI::App& app, Arguments& a) {
  for (const EngineKind& kind : engine_kinds()) {
    if (kind.boxes_only) a.measure.engines.push_back(kind.name);
  }
  app.footer(examples);
  app.add_option("--bodies", a.bodies, "Numbers of bodies, separated by commas")
      ->delimiter(',')
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{10'000'000}).description(""))
      ->capture_default_str()
      ->type_name("N,...");
  app.add_option("--scene", a.scene.kind, "gas, pile, flow, or tenth: gas of which one body in ten moves")
      ->transform(CLI::CheckedTransformer(scene_names).description(""))
      ->type_name("NAME");
  app.add_option("--speed", a.scene.speed, "Diameters of a body in a step")
      ->check(CLI::Range(0.0, 10.0).description(""))
      ->capture_default_str()
      ->type_name("S");
  app.add_option("--engines", a.measure.engines, "Which ones, separated by commas; ratios are to the first")
      ->delimiter(',')
      ->capture_default_str()
      ->type_name("NAME,...");
  app.add_option("--asset", a.asset, "Asset of all bodies; without it, blocks of three sizes")->type_name("FILE.glb");
  app.add_option("--steps", a.measure.steps, "Timed steps")
      ->check(CLI::Range(1, 100'000).description(""))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--runs", a.measure.runs, "Runs; each step counts with its median")
      ->check(CLI::Range(1, 1000).description(""))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--json", a.json, "Write everything as JSON")->type_name("FILE");
}

std::vector<ShapePtr> make_shapes(const Arguments& a) {
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

const EngineTimes* find(const Measurement& m, const std::string& engine) {
  const auto at = std::find_if(m.engines.begin(), m.engines.end(), [&](const auto& e) { return e.name == engine; });
  return at == m.engines.end() ? nullptr : &*at;
}

double exponent_of(const std::vector<Measurement>& all, const std::string& engine) {
  std::vector<double> bodies, times;
  for (const Measurement& m : all) {
    const EngineTimes* e = find(m, engine);
    if (e == nullptr) continue;
    bodies.push_back(static_cast<double>(m.bodies));
    times.push_back(e->ms);
  }
  return exponent(bodies, times);
}

nlohmann::ordered_json to_json(const Arguments& a, const std::vector<Measurement>& all) {
  nlohmann::ordered_json json = {{"scene", name(a.scene.kind)}, {"speed", a.scene.speed},
                                 {"asset", a.asset.string()},   {"steps", a.measure.steps},
                                 {"runs", a.measure.runs},      {"bodies", nlohmann::ordered_json::array()}};
  for (const Measurement& m : all) {
    nlohmann::ordered_json row = {{"bodies", m.bodies},
                                  {"moved_per_step", m.moved},
                                  {"box_pairs_per_step", m.pairs},
                                  {"boxes_ms_per_step", m.boxes_ms},
                                  {"brute_force", m.brute_force}};
    for (const EngineTimes& e : m.engines) {
      row["engines"][e.name] = {
          {"ms_per_step", e.ms}, {"worst_ms", e.worst_ms}, {"pairs_per_step", e.pairs}, {"wrong_steps", e.wrong_steps}};
    }
    json["bodies"].push_back(row);
  }
  for (const std::string& engine : a.measure.engines) json["exponents"][engine] = exponent_of(all, engine);
  return json;
}

std::string number(double value) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), value < 10 ? "%.2f" : "%.1f", value);
  return text.data();
}

/// As Markdown: a row for each engine, a column for each number of bodies.
void print(const Arguments& a, const std::vector<Measurement>& all) {
  const auto row = [&](const std::string& head, const auto& cell, const std::string& last) {
    std::cout << "| " << head << " |";
    for (const Measurement& m : all) std::cout << ' ' << cell(m) << " |";
    std::cout << ' ' << last << " |\n";
  };
  row(
      name(a.scene.kind) + ", ms a step", [](const Measurement& m) { return std::to_string(m.bodies); }, "exponent");
  row(
      "---", [](const Measurement&) { return "--:"; }, "--:");
  for (const std::string& engine : a.measure.engines) {
    row(
        engine,
        [&](const Measurement& m) {
          const EngineTimes* e = find(m, engine);
          return e == nullptr ? std::string("–") : number(e->ms);
        },
        number(exponent_of(all, engine)));
  }
  row(
      "world boxes alone", [](const Measurement& m) { return number(m.boxes_ms); }, "");
  row(
      "slowest step of the first", [](const Measurement& m) { return number(m.engines.front().worst_ms); }, "");
  row(
      "pairs of boxes a body", [](const Measurement& m) { return number(m.pairs / static_cast<double>(m.bodies)); },
      "");
  row(
      "bodies that move", [](const Measurement& m) { return std::to_string(static_cast<std::int64_t>(m.moved)); }, "");
}

int run(const Arguments& a) {
  const tool::InterruptScope scope;
  if (!a.json.empty()) tool::check_output(a.json, a.asset);
  for (const std::string& engine : a.measure.engines) engine_kind(engine);
  const std::vector<ShapePtr> shapes = make_shapes(a);
  tool::Progress progress = tool::Progress::on_stderr();
  const auto turns = static_cast<double>(a.bodies.size() * a.measure.engines.size()) * a.measure.runs;
  int done = 0;
  std::vector<Measurement> all;
  for (const std::int64_t bodies : a.bodies) {
    SceneOptions scene = a.scene;
    scene.bodies = bodies;
    all.push_back(measure(scene, shapes, a.measure, [&] {
      tool::throw_if_interrupted();
      progress.update(++done / turns, std::to_string(bodies) + " bodies");
    }));
  }
  if (!a.json.empty()) tool::write_json(a.json, to_json(a, all));
  print(a, all);
  int wrong = 0;
  for (const Measurement& m : all) {
    for (const EngineTimes& e : m.engines) {
      wrong += e.wrong_steps;
      if (e.wrong_steps == 0) continue;
      std::cerr << "encage-scale: " << e.name << ", " << m.bodies << " bodies: other pairs than expected in "
                << e.wrong_steps << " steps\n";
    }
  }
  return wrong == 0 ? tool::success : tool::answer_is_no;
}

}  // namespace
}  // namespace encage::scale

int main(int argc, char** argv) {
  CLI::App app("Pairs of overlapping boxes of many moving bodies: how long do broad phases take?", "encage-scale");
  encage::scale::Arguments a;
  encage::scale::define(app, a);
  return encage::tool::run_program(app, argc, argv, [&] { return encage::scale::run(a); });
}

// SPDX-License-Identifier: GPL-3.0-or-later
// encage-distance: how far apart bodies are, by cages, by the fine meshes, by FCL.

#include "bench/distance/compare.h"
#include "broadphase/shape/shape.h"
#include "cagegen/cli/interrupt.h"
#include "cagegen/cli/output_file.h"
#include "cagegen/cli/program.h"
#include "cagegen/cli/progress.h"

#include <encage/asset.h>
#include <encage/error.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <string>

namespace encage::distances {
namespace {

constexpr const char* examples = R"(Examples:
  encage-distance --asset octopus.glb --poses bouncing.csv --every 400 --json distance.json

All pairs of bodies in some steps, by their distance in parts of the body's diagonal. Cages give lower bounds; "half"
stops as soon as the bound is half the distance. FCL measures the asset's fine mesh, in double.

Exit status: 0; 1 if a bound is larger than the distance or FCL finds another one; 2 for bad input or usage.)";

struct Arguments {
  std::filesystem::path asset, poses, json;
  std::int64_t every = 400;
  int pairs = 40, runs = 5;
};

void define(CLI::App& app, Arguments& a) {
  const auto count = CLI::Range(1, 1'000'000).description("");
  app.footer(examples);
  app.add_option("--asset", a.asset, "Asset of all bodies, with its fine mesh")->required()->type_name("FILE.glb");
  app.add_option("--poses", a.poses, "Poses of the bodies, step by step")->required()->type_name("FILE.csv");
  app.add_option("--every", a.every, "Take every K-th step only")->check(count)->capture_default_str()->type_name("K");
  app.add_option("--pairs", a.pairs, "Pairs of each class, at most")
      ->check(count)
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--runs", a.runs, "Runs; the median time of each pair counts")
      ->check(count)
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--json", a.json, "Write everything as JSON")->type_name("FILE");
}

/// In the body frame.
TriangleMesh fine_mesh(const Shape& shape) {
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(shape.fine.mesh.vertices.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(shape.fine.mesh.triangles.size()), 3);
  for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v) {
    mesh.vertices.row(v) = (shape.origin + shape.fine.vertex(v)).transpose();
  }
  for (std::int32_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      mesh.triangles(t, k) = static_cast<std::int32_t>(shape.fine.mesh.triangles[static_cast<std::size_t>(t)][k]);
    }
  }
  return mesh;
}

nlohmann::ordered_json to_json(const std::vector<ClassRows>& classes) {
  auto json = nlohmann::ordered_json::array();
  for (const ClassRows& one : classes) {
    auto rows = nlohmann::ordered_json::array();
    for (const Row& row : one.rows) {
      rows.push_back({{"name", row.name},
                      {"median_us", row.median_us},
                      {"mean_us", row.mean_us},
                      {"tightness", row.tightness},
                      {"wrong", row.wrong}});
    }
    json.push_back({{"class", one.name}, {"pairs", one.pairs}, {"rows", rows}});
  }
  return json;
}

std::string text(const char* format, double x) {
  std::array<char, 32> buffer;
  std::snprintf(buffer.data(), buffer.size(), format, x);
  return buffer.data();
}

/// A Markdown table: median microseconds, or tightness.
template <class Value>
void print(const std::vector<ClassRows>& classes, const char* title, const char* format, const Value& value) {
  std::cout << "| " << title << " |";
  for (const ClassRows& one : classes) std::cout << ' ' << one.name << " (" << one.pairs << ") |";
  std::cout << "\n|---|";
  for (std::size_t i = 0; i < classes.size(); ++i) std::cout << "--:|";
  std::cout << '\n';
  for (std::size_t r = 0; r < classes.front().rows.size(); ++r) {
    std::cout << "| " << classes.front().rows[r].name << " |";
    for (const ClassRows& one : classes) std::cout << ' ' << text(format, value(one.rows[r])) << " |";
    std::cout << '\n';
  }
  std::cout << '\n';
}

int run(const Arguments& a) {
  const tool::InterruptScope scope;
  for (const auto& read : {a.asset, a.poses}) {
    if (!a.json.empty()) tool::check_output(a.json, read);
  }
  const std::vector<PoseStep> poses = read_poses(a.poses);
  const ShapePtr shape = load_shape(a.asset);
  if (shape->simple().fine.empty()) throw Error(a.asset.string() + ": holds no fine mesh");
  const TriangleMesh mesh = fine_mesh(*shape);
  const std::vector<PairClass> pairs =
      make_pairs(*shape, bounds(mesh).diagonal().norm(), poses, a.every, static_cast<std::size_t>(a.pairs));
  tool::Progress progress = tool::Progress::on_stderr();
  const std::vector<ClassRows> classes = compare(*shape, mesh, pairs, a.runs, [&](double fraction) {
    progress.update(fraction, "measuring");
    tool::throw_if_interrupted();
  });
  if (!a.json.empty()) {
    tool::write_json(a.json, {{"asset", a.asset.string()},
                              {"poses", a.poses.string()},
                              {"every", a.every},
                              {"runs", a.runs},
                              {"classes", to_json(classes)}});
  }
  print(classes, "median us of a pair", "%.1f", [](const Row& row) { return row.median_us; });
  print(classes, "mean us of a pair", "%.1f", [](const Row& row) { return row.mean_us; });
  print(classes, "bound / distance, median", "%.3f", [](const Row& row) { return row.tightness; });
  std::int64_t wrong = 0;
  for (const ClassRows& one : classes) {
    for (const Row& row : one.rows) wrong += row.wrong;
  }
  if (wrong == 0) return tool::success;
  std::cerr << "encage-distance: " << wrong << " answers contradict the bounds of the distance\n";
  return tool::answer_is_no;
}

}  // namespace
}  // namespace encage::distances

int main(int argc, char** argv) {
  CLI::App app("Measures distances of bodies: bounds from cages, exact ones of the fine meshes, FCL's.",
               "encage-distance");
  encage::distances::Arguments a;
  encage::distances::define(app, a);
  return encage::tool::run_program(app, argc, argv, [&] { return encage::distances::run(a); });
}

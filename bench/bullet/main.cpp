// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bullet: octopuses in a Bullet world, with and without the adapter.

#include "bench/bullet/compare.h"
#include "bench/tank/octopus.h"
#include "cagegen/cli/output_file.h"
#include "cagegen/cli/program.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <CLI/CLI.hpp>

#include <filesystem>
#include <iostream>

namespace encage::bullet_bench {
namespace {

constexpr const char* examples = R"(Examples:
  encage-bullet
  encage-bullet --bodies 100 --width 8 --speed 2 --spin 2
  encage-bullet --gravity 5 --asset octopus.glb --json bullet.json

Bodies of one concave mesh, about 1 in radius, start on a grid, turned and thrown at random, and tumble in a cube of six
planes: many bounding boxes overlap, few bodies touch. The worlds take turns step by step; each is simulated for itself.
"perfect" hands on the pairs that will have contacts only, at no cost: the bound for any test in front of Bullet's.

Exit status: 0; 1 if a step had other contacts or poses with the adapter; 2 for bad input or usage.)";

struct Arguments {
  std::filesystem::path asset, json;
  std::int64_t faces = 50'000;
  Scene scene;
  int steps = 480, runs = 3;
};

/// Mesh and shape: an asset's, with its cages, or an octopus with one cage.
std::pair<TriangleMesh, ShapePtr> body(const Arguments& a) {
  const CageHierarchy hierarchy = [&] {
    if (!a.asset.empty()) return read_asset(a.asset, Verify::all);
    BakeOptions options;
    options.faces = {500};
    options.method = BakeMethod::collapse;
    return bake(tank::make_octopus(a.faces), options);
  }();
  if (hierarchy.fine.triangles.rows() == 0) throw Error(a.asset.string() + ": holds no fine mesh");
  TriangleMesh mesh = hierarchy.fine;
  mesh.vertices.rowwise() += hierarchy.origin.transpose();
  return {mesh, make_shape(hierarchy)};
}

void define(CLI::App& app, Arguments& a) {
  const auto positive = CLI::PositiveNumber.description("");
  const auto not_negative = CLI::NonNegativeNumber.description("");
  app.footer(examples);
  app.add_option("--asset", a.asset, "Asset of all bodies, with its fine mesh; else an octopus is made and baked")
      ->type_name("FILE.glb");
  app.add_option("--faces", a.faces, "Triangles of the octopus")->capture_default_str()->type_name("N");
  const auto count = [&](const char* name, int& value, const char* text) {
    app.add_option(name, value, text)
        ->check(CLI::Range(1, 1'000'000).description(""))
        ->capture_default_str()
        ->type_name("N");
  };
  count("--bodies", a.scene.bodies, "Bodies");
  count("--steps", a.steps, "Time steps");
  count("--runs", a.runs, "Runs; medians count");
  const auto number = [&](const char* name, double& value, const CLI::Validator& check, const char* text) {
    app.add_option(name, value, text)->check(check)->capture_default_str()->type_name("X");
  };
  number("--width", a.scene.width, positive, "Side of the cube");
  number("--speed", a.scene.speed, not_negative, "Speed at the start");
  number("--spin", a.scene.spin, not_negative, "Angular velocity at the start");
  number("--gravity", a.scene.gravity, not_negative, "Downwards");
  number("--margin", a.scene.margin, not_negative, "Collision margin of the meshes");
  number("--dt", a.scene.dt, positive, "Seconds between steps");
  app.add_option("--json", a.json, "Write everything as JSON")->type_name("FILE");
}

int run(const Arguments& a) {
  if (!a.json.empty()) tool::check_output(a.json, a.asset);
  const auto [mesh, shape] = body(a);
  const Comparison comparison = compare(mesh, shape, a.scene, a.steps, a.runs);
  if (!a.json.empty()) tool::write_json(a.json, to_json(comparison));
  std::cout << mesh.triangles.rows() << " faces; ";
  print(std::cout, comparison);
  return comparison.same() ? tool::success : tool::answer_is_no;
}

}  // namespace
}  // namespace encage::bullet_bench

int main(int argc, char** argv) {
  CLI::App app("Octopuses in a Bullet world: collision detection with and without Encage's adapter.", "encage-bullet");
  encage::bullet_bench::Arguments a;
  encage::bullet_bench::define(app, a);
  return encage::tool::run_program(app, argc, argv, [&] { return encage::bullet_bench::run(a); });
}

// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bullet: octopuses in a Bullet world, with and without the adapter.

#include "bench/bullet/compare.h"
#include "bench/bullet/contact_method.h"
#include "bench/bullet/scene_command.h"
#include "bench/bullet/scenes.h"
#include "bench/common/command.h"
#include "bench/common/meshes.h"
#include "bench/octopus/octopus.h"
#include "cagegen/cli/output_file.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <filesystem>
#include <iostream>
#include <limits>
#include <utility>

namespace encage::bullet_bench {
namespace {

constexpr const char* examples = R"(Examples:
  encage-bullet
  encage-bullet --bodies 100 --width 8 --speed 2 --spin 2
  encage-bullet --gravity 5 --asset octopus.glb --json bullet.json
  encage-bullet --scene chain,bowls --json scenes.json
      links that hang and bowls that are stacked, by every method of contacts
  encage-bullet --scene heap --methods gimpact --seed 5 --poses heap.csv

Bodies of one concave mesh, about 1 in radius, start on a grid, turned and thrown at random, and tumble in a cube of six
planes: many bounding boxes overlap, few bodies touch. The worlds take turns step by step; each is simulated for itself.
"perfect" hands on the pairs that will have contacts only, at no cost: the bound for any test in front of Bullet's.

With --scene, concave bodies touch instead, in a world with Bullet's default solver, in steps of 1/60 s: a chain of ten
links, six bowls (thick and thin), a heap of 18 octopuses, a nut on a bolt (without and with friction), stacked crates.
The penetration is that of the true meshes, found apart from any method, and so is whether a scene does what it should.

Exit status: 0; 1 if a step had other contacts or poses with the adapter, or if a scene does not hold by the method
"encage"; 2 for bad input or usage.)";

struct BulletArguments {
  std::filesystem::path asset, json;
  std::int64_t faces = 50'000;
  BulletScene scene;
  int steps = 480, runs = 3;
  SceneArguments contacts;
};

/// Mesh and shape: an asset's, with its cages, or an octopus with one cage.
std::pair<TriangleMesh, ShapePtr> body(const BulletArguments& a) {
  const CageHierarchy hierarchy = [&] {
    if (!a.asset.empty()) return read_asset(a.asset, Verify::all);
    BakeOptions options;
    options.faces = {500};
    options.method = BakeMethod::collapse;
    return bake(octopus::make_octopus(a.faces), options);
  }();
  if (hierarchy.fine.triangles.rows() == 0) throw Error(a.asset.string() + ": holds no fine mesh");
  return {bench::in_body_frame(hierarchy.fine, hierarchy.origin), make_shape(hierarchy)};
}

void define(bench::CommandOptions& options, BulletArguments& a) {
  constexpr double least = std::numeric_limits<double>::min(), most = 1e9;
  options.asset(a.asset, "Asset of all bodies, with its fine mesh; else an octopus is made and baked");
  options.add("--faces", a.faces, "Triangles of the octopus").shows_default().type("N");
  options.add("--bodies", a.scene.bodies, "Bodies").between(1, 1'000'000).shows_default().type("N");
  options.steps(a.steps, "Time steps");
  options.runs(a.runs, "Runs; medians count");
  const auto number = [&](const char* name, double& value, double smallest, const char* help) {
    options.add(name, value, help).within(smallest, most).shows_default().type("X");
  };
  number("--width", a.scene.width, least, "Side of the cube");
  number("--speed", a.scene.speed, 0, "Speed at the start");
  number("--spin", a.scene.spin, 0, "Angular velocity at the start");
  number("--gravity", a.scene.gravity, 0, "Downwards");
  number("--margin", a.scene.margin, 0, "Collision margin of the meshes");
  number("--dt", a.scene.dt, least, "Seconds between steps");
  options.json(a.json);

  SceneArguments& c = a.contacts;
  const bench::CommandOption scene =
      options.add("--scene", c.scenes, "Contact scenes instead of the comparison").one_of(scene_names()).type("NAME,…");
  options.add("--methods", c.methods, "Who makes their contacts")
      .one_of(all_method_names())
      .type("NAME,…")
      .needs(scene);
  options.add("--seed", c.seeds, "Their seeds; medians count. Else three of each scene").type("N,…").needs(scene);
  options.add("--seconds", c.seconds, "Simulated. Else 10, of the nut 5").within(1, 1e4).type("S").needs(scene);
  options.add("--triangles", c.octopus_triangles, "Of the heap's octopus").shows_default().type("N").needs(scene);
  options.add("--poses", c.poses, "Write the poses of one scene, method and seed").type("FILE.csv").needs(scene);
  options.add("--every", c.poses_every, "Write every K-th step")
      .between(1, 1'000'000)
      .shows_default()
      .type("K")
      .needs(scene);
}

bool run(BulletArguments& a) {
  if (!a.contacts.scenes.empty()) {
    bench::check_outputs({a.json, a.contacts.poses}, {});
    a.contacts.json = a.json;
    return run_scenes(a.contacts);
  }
  bench::check_outputs({a.json}, {a.asset});
  const auto [mesh, shape] = body(a);
  const BulletComparison comparison = compare(mesh, shape, a.scene, a.steps, a.runs);
  if (!a.json.empty()) tool::write_json(a.json, to_json(comparison));
  std::cout << mesh.triangles.rows() << " faces; ";
  print(std::cout, comparison);
  return comparison.same();
}

}  // namespace
}  // namespace encage::bullet_bench

int main(int argc, char** argv) {
  using namespace encage;
  return bench::run_command(
      bench::make_command<bullet_bench::BulletArguments>(
          "encage-bullet", "Octopuses in a Bullet world: collision detection with and without Encage's adapter.",
          bullet_bench::examples, bullet_bench::define, bullet_bench::run),
      argc, argv);
}

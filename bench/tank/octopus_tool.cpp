// SPDX-License-Identifier: GPL-3.0-or-later
// encage-octopus: the bench's octopus, and poses to query it on.

#include "bench/tank/drift.h"
#include "bench/tank/octopus.h"
#include "bench/tank/seconds.h"
#include "cagegen/cli/program.h"

#include <encage/bake.h>

#include <CLI/CLI.hpp>

#include <filesystem>
#include <iostream>
#include <string>

namespace {

using encage::Error;

constexpr const char* description =
    "Makes an octopus: one closed surface, about 1 in radius, z up.\n"
    "With --poses, also poses of many of them for `encage query`: they drift and tumble on\n"
    "prescribed smooth paths through a narrow tank, bounding boxes overlapping all the time\n"
    "and a few bodies meeting. Nothing is simulated; bodies that meet pass through each other.";

constexpr const char* examples =
    "Examples:\n"
    "  encage-octopus -o octopus.off\n"
    "  encage-octopus -o small.ply --faces 50000\n"
    "  encage-octopus --poses drift.csv --bodies 18 --steps 960 --dt 1/480";

struct Arguments {
  std::filesystem::path mesh;
  std::int64_t faces = encage::tank::default_octopus_faces;
  std::filesystem::path poses;
  encage::tank::Drift drift;
  std::string dt = "1/480";
};

int run(Arguments& a) {
  if (a.mesh.empty() && a.poses.empty()) throw Error("nothing to do: give -o or --poses");
  a.drift.dt = encage::tank::parse_seconds("--dt", a.dt);
  // Poses first: they check their arguments, and a mistake leaves no mesh behind.
  std::vector<encage::PoseStep> steps;
  if (!a.poses.empty()) steps = encage::tank::drifting_poses(a.drift);
  if (!a.mesh.empty()) {
    const encage::TriangleMesh mesh = encage::tank::make_octopus(a.faces);
    encage::write_mesh(a.mesh, mesh);
    std::cout << "wrote " << a.mesh.string() << ": " << mesh.triangles.rows() << " faces\n";
  }
  if (!a.poses.empty()) {
    encage::write_poses(a.poses, steps);
    std::cout << "wrote " << a.poses.string() << ": " << a.drift.bodies << " bodies, " << steps.size() << " steps\n";
  }
  return encage::tool::success;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  CLI::App app(description, "encage-octopus");
  app.footer(examples);
  app.add_option("-o,--output", a.mesh, "Mesh to write: .obj, .ply, .stl or .off")->type_name("OUT");
  app.add_option("--faces", a.faces, "Triangles, within 1 %")->capture_default_str()->type_name("N");
  app.add_option("--poses", a.poses, "Pose file to write")->type_name("FILE.csv");
  app.add_option("--bodies", a.drift.bodies, "Bodies")->capture_default_str()->type_name("N");
  app.add_option("--steps", a.drift.steps, "Time steps")->capture_default_str()->type_name("N");
  app.add_option("--dt", a.dt, "Seconds between steps, a number or a fraction")->capture_default_str()->type_name("S");
  return encage::tool::run_program(app, argc, argv, [&] { return run(a); });
}

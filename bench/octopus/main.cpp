// SPDX-License-Identifier: GPL-3.0-or-later
// encage-octopus: the bench's octopus, and poses to query it on.

#include "bench/common/command.h"
#include "bench/common/seconds.h"
#include "bench/octopus/drift.h"
#include "bench/octopus/octopus.h"

#include <encage/bake.h>
#include <encage/error.h>

#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

namespace encage::octopus {
namespace {

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

struct OctopusArguments {
  std::filesystem::path mesh;
  std::int64_t faces = default_octopus_faces;
  std::filesystem::path poses;
  Drift drift;
  std::string dt = "1/480";
};

bool run(OctopusArguments& a) {
  if (a.mesh.empty() && a.poses.empty()) throw Error("nothing to do: give -o or --poses");
  a.drift.dt = bench::parse_seconds("--dt", a.dt);
  // Poses first: they check their arguments, and a mistake leaves no mesh behind.
  std::vector<PoseStep> steps;
  if (!a.poses.empty()) steps = drifting_poses(a.drift);
  if (!a.mesh.empty()) {
    const TriangleMesh mesh = make_octopus(a.faces);
    write_mesh(a.mesh, mesh);
    std::cout << "wrote " << a.mesh.string() << ": " << mesh.triangles.rows() << " faces\n";
  }
  if (!a.poses.empty()) {
    write_poses(a.poses, steps);
    std::cout << "wrote " << a.poses.string() << ": " << a.drift.bodies << " bodies, " << steps.size() << " steps\n";
  }
  return true;
}

void define(bench::CommandOptions& options, OctopusArguments& a) {
  options.add("-o,--output", a.mesh, "Mesh to write: .obj, .ply, .stl or .off").type("OUT");
  options.add("--faces", a.faces, "Triangles, within 1 %").shows_default().type("N");
  options.add("--poses", a.poses, "Pose file to write").type("FILE.csv");
  options.add("--bodies", a.drift.bodies, "Bodies").shows_default().type("N");
  options.add("--steps", a.drift.steps, "Time steps").shows_default().type("N");
  options.add("--dt", a.dt, "Seconds between steps, a number or a fraction").shows_default().type("S");
}

}  // namespace
}  // namespace encage::octopus

int main(int argc, char** argv) {
  using namespace encage;
  return bench::run_command(
      bench::make_command<octopus::OctopusArguments>("encage-octopus", octopus::description, octopus::examples,
                                                     octopus::define, octopus::run),
      argc, argv);
}

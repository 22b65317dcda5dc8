// SPDX-License-Identifier: GPL-3.0-or-later
// encage-tank: many copies of a body in a narrow tank; what collision detection costs with cages and without.

#include "bench/common/command.h"
#include "bench/common/meshes.h"
#include "bench/common/recorded_poses.h"
#include "bench/common/seconds.h"
#include "bench/common/statistics.h"
#include "bench/common/watch.h"
#include "bench/octopus/octopus.h"
#include "bench/tank/exact_judge.h"
#include "bench/tank/interpenetration.h"
#include "bench/tank/measure.h"
#include "bench/tank/measurement_report.h"
#include "bench/tank/simulate.h"
#include "bench/tank/simulation_report.h"
#include "cagegen/cli/output_file.h"
#include "cagegen/tool/bake_mesh.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

namespace encage::tank {
namespace {

constexpr const char* description =
    "Drops copies of a body into a narrow tank with continuous collision detection, records the\n"
    "steps and measures how long several strategies take to detect the collisions: trees rebuilt in\n"
    "every step, as in the paper, or built once; each alone and behind the test of the cages.";

constexpr const char* examples = R"(Examples:
  encage-tank --json tank.json
      eighteen octopuses of half a million triangles, dropped one by one
  encage-tank --scene bouncing --seconds 10 --asset octopus.glb --poses bouncing.csv
      with cages that encage bake made; the trajectory is written as well
  encage-tank --asset octopus.glb --replay bouncing.csv --every 10
      nothing is simulated: bodies move from each recorded pose to the next one

Exit status: 0 if all strategies found the same contacts and no bodies interpenetrate, 1 if not, 2 for bad
input or usage.)";

struct TankArguments {
  std::filesystem::path mesh, asset, replay, json, poses, snapshot;
  std::int64_t faces = octopus::default_octopus_faces;
  BakeOptions bake;
  std::string scene = "drop";
  TankOptions tank;
  std::string dt = "1/960";
  double width = 0;
  std::int64_t every = 1;
  std::int64_t exact_checks = 20;
  bool simulate_only = false;
  MeasureOptions measure;
  int level = 0;
};

/// What is measured on.
struct Input {
  CageHierarchy hierarchy;
  std::optional<Simulation> simulation;
  bench::Recording recording;
  Hash trajectory_hash;
  std::int64_t interpenetrations = 0;
  std::int64_t exact_checks = 0;  ///< steps
};

void define(bench::CommandOptions& options, TankArguments& a) {
  constexpr std::int64_t many = 1'000'000'000;
  a.bake.faces = {8000, 2000, 500};
  auto faces =
      options.add("--faces", a.faces, "Triangles of the built-in octopus, within 1 %").shows_default().type("N");
  auto mesh = options.add("--mesh", a.mesh, "Mesh of the bodies instead of the octopus").excludes(faces).type("FILE");
  options.asset(a.asset, "Asset with cages and fine mesh, instead of baking one").excludes(faces).excludes(mesh);
  auto replay = options.add("--replay", a.replay, "Measure on recorded poses").type("FILE.csv");
  options.every(a.every).needs(replay);
  for (bench::CommandOption simulated :
       {options.add("--scene", a.scene, "drop: one by one; bouncing: energy is kept up; resting: it is drained")
            .one_of({"drop", "bouncing", "resting"})
            .shows_default()
            .type("drop|bouncing|resting"),
        options.add("--bodies", a.tank.bodies, "Bodies").between(1, many).shows_default().type("N"),
        options.add("--seconds", a.tank.seconds, "Simulated time").shows_default().type("S"),
        options.add("--width", a.width, "Inner width of the tank (default 2.18 radii of the body)").type("W"),
        options.add("--drop-interval", a.tank.drop_interval, "Time from one body's entry to the next")
            .shows_default()
            .type("S"),
        options
            .add("--floor-height", a.tank.floor_height,
                 "bouncing: least mean kinetic energy of a body, as the height of a fall in radii")
            .shows_default()
            .type("H"),
        options.add("--snapshot", a.snapshot, "Write the bodies in the end as one mesh, for encage render")
            .type("FILE.off"),
        options.add("--poses", a.poses, "Write the trajectory").type("FILE.csv"),
        options.add("--exact-checks", a.exact_checks, "Steps whose poses are checked exactly for interpenetration")
            .between(0, many)
            .shows_default()
            .type("N"),
        options.flag("--simulate-only", a.simulate_only, "Measure nothing")}) {
    simulated.excludes(replay);
  }
  options.add("--dt", a.dt, "Time step, a number or a fraction").shows_default().type("S");
  options.add("--cage-level", a.level, "Cage level asked, 0 the finest").between(0, many).type("K");
  options.add("--rebuild-steps", a.measure.rebuild_steps, "Steps on which rebuilding strategies are timed")
      .between(0, many)
      .shows_default()
      .type("N");
  options.runs(a.measure.runs, "Runs of the others over all steps; the median of each step counts");
  options.threads(a.bake.threads, "Threads for baking, 0 for all; strategies always have one");
  options.json(a.json);
}

CageHierarchy load_hierarchy(const TankArguments& a, bench::Watch& watch) {
  if (!a.asset.empty()) return read_asset(a.asset, Verify::all);
  watch.report(0, "making the body");
  const TriangleMesh mesh = a.mesh.empty() ? octopus::make_octopus(a.faces) : read_mesh(a.mesh);
  const std::filesystem::path name = a.mesh.empty() ? "octopus" : a.mesh;
  return tool::bake_mesh(name, mesh, a.bake, watch.context()).hierarchy;
}

/// All bodies of a step as one mesh, in the world; of their finest cage, which looks like them and is small.
TriangleMesh snapshot(const CageHierarchy& hierarchy, const PoseStep& step) {
  const TriangleMesh cage = bench::in_body_frame(hierarchy.levels[0].mesh, hierarchy.origin);
  const Eigen::Index vertices = cage.vertices.rows(), triangles = cage.triangles.rows();
  const auto count = static_cast<Eigen::Index>(step.bodies.size());
  TriangleMesh all;
  all.vertices.resize(count * vertices, 3);
  all.triangles.resize(count * triangles, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Isometry3d& pose = step.bodies[static_cast<std::size_t>(i)].pose;
    all.vertices.middleRows(i * vertices, vertices) =
        (cage.vertices * pose.linear().transpose()).rowwise() + pose.translation().transpose();
    all.triangles.middleRows(i * triangles, triangles) =
        cage.triangles.array() + static_cast<std::int32_t>(i * vertices);
  }
  return all;
}

void simulate(const TankArguments& a, const TankBody& body, bench::Watch& watch, Input& input) {
  const TriangleMesh mesh = bench::in_body_frame(body.mesh.mesh, body.mesh.origin);
  TankOptions options = a.tank;
  options.scene = scene_named(a.scene);
  if (a.width != 0) options.half_width = a.width / 2;
  const MassProperties mass = mass_properties(mesh);
  SimulationContext context;
  context.progress = [&](double fraction) { watch.report(fraction, "simulating"); };
  context.cancel = &tool::interrupted;
  input.simulation = tank::simulate(body.shape, mass, options, context);
  input.recording = std::move(input.simulation->recording);
  input.trajectory_hash = input.simulation->trajectory_hash;

  const std::vector<PoseStep>& poses = input.simulation->poses;
  const auto checked = bench::evenly_spread(static_cast<std::int64_t>(poses.size()), a.exact_checks);
  for (const std::int64_t i : checked) {
    input.interpenetrations += interpenetrations(mesh, poses[i]);
    watch.report(static_cast<double>(++input.exact_checks) / static_cast<double>(checked.size()), "exact checks");
  }
}

nlohmann::ordered_json to_json(const TankArguments& a, const Input& input, const std::optional<Measurement>& measured) {
  nlohmann::ordered_json json = {{"scene", a.replay.empty() ? a.scene : "replay"}};
  json["bodies"] = input.recording.steps.empty() ? 0 : input.recording.steps.back().bodies.size();
  json["faces"] = input.hierarchy.fine.triangles.rows();
  json["cage_faces"] = nlohmann::ordered_json::array();
  for (const CageLevel& level : input.hierarchy.levels) json["cage_faces"].push_back(level.mesh.triangles.rows());
  json["cage_level"] = a.level;
  json["dt"] = a.tank.dt;
  if (measured) json.update(tank::to_json(*measured));
  json["interpenetrations"] = input.interpenetrations;
  json["exact_checks"] = input.exact_checks;
  json["trajectory_hash"] = to_string(input.trajectory_hash);
  if (input.simulation) json["simulation"] = tank::to_json(*input.simulation);
  return json;
}

void print(const TankArguments& a, const Input& input, const std::optional<Measurement>& measured) {
  std::cout << (a.replay.empty() ? a.scene : a.replay.string()) << ", " << input.hierarchy.fine.triangles.rows()
            << " triangles a body; cages:";
  for (const CageLevel& level : input.hierarchy.levels) std::cout << ' ' << level.mesh.triangles.rows();
  std::cout << " faces, asked: " << input.hierarchy.levels[a.level].mesh.triangles.rows() << '\n';
  if (input.simulation) {
    std::cout << to_text(*input.simulation) << input.interpenetrations << " interpenetrations in " << input.exact_checks
              << " steps that were checked exactly\n";
  }
  std::cout << "trajectory " << to_string(input.trajectory_hash) << '\n';
  if (measured) std::cout << '\n' << to_text(*measured);
}

bool run(TankArguments& a) {
  bench::check_outputs({a.json, a.poses, a.snapshot}, {a.mesh, a.asset, a.replay});
  a.tank.dt = bench::parse_seconds("--dt", a.dt);
  std::vector<PoseStep> recorded;
  Input input;
  if (!a.replay.empty()) {
    recorded = read_poses(a.replay);
    input.recording = bench::recording_of(recorded, a.tank.dt, a.every, a.replay.string());
    input.trajectory_hash = bench::trajectory_hash(recorded);
  }
  bench::Watch watch;
  input.hierarchy = load_hierarchy(a, watch);
  if (a.level >= static_cast<int>(input.hierarchy.levels.size())) {
    throw Error("--cage-level " + std::to_string(a.level) + ": there are only " +
                std::to_string(input.hierarchy.levels.size()) + " levels");
  }
  const TankBody body = make_tank_body(input.hierarchy);
  if (a.replay.empty()) simulate(a, body, watch, input);

  std::optional<Measurement> measured;
  if (!a.simulate_only) {
    a.measure.strategy.finest_cage = a.measure.strategy.coarsest_cage = a.level;
    a.measure.judge = exact_judge(body, a.measure.strategy.contact);
    a.measure.progress = [&](double fraction, std::string_view what) { watch.report(fraction, what); };
    measured = measure(body, input.recording, a.measure);
  }
  if (!a.poses.empty()) write_poses(a.poses, input.simulation->poses);
  if (!a.snapshot.empty()) write_mesh(a.snapshot, snapshot(input.hierarchy, input.simulation->poses.back()));
  if (!a.json.empty()) tool::write_json(a.json, to_json(a, input, measured));
  print(a, input, measured);
  return input.interpenetrations == 0 && (!measured || measured->faults() == Faults{});
}

}  // namespace
}  // namespace encage::tank

int main(int argc, char** argv) {
  using namespace encage;
  return bench::run_command(bench::make_command<tank::TankArguments>("encage-tank", tank::description, tank::examples,
                                                                     tank::define, tank::run),
                            argc, argv);
}

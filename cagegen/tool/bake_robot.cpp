// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/tool/bake_robot.h"

#include "cagegen/cli/interrupt.h"
#include "cagegen/cli/is_asset.h"
#include "cagegen/cli/output_file.h"
#include "cagegen/cli/program.h"
#include "cagegen/cli/progress.h"
#include "cagegen/cli/usage.h"
#include "cagegen/tool/input.h"
#include "cagegen/tool/urdf.h"

#include <encage/error.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <iostream>
#include <map>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace encage::tool {

namespace fs = std::filesystem;

namespace {

/// A mesh at one scale, which several links may share.
struct ScaledMesh {
  const UrdfMesh* first = nullptr;  ///< of those that share it
  TriangleMesh mesh;
  BakedMesh baked;
};

struct Robot {
  Urdf urdf;
  std::vector<ScaledMesh> meshes;
  std::vector<std::size_t> mesh_of;  ///< for each of urdf.meshes
};

void apply_scale(TriangleMesh& mesh, const Eigen::Vector3d& scale) {
  mesh.vertices.array().rowwise() *= scale.transpose().array();
  // A mirrored mesh keeps its outside outside.
  if (scale.prod() < 0) mesh.triangles.col(1).swap(mesh.triangles.col(2));
}

Robot read_robot(const fs::path& input, Progress& progress) {
  const NoteSink note = [&](const std::string& text) { progress.note(text); };
  Input description(input, "urdf");
  Robot robot;
  robot.urdf = read_urdf(description.name(), description.bytes());
  for (const std::string& text : robot.urdf.notes) note(description.name() + ": " + text);
  std::map<std::pair<std::string, std::array<double, 3>>, std::size_t> known;
  for (const UrdfMesh& mesh : robot.urdf.meshes) {
    const std::array<double, 3> scale = {mesh.scale.x(), mesh.scale.y(), mesh.scale.z()};
    std::error_code none;
    const auto key = std::pair(fs::weakly_canonical(mesh.file, none).string(), scale);
    const auto [entry, is_new] = known.try_emplace(key, robot.meshes.size());
    robot.mesh_of.push_back(entry->second);
    if (!is_new) continue;
    try {
      robot.meshes.push_back({&mesh, Input(mesh.file).mesh(note), {}});
    } catch (const Error& error) {
      throw Error(description.name() + ": link '" + mesh.link + "': " + error.what());
    }
    apply_scale(robot.meshes.back().mesh, mesh.scale);
    throw_if_interrupted();
  }
  return robot;
}

fs::path checked_folder(const RobotArguments& arguments) {
  fs::path folder = arguments.output;
  if (folder.empty()) {
    if (arguments.input == "-") throw Error("-: has no name to use for the output; choose a folder with -o");
    folder = arguments.input.stem();
  }
  if (is_standard_output(folder)) throw Error(folder.string() + ": the assets of a robot go into a folder");
  std::error_code none;
  const bool exists = fs::exists(folder, none);
  if (exists && !fs::is_directory(folder, none)) throw Error(folder.string() + ": is no folder");
  // A name that ends in a slash names the same folder.
  if (!folder.has_filename()) folder = folder.parent_path();
  if (!exists) check_output(folder, arguments.input);
  if (!arguments.json.empty()) check_output(arguments.json, arguments.input);
  return folder;
}

/// Throws Error if an asset would replace something that is none.
void check_assets(const Urdf& urdf, const fs::path& folder, const fs::path& json) {
  std::error_code none;
  for (const UrdfMesh& mesh : urdf.meshes) {
    const fs::path file = folder / (mesh.body + ".glb");
    if (fs::exists(folder, none)) check_output(file, mesh.file);
    if (fs::exists(file, none) && !is_asset(file)) {
      throw Error(file.string() + ": exists and holds no cages; choose another folder with -o");
    }
    if (!json.empty()) check_output(json, mesh.file);
    check_different(file, json);
  }
}

nlohmann::ordered_json to_json(const Eigen::Vector3d& vector) { return {vector.x(), vector.y(), vector.z()}; }

void write_figures(const RobotArguments& arguments, const fs::path& folder, const Robot& robot, double seconds) {
  nlohmann::ordered_json bodies = nlohmann::ordered_json::array();
  for (std::size_t m = 0; m < robot.urdf.meshes.size(); ++m) {
    const UrdfMesh& mesh = robot.urdf.meshes[m];
    nlohmann::ordered_json body = {{"link", mesh.link},
                                   {"asset", (folder / (mesh.body + ".glb")).string()},
                                   {"mesh", mesh.file.string()},
                                   {"scale", to_json(mesh.scale)},
                                   {"origin", {{"xyz", to_json(mesh.origin_xyz)}, {"rpy", to_json(mesh.origin_rpy)}}}};
    body.update(tool::to_json(robot.meshes[robot.mesh_of[m]].baked));
    bodies.push_back(std::move(body));
  }
  const Usage usage = process_usage();
  write_json(arguments.json, {{"input", arguments.input.string()},
                              {"output", folder.string()},
                              {"robot", robot.urdf.name},
                              {"bodies", std::move(bodies)},
                              {"seconds", seconds},
                              {"cpu_seconds", usage.cpu_seconds},
                              {"peak_rss_bytes", usage.peak_rss_bytes}});
}

void bake_meshes(Robot& robot, const RobotArguments& arguments, Progress& progress) {
  for (std::size_t m = 0; m < robot.meshes.size(); ++m) {
    ScaledMesh& shared = robot.meshes[m];
    const std::string& body = shared.first->body;
    BakeContext context = progress.context(&interrupted);
    context.progress = [&](double fraction, std::string_view stage) {
      progress.update((static_cast<double>(m) + fraction) / static_cast<double>(robot.meshes.size()),
                      body + ": " + std::string(stage));
    };
    context.log = [&](std::string_view message) { progress.note(body + ": " + std::string(message)); };
    if (arguments.verbose) context.trace = context.log;
    shared.baked = bake_mesh(shared.first->file, shared.mesh, arguments.options, context);
    throw_if_interrupted();
  }
}

}  // namespace

bool is_robot(const std::string& format) { return format == "urdf" || format == "xacro"; }

int bake_robot(const RobotArguments& arguments,
               const std::function<void(const std::string&, const fs::path&, const BakedMesh&)>& print) {
  const auto began = std::chrono::steady_clock::now();
  const InterruptScope scope;
  const fs::path folder = checked_folder(arguments);
  Robot robot;
  {
    Progress progress = Progress::on_stderr();
    progress.update(0, "reading");
    robot = read_robot(arguments.input, progress);
    check_assets(robot.urdf, folder, arguments.json);
    bake_meshes(robot, arguments, progress);
  }
  std::error_code error;
  fs::create_directory(folder, error);
  if (error) throw Error(folder.string() + ": cannot make the folder: " + error.message());
  Status status = success;
  for (std::size_t m = 0; m < robot.urdf.meshes.size(); ++m) {
    const UrdfMesh& mesh = robot.urdf.meshes[m];
    const BakedMesh& baked = robot.meshes[robot.mesh_of[m]].baked;
    const fs::path asset = folder / (mesh.body + ".glb");
    write_certified_asset(asset, baked.hierarchy);
    print(mesh.file.string(), asset, baked);
    if (baked.report.failure.empty()) continue;
    std::cerr << "encage: " << mesh.file.string() << ": " << baked.report.failure << "; " << asset.string()
              << " holds the others\n";
    status = answer_is_no;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  if (!arguments.json.empty()) write_figures(arguments, folder, robot, seconds);
  return status;
}

}  // namespace encage::tool

// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/scene_command.h"

#include "bench/bullet/contact_method.h"
#include "bench/bullet/scene_report.h"
#include "bench/bullet/scene_run.h"
#include "bench/bullet/scenes.h"
#include "cagegen/cli/output_file.h"

#include <encage/error.h>
#include <encage/poses.h>

#include <iostream>
#include <memory>

namespace encage::bullet_bench {
namespace {

constexpr const char* own_method = "encage";

using Methods = std::vector<std::unique_ptr<ContactMethod>>;

MethodRuns run_method(const SceneArguments& a, const PreparedScene& prepared, const ContactMethod& method) {
  MethodRuns result{method.name(), {}, {}};
  std::vector<std::unique_ptr<MethodShape>> shapes;
  for (const SceneBodyModel& model : prepared.models) {
    shapes.push_back(method.make_shape(model));
    result.details.push_back(shapes.back()->details());
  }
  std::vector<std::uint64_t> seeds(a.seeds.begin(), a.seeds.end());
  if (seeds.empty()) seeds = prepared.scene.seeds;
  const RunOptions options{a.seconds, a.poses.empty() ? 0 : a.poses_every};
  for (const std::uint64_t seed : seeds) {
    result.runs.push_back(run_scene(prepared, method, shapes, seed, options));
    if (!a.poses.empty()) write_poses(a.poses, result.runs.back().poses);
    result.runs.back().poses.clear();
  }
  return result;
}

}  // namespace

bool run_scenes(const SceneArguments& a) {
  Methods methods;
  for (const std::string& name : a.methods.empty() ? method_names() : a.methods) {
    methods.push_back(make_contact_method(name));
  }
  if (!a.poses.empty() && (a.scenes.size() != 1 || methods.size() != 1 || a.seeds.size() != 1)) {
    throw Error("--poses: takes the poses of one scene, one method (--methods) and one seed (--seed)");
  }
  std::cout << "Steps of 1/60 s, gravity 9.81; medians over the seeds.\n";
  for (const auto& method : methods) std::cout << method->name() << ": " << method->description() << ".\n";
  bool holds = true;
  nlohmann::ordered_json json;
  for (const std::string& name : a.scenes) {
    const PreparedScene prepared(make_contact_scene(name, a.octopus_triangles));
    SceneResult result{name, {}, {}};
    for (const TriangleMesh& mesh : prepared.scene.meshes) result.triangles.push_back(mesh.triangles.rows());
    for (const auto& method : methods) {
      result.methods.push_back(run_method(a, prepared, *method));
      if (method->name() == own_method) holds &= result.methods.back().holds();
    }
    print(std::cout, result);
    std::cout.flush();  // a heap takes minutes
    json["scenes"][name] = to_json(result);
  }
  for (const auto& method : methods) json["methods"][method->name()] = method->description();
  if (!a.json.empty()) tool::write_json(a.json, json);
  return holds;
}

}  // namespace encage::bullet_bench

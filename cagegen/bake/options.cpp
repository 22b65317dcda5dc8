// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/bake/options.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <limits>

namespace encage {

namespace {

void validate_levels(const BakeOptions& options) {
  if (!options.faces.empty() && (options.ratio || options.level_count)) {
    throw Error("bake options: faces and ratio/levels exclude each other");
  }
  for (const std::int64_t faces : options.faces) {
    if (faces < 4)
      throw Error("bake options: a level of " + std::to_string(faces) + " faces; a closed surface needs 4");
  }
  if (options.ratio && !(*options.ratio > 0 && *options.ratio < 1)) {
    throw Error("bake options: ratio " + std::to_string(*options.ratio) + " is not between 0 and 1");
  }
  if (options.level_count && *options.level_count < 1) {
    throw Error("bake options: " + std::to_string(*options.level_count) + " levels; at least 1 is needed");
  }
}

void validate_flow(const BakeOptions& options) {
  const bool collapse = options.method == BakeMethod::collapse;
  if (collapse && options.decimator) throw Error("bake options: method collapse and a decimator exclude each other");
  if (collapse && (options.energy_inflate || options.energy_final)) {
    throw Error("bake options: method collapse and an energy exclude each other");
  }
  if (!options.decimator && !options.decimator_name.empty()) {
    throw Error("bake options: the decimator's name '" + options.decimator_name + "' without a decimator");
  }
  if (options.coarse.empty()) {
    if (!options.coarse_names.empty()) throw Error("bake options: names of coarse meshes without coarse meshes");
    return;
  }
  if (collapse) throw Error("bake options: method collapse and coarse meshes exclude each other");
  if (!options.faces.empty()) throw Error("bake options: coarse meshes and faces exclude each other");
  if (options.ratio || options.level_count) {
    throw Error("bake options: coarse meshes and ratio/levels exclude each other");
  }
  if (options.decimator) throw Error("bake options: coarse meshes and a decimator exclude each other");
  if (!options.coarse_names.empty() && options.coarse_names.size() != options.coarse.size()) {
    throw Error("bake options: " + std::to_string(options.coarse.size()) + " coarse meshes with " +
                std::to_string(options.coarse_names.size()) + " names");
  }
}

/// As asked for.
std::vector<std::int64_t> wanted_levels(const BakeOptions& options, std::int64_t source_faces) {
  if (!options.faces.empty()) return options.faces;
  std::vector<std::int64_t> levels;
  if (options.ratio || options.level_count) {
    // The paper's choice: seven levels, each 2^(-2/3) of the one before.
    const double ratio = options.ratio.value_or(0.62996052494743658);
    double faces = static_cast<double>(source_faces);
    for (int i = 0; i < options.level_count.value_or(7); ++i) {
      faces *= ratio;
      levels.push_back(std::max<std::int64_t>(4, static_cast<std::int64_t>(faces)));
    }
    return levels;
  }
  for (std::int64_t faces = std::clamp<std::int64_t>(source_faces / 10, 100, 8000); faces >= 100; faces /= 4) {
    levels.push_back(faces);
  }
  return levels;
}

}  // namespace

void validate(const BakeOptions& options) {
  validate_levels(options);
  validate_flow(options);
  if (!(options.min_clearance > 0 && options.min_clearance < 0.1)) {
    throw Error("bake options: minimum clearance " + std::to_string(options.min_clearance) +
                " is not between 0 and 0.1 diagonals");
  }
  if (options.threads < 0) throw Error("bake options: " + std::to_string(options.threads) + " threads");
  if (options.time_limit && !(*options.time_limit > 0)) {
    throw Error("bake options: a time limit of " + std::to_string(*options.time_limit) +
                " seconds; it must be above 0, and may be infinite");
  }
}

std::vector<std::int64_t> level_faces(const BakeOptions& options, const SourceMesh& source,
                                      const std::function<void(std::string_view)>& log) {
  const std::int64_t source_faces = source.clean.triangles.rows();
  const auto say = [&](const std::string& message) {
    if (log) log(message);
  };
  std::vector<std::int64_t> levels;
  for (const TriangleMesh& mesh : options.coarse) {
    const std::int64_t faces = mesh.triangles.rows();
    const std::int64_t before = levels.empty() ? source_faces : levels.back();
    if (faces >= before) {
      say("coarse mesh of " + std::to_string(faces) + " faces: the level before has no more, " +
          std::to_string(before));
    }
    levels.push_back(faces);
  }
  if (!levels.empty()) return levels;
  // A cage of an open surface, or of a soup, can do with more; one of a flat body needs sides.
  constexpr std::int64_t sides = 12;
  const std::int64_t most = source.manifold ? std::max(source_faces, sides) : std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t wanted : wanted_levels(options, source_faces)) {
    const std::int64_t faces = std::min(wanted, most);
    if (!levels.empty() && faces >= levels.back()) {
      say("level of " + std::to_string(wanted) + " faces skipped: the one before has " + std::to_string(levels.back()));
      continue;
    }
    if (faces < wanted && !options.faces.empty()) {
      say("level of " + std::to_string(wanted) + " faces: the input has " + std::to_string(source_faces) +
          ", and no cage of it needs more than " + std::to_string(most));
    }
    levels.push_back(faces);
  }
  return levels;
}

std::string options_json(const BakeOptions& options, const std::vector<std::int64_t>& faces) {
  static constexpr const char* topologies[] = {"any", "keep", "simplify"};
  static constexpr const char* methods[] = {"auto", "collapse", "flow"};
  nlohmann::json json;
  json["faces"] = faces;
  json["method"] = methods[static_cast<int>(options.method)];
  json["min_clearance"] = options.min_clearance;
  json["topology"] = topologies[static_cast<int>(options.topology)];
  if (options.method == BakeMethod::collapse) return json.dump();
  json["energy_inflate"] = options.energy_inflate ? options.energy_inflate->name() : "step";
  json["energy_final"] = options.energy_final ? options.energy_final->name() : "volume";
  json["path"] = options.path == FlowPath::straight ? "straight" : "history";
  if (options.decimator) json["decimator"] = options.decimator_name.empty() ? "custom" : options.decimator_name;
  if (!options.coarse.empty()) json["coarse_meshes"] = options.coarse.size();
  return json.dump();
}

}  // namespace encage

// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/zoo.h"

#include "bench/common/clock.h"
#include "bench/zoo/clean.h"
#include "bench/zoo/gallery.h"
#include "cagegen/cli/usage.h"
#include "cagegen/tool/bake_mesh.h"

#include <encage/error.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <utility>

namespace encage::zoo {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

bool has_mesh_extension(const fs::path& file) {
  constexpr std::array<std::string_view, 6> known = {".obj", ".ply", ".stl", ".off", ".gltf", ".glb"};
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(known.begin(), known.end(), extension) != known.end();
}

/// In the child. The outcome travels as JSON, so that the reader's refusals can be told from failures.
Json bake_here(const fs::path& file, const BakeOptions& options, const fs::path& gallery) {
  const bench::Stopwatch watch;
  TriangleMesh mesh;
  try {
    mesh = read_mesh(file);
  } catch (const Error& error) {
    return {{"no_mesh", error.what()}};
  }
  const tool::BakedMesh baked = tool::bake_mesh(file, mesh, options, {});
  // What follows is not part of a bake.
  const tool::Usage usage = tool::process_usage();
  Json figures = tool::to_json(baked);
  figures["seconds"] = 1e-3 * watch.milliseconds();
  figures["bake_seconds"] = baked.report.seconds;
  figures["cpu_seconds"] = usage.cpu_seconds;
  figures["peak_rss_bytes"] = usage.peak_rss_bytes;
  figures["clean"] = baked.source.cap_count == 0 && is_clean(baked.source.obstacle);
  if (!gallery.empty()) write_pictures(gallery / file.filename(), baked.source, baked.hierarchy);
  return {{"figures", std::move(figures)}};
}

/// In the child.
Json run_baseline_here(const PlainMethod& baseline, const Model& known, const std::vector<std::int64_t>& faces) {
  const SourceMesh source = sanitize(read_mesh(known.file));
  const auto input_faces = known.figures.at("source").at("faces").get<std::int64_t>();
  Json levels = Json::array();
  double seconds = 0;
  for (const std::int64_t target : faces) {
    if (target >= input_faces) {
      levels.push_back(nullptr);
      continue;
    }
    const BaselineResult result = baseline.run(source, target);
    seconds += result.cpu_seconds;
    levels.push_back({{"faces", result.faces},
                      {"volume_ratio", result.volume_ratio ? Json(*result.volume_ratio) : Json(nullptr)},
                      {"certified", result.certified},
                      {"hits", result.hits},
                      {"self_hits", result.self_hits},
                      {"cpu_seconds", result.cpu_seconds},
                      {"error", result.error.empty() ? Json(nullptr) : Json(result.error)}});
  }
  return {
      {"source", known.figures.at("source")}, {"levels", levels}, {"cpu_seconds", seconds}, {"clean", known.clean()}};
}

}  // namespace

bool Model::certified() const {
  if (outcome != Outcome::baked || figures.at("levels").empty()) return false;
  return std::all_of(figures.at("levels").begin(), figures.at("levels").end(),
                     [](const Json& level) { return level.is_null() || level.at("certified").get<bool>(); });
}

std::vector<fs::path> mesh_files(const std::vector<fs::path>& paths) {
  std::vector<fs::path> files;
  for (const fs::path& path : paths) {
    if (!fs::exists(path)) throw Error(path.string() + ": no such file or folder");
    if (!fs::is_directory(path)) {
      files.push_back(path);
      continue;
    }
    std::vector<fs::path> found;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path)) {
      if (entry.is_regular_file() && has_mesh_extension(entry.path())) found.push_back(entry.path());
    }
    std::sort(found.begin(), found.end());
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

Model bake_model(const fs::path& file, const BakeOptions& options, const fs::path& gallery) {
  Model model;
  model.file = file;
  const bench::ChildResult child = bench::run_isolated([&] { return bake_here(file, options, gallery).dump(); });
  model.error = child.error;
  if (!child.error.empty()) return model;
  Json result = Json::parse(child.output);
  if (result.contains("no_mesh")) {
    model.outcome = Model::Outcome::no_mesh;
    model.error = result["no_mesh"].get<std::string>();
  } else {
    model.outcome = Model::Outcome::baked;
    model.figures = std::move(result["figures"]);
  }
  return model;
}

Model run_baseline(const PlainMethod& baseline, const Model& known, const std::vector<std::int64_t>& faces) {
  Model model;
  model.file = known.file;
  model.outcome = Model::Outcome::skipped;
  if (!known.clean()) return model;
  const auto input_faces = known.figures.at("source").at("faces").get<std::int64_t>();
  if (std::none_of(faces.begin(), faces.end(), [&](std::int64_t target) { return target < input_faces; })) return model;

  const bench::ChildResult child =
      bench::run_isolated([&] { return run_baseline_here(baseline, known, faces).dump(); });
  model.outcome = child.error.empty() ? Model::Outcome::baked : Model::Outcome::failed;
  model.error = child.error;
  if (child.error.empty()) model.figures = Json::parse(child.output);
  return model;
}

Json level_for(const Model& model, const std::vector<std::int64_t>& faces, std::size_t target) {
  if (model.outcome != Model::Outcome::baked) return nullptr;
  const Json& levels = model.figures.at("levels");
  if (levels.size() == faces.size()) return levels[target];
  // Levels were skipped: each of the others stands for the smallest target that it meets.
  for (const Json& level : levels) {
    const auto count = level.at("faces").get<std::int64_t>();
    const bool meets_next = target + 1 < faces.size() && count <= faces[target + 1];
    const bool meets = count <= faces[target] || target == 0;
    if (meets && !meets_next) return level;
  }
  return nullptr;
}

}  // namespace encage::zoo

// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench handmade: cages of thin and slotted shapes beside those that a person would draw.

#include "bench/common/report.h"
#include "bench/common/watch.h"
#include "bench/suite/commands.h"
#include "bench/suite/handmade/shapes.h"
#include "bench/zoo/triplets.h"
#include "cagegen/cli/output_file.h"
#include "cagegen/cli/usage.h"
#include "cagegen/render/levels.h"
#include "src/files/atomic_file.h"
#include "src/mesh/rounding.h"

#include <encage/bake.h>
#include <encage/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace encage::handmade {
namespace {

constexpr const char* examples = R"(Examples:
  encage-bench handmade --json handmade.json --markdown handmade.md
      ten shapes and a tree of leaf cards at 500, at 100, and at the hand-made cage's number of faces
  encage-bench handmade --only comb,chain --faces 100 --picture thin.png --meshes thin
      a row of pictures for each, and all meshes as files

Exit status: 0 if all cages are certified, 1 if not, 2 for bad input or usage.)";

struct HandmadeArguments {
  std::vector<std::int64_t> faces = {500, 100};
  std::vector<std::string> only;
  std::string method = "auto";
  int threads = 1;
  int size = 360;
  std::filesystem::path json, markdown, picture, meshes;
};

void define(bench::CommandOptions& options, HandmadeArguments& a) {
  options.add("--faces", a.faces, "Faces of Encage's cages, a bake each")
      .between(4, 100'000)
      .shows_default()
      .type("N,...");
  options.add("--only", a.only, "Shapes to take: words of their names, such as comb").type("NAME,...");
  options.add("--method", a.method, "How Encage makes cages").one_of({"auto", "collapse", "flow"}).shows_default();
  options.threads(a.threads, "Threads of a bake");
  options.add("--markdown", a.markdown, "The table as a Markdown file").type("FILE.md");
  options.add("--picture", a.picture, "A row of pictures for each shape: input, hand-made cage, Encage's cages")
      .type("OUT.png");
  options.add("--size", a.size, "Pixels, the side of a picture").between(16, 2000).shows_default();
  options.add("--meshes", a.meshes, "Folder for all meshes, as OFF files").type("DIR");
  options.json(a.json);
}

/// A cage and its figures.
struct Row {
  std::string maker;  ///< "hand-made" or "Encage"
  std::int64_t asked = 0;
  TriangleMesh cage;  ///< local frame; empty if there is none
  std::optional<double> volume_ratio;
  DistanceBounds distances;
  bool certified = false;
  std::string error, method;
  double cpu_seconds = 0;
};

struct Result {
  Subject subject;
  SourceMesh source;
  std::vector<Row> rows;
};

Row handmade_row(const Subject& subject, const SourceMesh& source) {
  Row row;
  row.maker = "hand-made";
  row.cage = subject.cage;
  row.asked = row.cage.triangles.rows();
  row.cage.vertices.rowwise() -= source.origin.transpose();
  round_vertices(row.cage);
  const CertifyResult proof = certify(source.obstacle, source.solid, row.cage);
  row.certified = proof.holds;
  row.error = proof.reason;
  if (source.volume > 0) row.volume_ratio = signed_volume(row.cage) / source.volume;
  row.distances = distance_bounds(source.obstacle, row.cage);
  return row;
}

Row encage_row(const SourceMesh& source, std::int64_t faces, const HandmadeArguments& a) {
  Row row;
  row.maker = "Encage";
  row.asked = faces;
  BakeOptions options;
  options.faces = {faces};
  options.method = a.method == "flow"       ? BakeMethod::flow
                   : a.method == "collapse" ? BakeMethod::collapse
                                            : BakeMethod::automatic;
  options.threads = a.threads;
  options.keep_fine = false;
  const double start = tool::process_usage().cpu_seconds;
  try {
    CageLevel level = std::move(bake(source, options, {}).levels.at(0));
    const Certificate& c = level.certificate;
    row.certified = true;
    row.volume_ratio = c.volume_ratio;
    row.distances = {c.max_distance.value(), c.mean_distance.value()};
    row.method = std::string(name(c.method)) + " from " + c.start;
    row.cage = std::move(level.mesh);
  } catch (const Error& error) {
    row.error = error.what();
  }
  row.cpu_seconds = tool::process_usage().cpu_seconds - start;
  return row;
}

bool chosen(const std::string& name, const std::vector<std::string>& only) {
  return only.empty() || std::any_of(only.begin(), only.end(),
                                     [&](const std::string& word) { return name.find(word) != std::string::npos; });
}

std::vector<Result> measure(const HandmadeArguments& a, bench::Watch& watch) {
  std::vector<Subject> all = subjects();
  std::erase_if(all, [&](const Subject& subject) { return !chosen(subject.name, a.only); });
  if (all.empty()) throw Error("--only: no shape has such a name");
  std::vector<Result> results;
  for (Subject& subject : all) {
    watch.report(static_cast<double>(results.size()) / static_cast<double>(all.size()), subject.name);
    Result result{std::move(subject), {}, {}};
    result.source = sanitize(result.subject.mesh);
    std::vector<std::int64_t> faces = a.faces;
    if (const std::int64_t own = result.subject.cage.triangles.rows(); own > 0) {
      result.rows.push_back(handmade_row(result.subject, result.source));
      if (std::find(faces.begin(), faces.end(), own) == faces.end()) faces.push_back(own);
    }
    std::sort(faces.rbegin(), faces.rend());
    for (const std::int64_t n : faces) result.rows.push_back(encage_row(result.source, n, a));
    results.push_back(std::move(result));
  }
  return results;
}

int components(const TriangleMesh& mesh) {
  std::vector<std::int32_t> labels;
  return triangle_components(mesh, labels);
}

std::string percent(double length, const Result& result) {
  return bench::format("%.3f", 100 * length / result.source.diagonal);
}

void print(std::ostream& out, const std::vector<Result>& results) {
  bench::MarkdownTable table(out,
                             {"shape", "input", "cage", "asked", "faces", "components", "volume ratio",
                              "largest distance", "mean distance", "CPU s"},
                             16, 8);
  for (const Result& result : results) {
    for (const Row& row : result.rows) {
      const bool made = row.cage.triangles.rows() > 0;
      table.row({result.subject.name, std::to_string(result.subject.mesh.triangles.rows()), row.maker,
                 std::to_string(row.asked), made ? std::to_string(row.cage.triangles.rows()) : "none",
                 made ? std::to_string(components(row.cage)) : "",
                 row.volume_ratio ? bench::format("%.3f", *row.volume_ratio) : "",
                 made ? percent(row.distances.max_distance, result) : "",
                 made ? percent(row.distances.mean_distance, result) : "",
                 row.maker == "Encage" ? bench::format("%.2f", row.cpu_seconds) : ""});
    }
  }
  out << "\nDistances from the cage to the input, bounds from above, in percent of the input's diagonal.\n";
}

nlohmann::ordered_json to_json(const std::vector<Result>& results) {
  nlohmann::ordered_json shapes = nlohmann::ordered_json::array();
  for (const Result& result : results) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const Row& row : result.rows) {
      nlohmann::ordered_json one = {{"maker", row.maker},
                                    {"asked", row.asked},
                                    {"faces", row.cage.triangles.rows()},
                                    {"certified", row.certified},
                                    {"volume_ratio", nullptr},
                                    {"max_distance", row.distances.max_distance},
                                    {"mean_distance", row.distances.mean_distance},
                                    {"cpu_seconds", row.cpu_seconds}};
      if (row.volume_ratio) one["volume_ratio"] = *row.volume_ratio;
      if (!row.method.empty()) one["method"] = row.method;
      if (!row.error.empty()) one["error"] = row.error;
      rows.push_back(std::move(one));
    }
    shapes.push_back({{"shape", result.subject.name},
                      {"built", result.subject.built},
                      {"faces", result.subject.mesh.triangles.rows()},
                      {"solid", name(result.source.solid)},
                      {"diagonal", result.source.diagonal},
                      {"cages", std::move(rows)}});
  }
  return {{"shapes", std::move(shapes)}};
}

void write_picture(const std::vector<Result>& results, const HandmadeArguments& a) {
  std::size_t columns = 0;
  for (const Result& result : results) columns = std::max(columns, 1 + result.rows.size());
  render::Options options;
  options.width = options.height = a.size;
  options.camera.emplace();
  options.camera->azimuth = 25;
  options.camera->elevation = 50;
  std::vector<render::Image> pictures;
  render::Image blank;
  blank.width = blank.height = a.size;
  blank.rgb.assign(std::size_t{3} * static_cast<std::size_t>(a.size) * static_cast<std::size_t>(a.size), 255);
  for (const Result& result : results) {
    const auto draw = [&](const TriangleMesh& mesh, int level) {
      if (mesh.triangles.rows() == 0) return pictures.push_back(blank);
      const std::array item{render::level_item(mesh, level)};
      pictures.push_back(render::render(item, options));
    };
    draw(result.source.obstacle, 0);
    if (result.subject.cage.triangles.rows() == 0) pictures.push_back(blank);
    for (const Row& row : result.rows) draw(row.cage, row.maker == "Encage" ? 1 : 2);
    while (pictures.size() % columns != 0) pictures.push_back(blank);
  }
  render::write_png(a.picture, zoo::tiled(pictures, static_cast<int>(columns)));
}

void write_meshes(const std::vector<Result>& results, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  for (const Result& result : results) {
    std::string stem = result.subject.name;
    std::replace(stem.begin(), stem.end(), ' ', '-');
    write_mesh(folder / (stem + ".off"), result.subject.mesh);
    for (const Row& row : result.rows) {
      if (row.cage.triangles.rows() == 0) continue;
      TriangleMesh cage = row.cage;
      cage.vertices.rowwise() += result.source.origin.transpose();
      const std::string what = row.maker == "Encage" ? std::to_string(row.asked) : row.maker;
      write_mesh(folder / (stem + "-" + what + ".off"), cage);
    }
  }
}

bool run(HandmadeArguments& a) {
  bench::check_outputs({a.json, a.markdown, a.picture}, {});
  bench::Watch watch;
  const std::vector<Result> results = measure(a, watch);
  print(std::cout, results);
  if (!a.json.empty()) tool::write_json(a.json, to_json(results));
  if (!a.markdown.empty()) {
    std::ostringstream text;
    print(text, results);
    write_atomically(a.markdown, text.str());
  }
  if (!a.picture.empty()) write_picture(results, a);
  if (!a.meshes.empty()) write_meshes(results, a.meshes);
  bool all = true;
  for (const Result& result : results) {
    for (const Row& row : result.rows) {
      if (row.certified) continue;
      std::cerr << "encage-bench handmade: " << result.subject.name << ", " << row.maker << ", " << row.asked
                << " faces: " << row.error << '\n';
      all = false;
    }
  }
  return all;
}

}  // namespace

bench::Command command() {
  return bench::make_command<HandmadeArguments>(
      "handmade", "Thin and slotted shapes: how near do cages come to those that a person would draw?", examples,
      define, run);
}

}  // namespace encage::handmade

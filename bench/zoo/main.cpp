// SPDX-License-Identifier: GPL-3.0-or-later
// encage-zoo: bakes many meshes and prints what came of each.

#include "bench/common/command.h"
#include "bench/zoo/comparison.h"
#include "bench/zoo/report.h"
#include "bench/zoo/zoo.h"
#include "cagegen/cli/output_file.h"
#include "src/files/atomic_file.h"

#include <encage/error.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace encage::zoo {

namespace {

constexpr const char* examples = R"(Examples:
  encage-zoo meshes/ --json zoo.json
      cages at 2,000, 500 and 100 faces around every mesh of a folder
  encage-zoo bunny.off fandisk.off --faces 1000 --gallery pictures/
      one level, and pictures of input, section and cage
  encage-zoo meshes/ --method auto,flow,collapse --baselines --markdown methods.md
      three methods side by side, and beside plain ones

Exit status: 0 if every mesh got certified cages, from every method, 1 if not, 2 for bad usage.)";

const std::map<std::string, BakeMethod>& bake_methods() {
  static const std::map<std::string, BakeMethod> methods = {
      {"auto", BakeMethod::automatic}, {"flow", BakeMethod::flow}, {"collapse", BakeMethod::collapse}};
  return methods;
}

struct ZooArguments {
  std::vector<std::filesystem::path> paths;
  std::vector<std::string> methods = {"auto"};
  bool baselines = false;
  BakeOptions options;
  std::filesystem::path json;
  std::filesystem::path markdown;
  std::filesystem::path gallery;
};

void define(bench::CommandOptions& options, ZooArguments& a) {
  a.options.faces = {2000, 500, 100};
  std::vector<std::string> methods;
  for (const auto& [name, method] : bake_methods()) methods.push_back(name);
  options.add("paths", a.paths, "Folders (searched for meshes) and mesh files").required().type("DIR|FILE");
  options.add("--faces", a.options.faces, "Triangles per level, fine to coarse, separated by commas")
      .between(4, std::numeric_limits<std::int32_t>::max())
      .shows_default()
      .type("N,...");
  options.add("--method", a.methods, "auto, flow or collapse; several, separated by commas, are set side by side")
      .one_of(methods)
      .shows_default()
      .type("NAME,...");
  options.flag("--baselines", a.baselines,
               "On clean meshes also a single alpha wrap, a progressive hull and an offset contour for each level");
  options.threads(a.options.threads, "Threads, 0 for all; the result does not depend on it");
  options.json(a.json);
  options.add("--markdown", a.markdown, "Write the table as a Markdown document").type("FILE");
  options.add("--gallery", a.gallery, "Folder (made if missing) for pictures of each mesh").type("DIR");
}

/// The command as a reader would repeat it, for the document's heading.
std::string command_line(int argc, char** argv) {
  std::string line = std::filesystem::path(argv[0]).filename().string();
  for (int i = 1; i < argc; ++i) line += std::string(" ") + argv[i];
  return line;
}

/// Where a method's pictures go; several methods get a folder each.
std::filesystem::path gallery(const ZooArguments& a, const std::string& method) {
  if (a.gallery.empty()) return {};
  const std::filesystem::path folder = a.methods.size() > 1 ? a.gallery / method : a.gallery;
  std::filesystem::create_directories(folder);
  return folder;
}

Model bake_by(const std::string& method, const std::filesystem::path& file, const ZooArguments& a) {
  BakeOptions options = a.options;
  options.method = bake_methods().at(method);
  return bake_model(file, options, gallery(a, method));
}

bool all_certified(const Summary& summary) { return summary.certified == summary.meshes; }

bool run_one(const ZooArguments& a, const std::vector<std::filesystem::path>& files, const std::string& command) {
  const std::vector<std::int64_t>& faces = a.options.faces;
  std::cout << table_head(faces);
  std::vector<Model> models;
  for (const auto& file : files) {
    models.push_back(bake_by(a.methods.front(), file, a));
    std::cout << table_line(models.back(), faces) << std::flush;
  }
  const Summary summary = summarize(models, faces);
  std::cout << '\n' << to_text(summary);
  if (!a.json.empty()) tool::write_json(a.json, to_json(models, summary));
  if (!a.markdown.empty()) write_atomically(a.markdown, to_markdown(models, summary, faces, command));
  return all_certified(summary);
}

bool run_several(const ZooArguments& a, const std::vector<std::filesystem::path>& files, const std::string& command) {
  const std::vector<std::int64_t>& faces = a.options.faces;
  std::cout << comparison_head(faces);
  std::vector<Contender> contenders;
  for (const std::string& method : a.methods) contenders.push_back({method, false, {}});
  if (a.baselines) {
    for (const PlainMethod& baseline : baselines()) contenders.push_back({baseline.name, true, {}});
  }
  for (std::size_t i = 0; i < files.size(); ++i) {
    for (std::size_t c = 0; c < contenders.size(); ++c) {
      Contender& contender = contenders[c];
      contender.models.push_back(contender.baseline
                                     ? run_baseline(baselines()[c - a.methods.size()], witness(contenders, i), faces)
                                     : bake_by(contender.name, files[i], a));
      std::cout << comparison_line(contender.name, contender.models.back(), faces) << std::flush;
    }
  }
  std::cout << '\n' << comparison_text(contenders, faces);
  if (!a.json.empty()) tool::write_json(a.json, comparison_json(contenders, faces));
  if (!a.markdown.empty()) write_atomically(a.markdown, comparison_markdown(contenders, faces, command));
  return std::all_of(contenders.begin(), contenders.end(),
                     [&](const Contender& c) { return c.baseline || all_certified(summarize(c.models, faces)); });
}

bool run(const ZooArguments& a, const std::string& command) {
  bench::check_outputs({a.json, a.markdown}, {});
  const std::vector<std::filesystem::path> files = mesh_files(a.paths);
  if (files.empty()) throw Error(a.paths.front().string() + ": holds no mesh files");
  return a.methods.size() == 1 && !a.baselines ? run_one(a, files, command) : run_several(a, files, command);
}

}  // namespace

}  // namespace encage::zoo

int main(int argc, char** argv) {
  using namespace encage;
  zoo::ZooArguments a;
  const bench::Command command{"encage-zoo",
                               "Bakes every mesh given and prints faces, tightness, certificate and CPU time.",
                               zoo::examples, [&](bench::CommandOptions& options) { zoo::define(options, a); },
                               [&] { return zoo::run(a, zoo::command_line(argc, argv)); }};
  return bench::run_command(command, argc, argv);
}

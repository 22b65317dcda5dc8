// SPDX-License-Identifier: GPL-3.0-or-later
// encage-zoo: bakes many meshes and prints what came of each.

#include <encage/error.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "bench/zoo/report.h"
#include "bench/zoo/zoo.h"
#include "cagegen/tool/bake_options.h"
#include "cagegen/tool/output_file.h"
#include "cagegen/tool/program.h"
#include "src/atomic_file.h"

namespace encage::zoo {

namespace {

constexpr const char* examples = R"(Examples:
  encage-zoo meshes/ --json zoo.json
      cages at 2,000, 500 and 100 faces around every mesh of a folder
  encage-zoo bunny.off fandisk.off --faces 1000 --gallery pictures/
      one level, and pictures of input, section and cage

Exit status: 0 if every mesh got certified cages, 1 if not, 2 for bad usage.)";

struct Arguments {
  std::vector<std::filesystem::path> paths;
  BakeOptions options;
  std::filesystem::path json;
  std::filesystem::path markdown;
  std::filesystem::path gallery;
};

void define(CLI::App& app, Arguments& a) {
  app.footer(examples);
  app.add_option("paths", a.paths, "Folders (searched for meshes) and mesh files")->required()->type_name("DIR|FILE");
  a.options.faces = {2000, 500, 100};
  tool::add_faces(app, a.options)->capture_default_str();
  tool::add_method(app, a.options);
  tool::add_threads(app, a.options);
  app.add_option("--json", a.json, "Write everything as JSON")->type_name("FILE");
  app.add_option("--markdown", a.markdown, "Write the table as a Markdown document")->type_name("FILE");
  app.add_option("--gallery", a.gallery, "Folder (made if missing) for pictures of each mesh")->type_name("DIR");
}

/// The command as a reader would repeat it, for the document's heading.
std::string command_line(int argc, char** argv) {
  std::string line = std::filesystem::path(argv[0]).filename().string();
  for (int i = 1; i < argc; ++i) line += std::string(" ") + argv[i];
  return line;
}

int run(const Arguments& a, const std::string& command) {
  for (const auto& file : {a.json, a.markdown}) {
    if (!file.empty()) tool::check_output(file, {});
  }
  if (!a.gallery.empty()) std::filesystem::create_directories(a.gallery);
  const std::vector<std::filesystem::path> files = mesh_files(a.paths);
  if (files.empty()) throw Error(a.paths.front().string() + ": holds no mesh files");

  const std::vector<std::int64_t>& faces = a.options.faces;
  std::cout << table_head(faces);
  std::vector<Model> models;
  for (const auto& file : files) {
    models.push_back(bake_model(file, a.options, a.gallery));
    std::cout << table_line(models.back(), faces) << std::flush;
  }
  const Summary summary = summarize(models, faces);
  std::cout << '\n' << to_text(summary);
  if (!a.json.empty()) tool::write_json(a.json, to_json(models, summary));
  if (!a.markdown.empty()) write_atomically(a.markdown, to_markdown(models, summary, faces, command));
  return summary.certified == summary.meshes ? tool::success : tool::answer_is_no;
}

}  // namespace

}  // namespace encage::zoo

int main(int argc, char** argv) {
  CLI::App app("Bakes every mesh given and prints faces, tightness, certificate and CPU time.", "encage-zoo");
  encage::zoo::Arguments a;
  encage::zoo::define(app, a);
  return encage::tool::run_program(app, argc, argv,
                                   [&] { return encage::zoo::run(a, encage::zoo::command_line(argc, argv)); });
}

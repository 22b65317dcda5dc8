// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/output_file.h"
#include "cagegen/tool/command.h"
#include "cagegen/tool/input.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

namespace encage::tool {

namespace {

constexpr const char* export_examples = R"(Examples:
  encage export model.glb --level 1 -o cage.obj
      the finest cage, in the coordinates of the source file
  encage export model.glb --level 0 -o source.ply
      the source as stored: float32, caps of open boundaries at the end
  encage export model.glb --level 2 -o - --format ply | viewer
      the second cage to standard output)";

struct ExportArguments {
  std::filesystem::path asset;
  std::filesystem::path output;
  std::filesystem::path json;
  std::string format;
  int level = 0;
};

TriangleMesh level_of(const CageHierarchy& hierarchy, const ExportArguments& arguments) {
  const std::string where = arguments.asset.string() + ": level " + std::to_string(arguments.level) + ": ";
  const int count = static_cast<int>(hierarchy.levels.size());
  if (arguments.level > count) throw Error(where + "the asset has " + std::to_string(count) + " cages");
  TriangleMesh mesh = arguments.level == 0 ? hierarchy.fine : hierarchy.levels[arguments.level - 1].mesh;
  if (mesh.triangles.rows() == 0) throw Error(where + "the source is not stored in this asset");
  mesh.vertices.rowwise() += hierarchy.origin.transpose();
  return mesh;
}

void run(const ExportArguments& a) {
  for (const std::filesystem::path& output : {a.output, a.json}) {
    if (!output.empty()) check_output(output, a.asset);
  }
  check_different(a.output, a.json);
  print_beside(a.output);
  const TriangleMesh mesh = level_of(Input(a.asset).asset(a.level == 0 ? Verify::all : Verify::cages), a);
  if (a.format.empty() && !has_no_format(a.output)) {
    write_mesh(a.output, mesh);
  } else {
    if (a.format.empty()) throw Error(a.output.string() + ": name the format with --format: obj, ply, stl or off");
    write_mesh(output_path(a.output), mesh, a.format);
  }
  std::cout << "wrote " << output_name(a.output) << ": " << mesh.triangles.rows() << " faces\n";
  if (a.json.empty()) return;
  write_json(a.json, {{"asset", a.asset.string()},
                      {"level", a.level},
                      {"output", a.output.string()},
                      {"faces", mesh.triangles.rows()},
                      {"vertices", mesh.vertices.rows()}});
}

}  // namespace

void add_export(CLI::App& app, int& /*status*/) {
  CLI::App* command = app.add_subcommand("export", "Write one level of an asset as a mesh file");
  command->footer(export_examples);
  const auto a = std::make_shared<ExportArguments>();
  command->add_option("asset", a->asset, "Asset written by encage bake; - for standard input")
      ->required()
      ->type_name("FILE.glb");
  command->add_option("--level", a->level, "0: the source; 1: the finest cage; and so on")
      ->required()
      ->check(CLI::Range(0, 1024))
      ->type_name("N");
  command->add_option("-o,--output", a->output, "Mesh to write: .obj, .ply, .stl or .off; - for standard output")
      ->required()
      ->type_name("OUT");
  command->add_option("--format", a->format, "Format of OUT, instead of its extension")
      ->check(CLI::IsMember({"obj", "ply", "stl", "off"}).description(""))
      ->type_name("obj|ply|stl|off");
  add_json(*command, a->json);
  command->callback([=] { run(*a); });
}

}  // namespace encage::tool

// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/output_file.h"
#include "cagegen/render/arguments.h"
#include "cagegen/render/levels.h"
#include "cagegen/render/render.h"
#include "cagegen/tool/command.h"
#include "cagegen/tool/input.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <charconv>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

namespace encage::tool {

namespace {

namespace fs = std::filesystem;

constexpr const char* render_examples =
    R"(Without --cut, level 0 (the source, yellow) is shown solid and the outermost cage
translucent over it. With --cut, the half nearer to the eye is removed and every
level drawn as a contour in the plane.

Examples:
  encage render model.glb -o model.png
      three-quarter view
  encage render model.glb -o section.png --cut x
      all levels in section, through the middle, seen along x
  encage render model.glb -o cage.png --levels 2 --camera 120,10
      the second cage alone, from behind on the right
  encage render bunny.obj -o bunny.png --up y --size 800x800
      a mesh file, whose y axis points up)";

struct RenderArguments {
  fs::path input;
  fs::path output;
  fs::path json;
  std::string format;
  std::string levels = "all";
  std::string cut;
  std::string size = "1200x900";
  std::string camera;
  std::string focus;
  std::string up = "z";
};

// Level 0 first, in the coordinates of the source file; a mesh file has nothing else.
std::vector<TriangleMesh> read_levels(const RenderArguments& a) {
  Input input(a.input, a.format);
  if (!input.is_asset()) return {input.mesh(print_note)};
  CageHierarchy hierarchy = input.asset(Verify::all);
  std::vector<TriangleMesh> levels{std::move(hierarchy.fine)};
  for (CageLevel& level : hierarchy.levels) levels.push_back(std::move(level.mesh));
  for (TriangleMesh& mesh : levels) mesh.vertices.rowwise() += hierarchy.origin.transpose();
  return levels;
}

std::vector<render::Item> choose_items(const RenderArguments& a, const std::vector<TriangleMesh>& levels) {
  if (a.levels == "all") return render::nested_items(levels);
  int level = 0;
  const char* const end = a.levels.data() + a.levels.size();
  const auto parsed = std::from_chars(a.levels.data(), end, level);
  if (parsed.ec != std::errc() || parsed.ptr != end) throw Error("levels '" + a.levels + "': expected all or a number");
  if (level < 0 || level >= static_cast<int>(levels.size())) {
    throw Error(a.input.string() + ": no level " + a.levels + ": the last one is " + std::to_string(levels.size() - 1));
  }
  if (levels[level].triangles.rows() == 0) {
    throw Error(a.input.string() + ": level " + a.levels + ": the source is not stored in this asset");
  }
  return {render::level_item(levels[level], level)};
}

render::Options parse_options(const RenderArguments& a, const std::vector<render::Item>& items) {
  render::Options options;
  const render::Size size = render::parse_size(a.size);
  options.width = size.width;
  options.height = size.height;
  options.up = render::parse_axis(a.up);
  if (!a.cut.empty()) {
    Eigen::AlignedBox3d box;
    for (const render::Item& item : items) box.extend(bounds(*item.mesh));
    options.cut = render::parse_cut(a.cut, box);
  }
  if (!a.camera.empty()) options.camera = render::parse_camera(a.camera);
  if (!a.focus.empty() && !options.camera) throw Error("--focus: needs --camera");
  if (options.camera) {
    options.camera->up = options.up;
    if (!a.focus.empty()) options.camera->focus = render::parse_point(a.focus);
  }
  return options;
}

/// Pictures are written as PNG only, whatever the name may promise.
void check_picture(const fs::path& output) {
  const std::string extension = output.extension().string();
  if (has_no_format(output) || extension == ".png" || extension == ".PNG") return;
  throw Error(output.string() + ": pictures are written as .png only");
}

void run(const RenderArguments& a) {
  for (const fs::path& output : {a.output, a.json}) {
    if (!output.empty()) check_output(output, a.input);
  }
  check_picture(a.output);
  check_different(a.output, a.json);
  print_beside(a.output);
  const std::vector<TriangleMesh> levels = read_levels(a);
  const std::vector<render::Item> items = choose_items(a, levels);
  const render::Options options = parse_options(a, items);
  render::write_png(output_path(a.output), render::render(items, options));
  std::cout << "wrote " << output_name(a.output) << ": " << options.width << " x " << options.height << " pixels\n";
  if (a.json.empty()) return;
  write_json(a.json, {{"input", a.input.string()},
                      {"output", a.output.string()},
                      {"width", options.width},
                      {"height", options.height}});
}

}  // namespace

void add_render(CLI::App& app, int& /*status*/) {
  CLI::App* command = app.add_subcommand("render", "Draw an asset or a mesh file as a PNG picture");
  command->footer(render_examples);
  const auto a = std::make_shared<RenderArguments>();
  command->add_option("input", a->input, "Asset (.glb) or mesh file; - for standard input")
      ->required()
      ->type_name("IN");
  command->add_option("-o,--output", a->output, "Picture to write; - for standard output")
      ->required()
      ->type_name("OUT.png");
  command->add_option("--format", a->format, "Format of a mesh, instead of its extension")->type_name("FORMAT");
  add_json(*command, a->json);
  command->add_option("--levels", a->levels, "all, or one: 0 is the source, 1 the finest cage")
      ->capture_default_str()
      ->type_name("all|N");
  command->add_option("--cut", a->cut, "Plane of a section in the file's unit; the middle without an offset")
      ->type_name("x|y|z[=OFFSET]");
  command->add_option("--size", a->size, "Pixels, 16 to 8192 a side")->capture_default_str()->type_name("WxH");
  command
      ->add_option("--camera", a->camera,
                   "Degrees about the upward axis (positive: the eye moves to the right) and above the "
                   "horizon, then a magnification. Default 35,20,1, or along the axis of a cut")
      ->type_name("AZIMUTH,ELEVATION[,ZOOM]");
  command->add_option("--focus", a->focus, "With --camera: the point shown in the middle")->type_name("X,Y,Z");
  command->add_option("--up", a->up, "Axis that points up")->capture_default_str()->type_name("x|y|z");
  command->callback([=] { run(*a); });
}

}  // namespace encage::tool

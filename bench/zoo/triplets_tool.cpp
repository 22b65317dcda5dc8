// SPDX-License-Identifier: GPL-3.0-or-later
// encage-triplets: pictures of nested cages side by side.

#include "bench/zoo/triplets.h"
#include "cagegen/cli/output_file.h"
#include "cagegen/cli/program.h"
#include "cagegen/render/arguments.h"

#include <encage/asset.h>
#include <encage/error.h>

#include <CLI/CLI.hpp>

#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

namespace encage::zoo {

namespace {

constexpr const char* examples = R"(Examples:
  encage-triplets bunny.glb fandisk.glb -o nested.png
  encage-triplets homer.glb fandisk.glb --up y,z --columns 1 -o nested.png)";

struct Arguments {
  std::vector<std::filesystem::path> assets;
  std::filesystem::path output;
  std::vector<std::string> up;
  int columns = 2;
  int size = 360;
};

void define(CLI::App& app, Arguments& a) {
  app.footer(examples);
  app.add_option("assets", a.assets, "Assets with their source")->required()->type_name("ASSET.glb");
  app.add_option("-o,--output", a.output, "Picture to write")->required()->type_name("OUT.png");
  app.add_option("--up", a.up, "Axis that points up, for each asset; z by default")
      ->delimiter(',')
      ->type_name("x|y|z,...");
  app.add_option("--columns", a.columns, "Triplets in a row")->check(CLI::Range(1, 100))->capture_default_str();
  app.add_option("--size", a.size, "Pixels, the side of a picture")->check(CLI::Range(16, 2000))->capture_default_str();
}

int run(const Arguments& a) {
  if (!a.up.empty() && a.up.size() != a.assets.size()) {
    throw Error("--up: " + std::to_string(a.up.size()) + " axes for " + std::to_string(a.assets.size()) + " assets");
  }
  tool::check_output(a.output, {});
  std::vector<render::Image> pictures;
  for (std::size_t i = 0; i < a.assets.size(); ++i) {
    const render::Axis up = a.up.empty() ? render::Axis::z : render::parse_axis(a.up[i]);
    const CageHierarchy hierarchy = read_asset(a.assets[i], Verify::all);
    try {
      for (render::Image& picture : triplet(hierarchy, up, a.size)) pictures.push_back(std::move(picture));
    } catch (const Error& error) {
      throw Error(a.assets[i].string() + ": " + error.what());
    }
  }
  const render::Image image = tiled(pictures, 3 * a.columns);
  render::write_png(a.output, image);
  std::cout << "wrote " << a.output.string() << ": " << image.width << " x " << image.height << " pixels\n";
  return tool::success;
}

}  // namespace

}  // namespace encage::zoo

int main(int argc, char** argv) {
  CLI::App app("Draws assets: the input, a section through all layers, and the outermost cage of each.",
               "encage-triplets");
  encage::zoo::Arguments a;
  encage::zoo::define(app, a);
  return encage::tool::run_program(app, argc, argv, [&] { return encage::zoo::run(a); });
}

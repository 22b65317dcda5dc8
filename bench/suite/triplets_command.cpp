// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench triplets: pictures of nested cages side by side.

#include "bench/suite/commands.h"
#include "bench/zoo/triplets.h"
#include "cagegen/render/arguments.h"

#include <encage/asset.h>
#include <encage/error.h>

#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

namespace encage::zoo {

namespace {

constexpr const char* examples = R"(Examples:
  encage-bench triplets bunny.glb fandisk.glb -o nested.png
  encage-bench triplets homer.glb fandisk.glb --up y,z --columns 1 -o nested.png)";

struct TripletsArguments {
  std::vector<std::filesystem::path> assets;
  std::filesystem::path output;
  std::vector<std::string> up;
  int columns = 2;
  int size = 360;
};

void define(bench::CommandOptions& options, TripletsArguments& a) {
  options.add("assets", a.assets, "Assets with their source").required().type("ASSET.glb");
  options.add("-o,--output", a.output, "Picture to write").required().type("OUT.png");
  options.add("--up", a.up, "Axis that points up, for each asset; z by default").type("x|y|z,...");
  options.add("--columns", a.columns, "Triplets in a row").between(1, 100).shows_default();
  options.add("--size", a.size, "Pixels, the side of a picture").between(16, 2000).shows_default();
}

bool run(TripletsArguments& a) {
  if (!a.up.empty() && a.up.size() != a.assets.size()) {
    throw Error("--up: " + std::to_string(a.up.size()) + " axes for " + std::to_string(a.assets.size()) + " assets");
  }
  bench::check_outputs({a.output}, {});
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
  return true;
}

}  // namespace

bench::Command triplets_command() {
  return bench::make_command<TripletsArguments>(
      "triplets", "Draws assets: the input, a section through all layers, and the outermost cage of each.", examples,
      define, run);
}

}  // namespace encage::zoo

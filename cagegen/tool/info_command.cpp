// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/cage_json.h"
#include "cagegen/cli/output_file.h"
#include "cagegen/tool/command.h"
#include "cagegen/tool/input.h"

#include <encage/asset.h>

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

namespace encage::tool {

namespace {

constexpr const char* info_examples = R"(Examples:
  encage info model.glb
      source, options and certificates, as text
  encage info model.glb --json
      the same as JSON on standard output
  encage info model.glb --json model.json
      both: the text, and JSON in a file)";

struct InfoArguments {
  std::filesystem::path asset;
  std::filesystem::path json;
};

std::string text(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

std::string describe(const CageLevel& level) {
  const Certificate& c = level.certificate;
  std::string line = std::to_string(level.mesh.triangles.rows()) + " faces, ";
  line += c.volume_ratio ? "volume ratio " + text("%.4f", *c.volume_ratio) : "volume " + text("%.6g", c.volume);
  if (c.max_distance) line += ", distance at most " + text("%.3g", *c.max_distance);
  if (c.mean_distance) line += ", mean " + text("%.3g", *c.mean_distance);
  line += ", clearance " + text("%.3g", c.clearance) + ", genus " + std::to_string(c.genus) + ", " +
          std::to_string(c.components) + (c.components == 1 ? " component" : " components");
  if (c.cavities > 0) line += ", of them cavities: " + std::to_string(c.cavities);
  if (c.no_new_handles) line += *c.no_new_handles ? ", no new handles" : ", handles that the finer level lacks";
  line += std::string(", ") + name(c.method);
  if (!c.start.empty()) line += " from " + c.start;
  return line;
}

void print(const CageHierarchy& hierarchy) {
  std::cout << "solid     " << name(hierarchy.solid) << '\n'
            << "volume    " << text("%.6g", hierarchy.source_volume) << '\n'
            << "diagonal  " << text("%.6g", hierarchy.diagonal) << '\n'
            << "origin    " << text("%.9g", hierarchy.origin.x()) << ' ' << text("%.9g", hierarchy.origin.y()) << ' '
            << text("%.9g", hierarchy.origin.z()) << '\n'
            << "hash      " << to_string(hierarchy.source_hash) << '\n'
            << "options   " << hierarchy.options << '\n';
  if (hierarchy.truncated) std::cout << "a time limit cut the bake short\n";
  if (hierarchy.fine.triangles.rows() == 0) {
    std::cout << "level 0   the source is not stored\n";
  } else {
    std::cout << "level 0   " << hierarchy.fine.triangles.rows() << " faces, the source";
    if (hierarchy.cap_count > 0) std::cout << ", the last " << hierarchy.cap_count << " of them caps";
    std::cout << '\n';
  }
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    std::cout << "level " << i + 1 << "   " << describe(hierarchy.levels[i]) << '\n';
  }
}

}  // namespace

void add_info(CLI::App& app, int& /*status*/) {
  CLI::App* info = app.add_subcommand("info", "Print what an asset holds");
  info->footer(info_examples);
  const auto a = std::make_shared<InfoArguments>();
  info->add_option("asset", a->asset, "Asset written by encage bake; - for standard input")
      ->required()
      ->type_name("FILE.glb");
  add_json(*info, a->json);
  info->callback([=] {
    if (!a->json.empty()) check_output(a->json, a->asset);
    const CageHierarchy hierarchy = Input(a->asset).asset(Verify::cages);
    print(hierarchy);
    if (a->json.empty()) return;
    nlohmann::ordered_json json = {{"asset", a->asset.string()}};
    json.update(to_json(hierarchy));
    write_json(a->json, json);
  });
}

}  // namespace encage::tool

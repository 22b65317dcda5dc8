// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cagegen/tool/command_fixture.h"

#include <encage/asset.h>

#include <nlohmann/json.hpp>

#include <cstdio>
#include <string>

namespace encage::test {
namespace {

class InfoCommand : public CommandTest {};

TEST_F(InfoCommand, PrintsEveryLevel) {
  bake_model();
  const RunResult result = encage({"info", "model.glb"});
  EXPECT_EQ(result.status, 0) << result.err;
  const CageHierarchy hierarchy = read_asset(folder.path() / "model.glb");
  EXPECT_NE(result.out.find("level 0   576 faces, the source"), std::string::npos) << result.out;
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    char ratio[128];
    const Certificate& c = hierarchy.levels[i].certificate;
    std::snprintf(ratio, sizeof ratio, "%.4f, distance at most %.3g, mean %.3g, ", c.volume_ratio.value(),
                  c.max_distance.value(), c.mean_distance.value());
    const std::string expected = "level " + std::to_string(i + 1) + "   " +
                                 std::to_string(hierarchy.levels[i].mesh.triangles.rows()) + " faces, volume ratio " +
                                 ratio;
    EXPECT_NE(result.out.find(expected), std::string::npos) << result.out;
  }
  EXPECT_NE(result.out.find(to_string(hierarchy.source_hash)), std::string::npos) << result.out;
}

TEST_F(InfoCommand, JsonAgreesWithTheAsset) {
  bake_model();
  const RunResult result = encage({"info", "model.glb", "--json"});
  EXPECT_EQ(result.status, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  const CageHierarchy hierarchy = read_asset(folder.path() / "model.glb");
  ASSERT_EQ(json.at("levels").size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(json["levels"][i].at("faces"), hierarchy.levels[i].mesh.triangles.rows());
    EXPECT_EQ(json["levels"][i].at("clearance"), hierarchy.levels[i].certificate.clearance);
    EXPECT_EQ(json["levels"][i].at("genus"), hierarchy.levels[i].certificate.genus);
  }
  EXPECT_EQ(json.at("source").at("solid"), "closed");
  EXPECT_EQ(json.at("source").at("stored_faces"), 576);
  EXPECT_EQ(json.at("truncated"), false);
  EXPECT_TRUE(json.at("options").is_object());
}

TEST_F(InfoCommand, WhatIsNoAssetIsRefused) {
  expect_refused({"info", "missing.glb"}, "encage: missing.glb");
  expect_refused({"info", "model.obj"}, "encage: model.obj");
  bake_model();
  std::string bytes = folder.read("model.glb");
  folder.write("short.glb", bytes.substr(0, bytes.size() / 2));
  expect_refused({"info", "short.glb"}, "encage: short.glb");
}

}  // namespace
}  // namespace encage::test

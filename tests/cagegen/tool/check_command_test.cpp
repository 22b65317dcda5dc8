// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cagegen/tool/command_fixture.h"

#include <nlohmann/json.hpp>

#include <string>

namespace encage::test {
namespace {

class CheckCommand : public CommandTest {};

TEST_F(CheckCommand, HoldsForWhatBakeWrote) {
  bake_model();
  const RunResult result = encage({"check", "model.glb", "--source", "model.obj", "--json", "check.json"});
  EXPECT_EQ(result.status, 0) << result.out << result.err;
  EXPECT_NE(result.out.find("level 2"), std::string::npos) << result.out;
  EXPECT_EQ(nlohmann::json::parse(folder.read("check.json")).at("holds"), true);
}

TEST_F(CheckCommand, SaysNoForAnotherSource) {
  bake_model();
  folder.write("other.obj", to_obj(torus(24, 14)));
  const RunResult result = encage({"check", "model.glb", "--source", "other.obj", "--json", "check.json"});
  EXPECT_EQ(result.status, 1) << result.err;
  EXPECT_EQ(nlohmann::json::parse(folder.read("check.json")).at("holds"), false);
}

TEST_F(CheckCommand, SaysNoForADamagedAsset) {
  bake_model();
  std::string bytes = folder.read("model.glb");
  bytes.back() = static_cast<char>(bytes.back() ^ 1);
  folder.write("damaged.glb", bytes);
  EXPECT_EQ(encage({"check", "damaged.glb"}).status, 1);
}

TEST_F(CheckCommand, BadRequestsAreRefused) {
  expect_refused({"check", "missing.glb"}, "encage: missing.glb");
  expect_refused({"check", "model.obj"}, "encage: model.obj");
  bake_model();
  expect_refused({"check", "model.glb", "--source", "missing.obj"}, "encage: missing.obj");
  expect_refused({"check", "model.glb", "--json", "nowhere/check.json"}, "encage: nowhere/check.json");
  expect_refused({"check", "model.glb", "--json", "model.glb"}, "encage: model.glb");
}

}  // namespace
}  // namespace encage::test

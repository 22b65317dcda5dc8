// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench handmade.

#include "tests/cagegen/tool/run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace encage::test {
namespace {

class HandmadeTool : public testing::Test {
 protected:
  RunResult handmade(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {ENCAGE_BENCH_BINARY, "handmade"});
    return run(arguments, folder.path());
  }

  ScratchFolder folder;
};

TEST_F(HandmadeTool, ComparesCages) {
  const RunResult result = handmade({"--only", "open,leaf", "--faces", "60", "--method", "collapse", "--json", "a.json",
                                     "--markdown", "a.md", "--picture", "a.png", "--size", "32", "--meshes", "all"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto json = nlohmann::json::parse(folder.read("a.json"));
  ASSERT_EQ(json.at("shapes").size(), 2U);
  const auto& box = json["shapes"][0];
  EXPECT_EQ(box.at("shape"), "open box");
  ASSERT_EQ(box.at("cages").size(), 3U);
  EXPECT_EQ(box["cages"][0].at("maker"), "hand-made");
  EXPECT_EQ(box["cages"][0].at("faces"), 28);
  EXPECT_EQ(box["cages"][1].at("asked"), 60);
  EXPECT_EQ(box["cages"][2].at("asked"), 28);
  for (const auto& cage : box["cages"]) {
    EXPECT_EQ(cage.at("certified"), true);
    EXPECT_GT(cage.at("volume_ratio"), 1);
    EXPECT_GT(cage.at("mean_distance"), 0);
    EXPECT_GE(cage.at("max_distance"), cage.at("mean_distance"));
  }
  const auto& leaves = json["shapes"][1];
  EXPECT_EQ(leaves.at("solid"), "surface_only");
  ASSERT_EQ(leaves.at("cages").size(), 1U);
  EXPECT_TRUE(leaves["cages"][0].at("volume_ratio").is_null());
  EXPECT_GT(leaves["cages"][0].at("mean_distance"), 0);
  EXPECT_EQ(folder.read("a.md"), result.out);
  EXPECT_TRUE(folder.read("a.png").starts_with("\x89PNG"));
  for (const char* file : {"open-box.off", "open-box-hand-made.off", "open-box-60.off", "leaf-cards-60.off"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "all" / file)) << file;
  }
}

TEST_F(HandmadeTool, RefusesBadInput) {
  for (const auto& [arguments, named] :
       std::vector<std::pair<std::vector<std::string>, std::string>>{{{"--only", "submarine"}, "--only"},
                                                                     {{"--faces", "3"}, "--faces"},
                                                                     {{"--json", "no/a.json"}, "no/a.json"}}) {
    const RunResult result = handmade(arguments);
    EXPECT_EQ(result.status, 2);
    EXPECT_NE(result.err.find(named), std::string::npos) << result.err;
  }
}

}  // namespace
}  // namespace encage::test

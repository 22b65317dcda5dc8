// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench scale.

#include "tests/cagegen/tool/run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace encage::test {
namespace {

class ScaleTool : public testing::Test {
 protected:
  RunResult scale(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {ENCAGE_BENCH_BINARY, "scale"});
    return run(arguments, folder.path());
  }

  ScratchFolder folder;
};

TEST_F(ScaleTool, AllBroadPhasesFindThePairsOfBruteForce) {
  for (const char* scene : {"gas", "pile", "flow", "tenth"}) {
    const RunResult result =
        scale({"--bodies", "100,300", "--scene", scene, "--steps", "3", "--runs", "1", "--json", "scale.json"});
    ASSERT_EQ(result.status, 0) << scene << ": " << result.err;
    const auto json = nlohmann::json::parse(folder.read("scale.json"));
    EXPECT_EQ(json.at("scene"), scene);
    ASSERT_EQ(json.at("bodies").size(), 2U);
    for (const auto& row : json.at("bodies")) {
      EXPECT_EQ(row.at("brute_force"), true);
      EXPECT_GT(row.at("box_pairs_per_step"), 0);
      EXPECT_EQ(row.at("engines").size(), 9U);
      for (const auto& [name, engine] : row.at("engines").items()) {
        EXPECT_EQ(engine.at("wrong_steps"), 0) << name;
        EXPECT_EQ(engine.at("pairs_per_step"), row.at("box_pairs_per_step")) << name;
        EXPECT_NE(result.out.find("| " + name + " |"), std::string::npos) << result.out;
      }
    }
  }
}

TEST_F(ScaleTool, RefusesWhatItDoesNotKnow) {
  for (const std::vector<std::string>& bad : std::vector<std::vector<std::string>>{
           {"--scene", "heap"}, {"--engines", "magic"}, {"--bodies", "0"}, {"--asset", "missing.glb"}}) {
    EXPECT_EQ(scale(bad).status, 2) << bad[0];
  }
}

}  // namespace
}  // namespace encage::test

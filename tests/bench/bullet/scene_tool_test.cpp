// SPDX-License-Identifier: GPL-3.0-or-later
// The program encage-bullet with --scene.

#include "tests/cagegen/tool/run.h"

#include <encage/poses.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>

namespace encage::test {
namespace {

TEST(SceneTool, WritesFiguresAndPoses) {
  const ScratchFolder folder;
  const RunResult result = run({ENCAGE_BULLET_BINARY, "--scene", "chain", "--methods", "gimpact", "--seed", "1",
                                "--seconds", "1", "--json", "scenes.json", "--poses", "chain.csv", "--every", "20"},
                               folder.path());
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_NE(result.out.find("## chain"), std::string::npos);
  std::ifstream file(folder.path() / "scenes.json");
  const nlohmann::json figures = nlohmann::json::parse(file)["scenes"]["chain"]["gimpact"];
  for (const char* key : {"detect_ms", "step_ms", "max_penetration", "last_penetration", "rms_linear", "rms_angular",
                          "points_per_pair", "touching_pairs"}) {
    ASSERT_TRUE(figures.contains(key)) << key;
    EXPECT_GT(figures[key].get<double>(), 0) << key;
  }
  EXPECT_TRUE(figures["holds"].is_boolean());
  EXPECT_EQ(figures["start_penetration"], 0);
  ASSERT_EQ(figures["runs"].size(), 1U);
  EXPECT_EQ(figures["runs"][0]["seed"], 1);
  EXPECT_EQ(figures["runs"][0]["pose_hash"].get<std::string>().size(), 32U);
  const std::vector<PoseStep> poses = read_poses(folder.path() / "chain.csv");
  ASSERT_EQ(poses.size(), 4U);
  EXPECT_EQ(poses[0].bodies.size(), 10U);
}

TEST(SceneTool, RefusesWhatItCannotDo) {
  const ScratchFolder folder;
  for (const std::vector<std::string>& bad :
       std::vector<std::vector<std::string>>{{"--scene", "pond"},
                                             {"--scene", "chain", "--methods", "luck"},
                                             {"--scene", "chain", "--seconds", "0"},
                                             {"--scene", "chain", "--poses", "p.csv"},
                                             {"--methods", "gimpact"},
                                             {"--scene", "heap", "--triangles", "100", "--methods", "gimpact"}}) {
    std::vector<std::string> command = {ENCAGE_BULLET_BINARY};
    command.insert(command.end(), bad.begin(), bad.end());
    const RunResult result = run(command, folder.path());
    EXPECT_EQ(result.status, 2) << bad.back();
    EXPECT_FALSE(result.err.empty()) << bad.back();
  }
}

}  // namespace
}  // namespace encage::test

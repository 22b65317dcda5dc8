// SPDX-License-Identifier: GPL-3.0-or-later
// The program encage-tank, run on a small mesh.

#include "tests/cagegen/tool/meshes.h"
#include "tests/cagegen/tool/run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace encage::test {
namespace {

class TankTool : public testing::Test {
 protected:
  TankTool() { folder.write("ring.obj", to_obj(torus(24, 12))); }

  RunResult tank(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {ENCAGE_TANK_BINARY, "--mesh", "ring.obj"});
    return run(arguments, folder.path());
  }

  void expect_refused(const std::vector<std::string>& arguments, const std::string& named) const {
    const std::vector<std::string> before = folder.names();
    const RunResult result = tank(arguments);
    EXPECT_EQ(result.status, 2) << named;
    EXPECT_NE(result.err.find(named), std::string::npos) << "'" << named << "' is not in: " << result.err;
    EXPECT_EQ(folder.names(), before);
  }

  ScratchFolder folder;
};

TEST_F(TankTool, SimulatesMeasuresAndReplays) {
  const std::vector<std::string> small = {"--bodies", "3",     "--seconds",       "1.2",    "--drop-interval",
                                          "0.1",      "--dt",  "1/240",           "--json", "tank.json",
                                          "--poses",  "p.csv", "--rebuild-steps", "3"};
  const RunResult result = tank(small);
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_NE(result.out.find("rebuild_embree+cages"), std::string::npos) << result.out;
  const auto json = nlohmann::json::parse(folder.read("tank.json"));
  EXPECT_EQ(json.at("scene"), "drop");
  EXPECT_EQ(json.at("strategies").at("prebuilt").at("steps_timed"), 288);
  EXPECT_EQ(json.at("strategies").at("rebuild_kdop").at("steps_timed"), 3);
  EXPECT_GT(json.at("oracle_bodies_per_step"), 0);
  EXPECT_EQ(json.at("missed_contacts"), 0);
  EXPECT_EQ(json.at("spurious"), 0);
  EXPECT_EQ(json.at("interpenetrations"), 0);
  EXPECT_EQ(json.at("exact_checks"), 20);
  EXPECT_EQ(json.at("trajectory_hash").get<std::string>().size(), 32U);
  EXPECT_EQ(json.at("simulation").at("steps"), 288);

  const RunResult replayed = tank({"--replay", "p.csv", "--every", "2", "--json", "replay.json", "--runs", "1"});
  ASSERT_EQ(replayed.status, 0) << replayed.err;
  const auto again = nlohmann::json::parse(folder.read("replay.json"));
  EXPECT_EQ(again.at("scene"), "replay");
  EXPECT_EQ(again.at("steps"), 144);
  EXPECT_FALSE(again.contains("simulation"));
}

TEST_F(TankTool, RefusesBadInput) {
  expect_refused({"--dt", "0"}, "--dt 0");
  expect_refused({"--scene", "stirred"}, "--scene");
  expect_refused({"--json", "nowhere/tank.json"}, "nowhere");
  expect_refused({"--replay", "missing.csv"}, "missing.csv");
  expect_refused({"--replay", "p.csv", "--bodies", "3"}, "--replay");
  expect_refused({"--faces", "20000"}, "--faces");
  // Its cage has as many faces, which are no work to find.
  folder.write("ring.obj", to_obj(torus(12, 8)));
  expect_refused({"--cage-level", "9", "--seconds", "0.1"}, "--cage-level 9");
  expect_refused({"--width", "0.1", "--seconds", "0.1"}, "width");
}

}  // namespace
}  // namespace encage::test

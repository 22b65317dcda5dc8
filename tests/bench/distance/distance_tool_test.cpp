// SPDX-License-Identifier: GPL-3.0-or-later
// The program encage-distance.

#include <encage/asset.h>
#include <encage/bake.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/cagegen/tool/meshes.h"
#include "tests/cagegen/tool/run.h"

namespace encage::test {
namespace {

class DistanceTool : public testing::Test {
 protected:
  DistanceTool() {
    BakeOptions options;
    options.faces = {200};
    write_asset(folder.path() / "ring.glb", bake(torus(24, 12), options));
    folder.write("poses.csv",
                 "step,body,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,0,1\n0,1,1,0,1.5,0,0,0,1\n"
                 "1,0,0,0,0.1,0,0,0,1\n1,1,1,0,1.5,0,0,0,1\n2,0,0,0,0.2,0,0,0,1\n2,1,1,0,0.62,0,0,0,1\n");
  }

  RunResult run_tool(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {ENCAGE_DISTANCE_BINARY, "--asset", "ring.glb", "--poses", "poses.csv"});
    return run(arguments, folder.path());
  }

  ScratchFolder folder;
};

TEST_F(DistanceTool, AgreesWithFcl) {
  const RunResult result = run_tool({"--every", "1", "--runs", "2", "--json", "distance.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_NE(result.out.find("| FCL, OBBRSS |"), std::string::npos) << result.out;
  const auto json = nlohmann::json::parse(folder.read("distance.json"));
  const auto& classes = json.at("classes");
  ASSERT_GE(classes.size(), 2U);
  EXPECT_EQ(classes.back().at("class"), "10 diagonals and more");
  EXPECT_EQ(classes.back().at("pairs"), 3);
  for (const auto& one : classes) {
    ASSERT_EQ(one.at("rows").size(), 7U);
    for (const auto& row : one.at("rows")) EXPECT_EQ(row.at("wrong"), 0) << row;
  }
}

TEST_F(DistanceTool, RefusesBadInput) {
  folder.write("alone.csv", "step,body,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,0,1\n");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--every", "0"}, "--every"},
      {{"--runs", "0"}, "--runs"},
      {{"--json", "poses.csv"}, "poses.csv"},
  };
  for (const auto& [arguments, named] : cases) {
    const RunResult result = run_tool(arguments);
    EXPECT_EQ(result.status, 2) << named;
    EXPECT_NE(result.err.find(named), std::string::npos) << "'" << named << "' is not in: " << result.err;
  }
  const RunResult alone = run({ENCAGE_DISTANCE_BINARY, "--asset", "ring.glb", "--poses", "alone.csv"}, folder.path());
  EXPECT_EQ(alone.status, 2);
  EXPECT_NE(alone.err.find("no pairs"), std::string::npos) << alone.err;
}

}  // namespace
}  // namespace encage::test

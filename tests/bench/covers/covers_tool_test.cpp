// SPDX-License-Identifier: GPL-3.0-or-later
// The program encage-covers.

#include <encage/asset.h>
#include <encage/bake.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/cagegen/tool/meshes.h"
#include "tests/cagegen/tool/run.h"

namespace encage::test {
namespace {

class CoversTool : public testing::Test {
 protected:
  CoversTool() {
    BakeOptions options;
    options.faces = {200};
    write_asset(folder.path() / "ring.glb", bake(torus(24, 12), options));
    folder.write("poses.csv",
                 "step,body,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,0,1\n0,1,1,0,1.5,0,0,0,1\n"
                 "1,0,0,0,0.1,0,0,0,1\n1,1,1,0,1.5,0,0,0,1\n2,0,0,0,0.2,0,0,0,1\n2,1,1,0,0.62,0,0,0,1\n");
  }

  RunResult run_tool(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {ENCAGE_COVERS_BINARY, "--asset", "ring.glb", "--poses", "poses.csv"});
    return run(arguments, folder.path());
  }

  ScratchFolder folder;
};

TEST_F(CoversTool, ComparesCovers) {
  const RunResult result =
      run_tool({"--balls", "20,50", "--boxes", "30", "--every", "1", "--runs", "2", "--json", "covers.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_NE(result.out.find("At rest: 3 steps"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("| 20 balls, then cage of "), std::string::npos) << result.out;
  const auto json = nlohmann::json::parse(folder.read("covers.json"));
  EXPECT_EQ(json.at("moving").at("steps"), 2);
  for (const char* kind : {"resting", "moving"}) {
    const auto& all = json.at(kind).at("representations");
    ASSERT_EQ(all.size(), 10U);
    EXPECT_EQ(all.at(0).at("name"), "fine mesh");
    EXPECT_EQ(all.at(0).at("rejected"), json.at(kind).at("rejectable"));
  }
}

TEST_F(CoversTool, RefusesBadInput) {
  folder.write("empty.csv", "step,body,x,y,z,qx,qy,qz,qw\n");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--balls", "0"}, "--balls"},
      {{"--every", "0"}, "--every"},
      {{"--json", "poses.csv"}, "poses.csv"},
  };
  for (const auto& [arguments, named] : cases) {
    const RunResult result = run_tool(arguments);
    EXPECT_EQ(result.status, 2) << named;
    EXPECT_NE(result.err.find(named), std::string::npos) << "'" << named << "' is not in: " << result.err;
  }
  const RunResult empty = run({ENCAGE_COVERS_BINARY, "--asset", "ring.glb", "--poses", "empty.csv"}, folder.path());
  EXPECT_EQ(empty.status, 2);
  EXPECT_NE(empty.err.find("no poses"), std::string::npos) << empty.err;
}

}  // namespace
}  // namespace encage::test

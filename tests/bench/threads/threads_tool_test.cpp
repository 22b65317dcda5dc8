// SPDX-License-Identifier: GPL-3.0-or-later
// The program encage-threads.

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

class ThreadsTool : public testing::Test {
 protected:
  ThreadsTool() {
    const TriangleMesh ring = torus(24, 12);
    BakeOptions options;
    options.faces = {200};
    write_asset(folder.path() / "ring.glb", bake(ring, options));
    // The first step lacks a body.
    folder.write("poses.csv",
                 "step,body,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,0,1\n"
                 "1,0,0,0,0,0,0,0,1\n1,1,1,0,0,0.70710678118654752,0,0,0.70710678118654752\n"
                 "2,0,0,0,0.1,0,0,0,1\n2,1,1,0.2,0,0.70710678118654752,0,0,0.70710678118654752\n"
                 "3,0,0,0,0.2,0,0,0,1\n3,1,1,0.4,0,0.70710678118654752,0,0,0.70710678118654752\n");
  }

  RunResult run_tool(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {ENCAGE_THREADS_BINARY, "--asset", "ring.glb", "--poses", "poses.csv"});
    return run(arguments, folder.path());
  }

  ScratchFolder folder;
};

TEST_F(ThreadsTool, ComparesNumbersOfThreads) {
  const RunResult result = run_tool({"--threads", "1,2,3", "--copies", "4", "--every", "2", "--continuous",
                                     "--triangles", "--runs", "2", "--json", "threads.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_NE(result.out.find("8 bodies, 2 steps"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("The same results in the same order."), std::string::npos);
  const auto json = nlohmann::json::parse(folder.read("threads.json"));
  EXPECT_EQ(json.at("bodies"), 8);
  EXPECT_EQ(json.at("steps"), 2);
  EXPECT_EQ(json.at("different_steps"), 0);
  ASSERT_EQ(json.at("threads").size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const auto& one = json.at("threads").at(i);
    EXPECT_EQ(one.at("threads"), i + 1);
    EXPECT_GT(one.at("search_ms_per_step"), 0);
    EXPECT_GT(one.at("update_ms_per_step"), 0);
    EXPECT_GT(one.at("search_ratio"), 0);
  }
}

TEST_F(ThreadsTool, RefusesBadInput) {
  folder.write("empty.csv", "step,body,x,y,z,qx,qy,qz,qw\n");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--threads", "0"}, "--threads"},
      {{"--every", "0"}, "--every"},
      {{"--json", "poses.csv"}, "poses.csv"},
  };
  for (const auto& [arguments, named] : cases) {
    const RunResult result = run_tool(arguments);
    EXPECT_EQ(result.status, 2) << named;
    EXPECT_NE(result.err.find(named), std::string::npos) << "'" << named << "' is not in: " << result.err;
  }
  const RunResult empty = run({ENCAGE_THREADS_BINARY, "--asset", "ring.glb", "--poses", "empty.csv"}, folder.path());
  EXPECT_EQ(empty.status, 2);
  EXPECT_NE(empty.err.find("no poses"), std::string::npos) << empty.err;
}

}  // namespace
}  // namespace encage::test

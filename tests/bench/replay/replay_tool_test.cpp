// SPDX-License-Identifier: GPL-3.0-or-later
// The program encage-replay, and what it loads.

#include <encage/asset.h>
#include <encage/bake.h>
#include <encage/error.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/replay/mesh_shape.h"
#include "tests/cagegen/tool/meshes.h"
#include "tests/cagegen/tool/run.h"

namespace encage::test {
namespace {

constexpr const char* header = "step,body,x,y,z,qx,qy,qz,qw\n";

class ReplayTool : public testing::Test {
 protected:
  ReplayTool() {
    const TriangleMesh ring = torus(24, 12);
    folder.write("ring.obj", to_obj(ring));
    BakeOptions options;
    options.faces = {200};
    write_asset(folder.path() / "ring.glb", bake(ring, options));
    // Linked rings that do not touch, one apart from them, and one that touches it in the second step.
    folder.write("poses.csv", std::string(header) +
                                  "0,0,0,0,0,0,0,0,1\n0,1,1,0,0,0.70710678118654752,0,0,0.70710678118654752\n"
                                  "0,2,9,0,0,0,0,0,1\n0,3,9,0,3,0,0,0,1\n"
                                  "1,2,9,0,0,0,0,0,1\n1,3,9,0.7,0.1,0,0,0,1\n");
  }

  RunResult replay(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {ENCAGE_REPLAY_BINARY, "--mesh", "ring.obj", "--poses", "poses.csv"});
    return run(arguments, folder.path());
  }

  ScratchFolder folder;
};

TEST_F(ReplayTool, AllEnginesAgree) {
  const RunResult result = replay({"--cages", "ring.glb", "--json", "replay.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto json = nlohmann::json::parse(folder.read("replay.json"));
  EXPECT_EQ(json.at("steps"), 2);
  EXPECT_EQ(json.at("disagreements"), 0);
  for (const char* engine : {"encage", "fcl"}) {
    EXPECT_EQ(json.at("engines").at(engine).at("touching_pairs"), 1) << engine;
    EXPECT_GT(json.at("engines").at(engine).at("ms_per_step"), 0) << engine;
    EXPECT_GT(json.at("with_cages").at(engine).at("ms_per_step"), 0) << engine;
  }
}

TEST_F(ReplayTool, RunsWithoutCagesAndWithFewerEngines) {
  const RunResult result = replay({"--engines", "fcl", "--every", "2", "--json", "replay.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto json = nlohmann::json::parse(folder.read("replay.json"));
  EXPECT_EQ(json.at("engines").size(), 1U);
  EXPECT_FALSE(json.contains("with_cages"));
  EXPECT_EQ(json.at("steps"), 1);
}

TEST_F(ReplayTool, RefusesBadInput) {
  folder.write("other.obj", to_obj(torus(20, 12)));
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--engines", "magic"}, "--engines"},
      {{"--cages", "missing.glb"}, "missing.glb"},
      {{"--cages", "ring.glb", "--cage-level", "5"}, "--cage-level 5"},
      {{"--json", "poses.csv"}, "poses.csv"},
      {{"--mesh", "other.obj", "--cages", "ring.glb"}, "--mesh"},
  };
  for (const auto& [arguments, named] : cases) {
    const std::vector<std::string> before = folder.names();
    const RunResult result = replay(arguments);
    EXPECT_EQ(result.status, 2) << named;
    EXPECT_NE(result.err.find(named), std::string::npos) << "'" << named << "' is not in: " << result.err;
    EXPECT_EQ(folder.names(), before);
  }
}

TEST_F(ReplayTool, TheAssetMustBeOfTheMesh) {
  folder.write("other.obj", to_obj(torus(20, 12)));
  EXPECT_THROW(encage::replay::load_body(folder.path() / "other.obj", folder.path() / "ring.glb"), Error);
}

TEST_F(ReplayTool, WithoutAnAssetTheMeshAloneIsTheShape) {
  const encage::replay::Body body = encage::replay::load_body(folder.path() / "ring.obj", {});
  EXPECT_EQ(body.levels, 0);
  EXPECT_EQ(body.mesh.triangles.rows(), torus(24, 12).triangles.rows());
  const Eigen::AlignedBox3d box = world_box(*body.shape, {});
  EXPECT_TRUE(box.contains(bounds(body.mesh)));
  EXPECT_NEAR(box.diagonal().norm(), bounds(body.mesh).diagonal().norm(), 1e-5);
}

}  // namespace
}  // namespace encage::test

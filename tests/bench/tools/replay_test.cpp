// SPDX-License-Identifier: GPL-3.0-or-later
// The program encage-replay, and what it loads.

#include "bench/replay/mesh_shape.h"
#include "oracles/meshes.h"
#include "tests/cagegen/tool/meshes.h"
#include "tests/cagegen/tool/run.h"

#include <encage/asset.h>
#include <encage/bake.h>
#include <encage/error.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <string>
#include <vector>

namespace encage::test {
namespace {

constexpr const char* header = "step,body,x,y,z,qx,qy,qz,qw\n";

class ReplayTool : public testing::Test {
 protected:
  ReplayTool() {
    folder.write("ring.obj", to_obj(torus(24, 12)));
    write_asset(folder.path() / "ring.glb", baked());
    // Linked rings that do not touch, one apart from them, and one that touches it in the second step.
    folder.write("poses.csv", std::string(header) +
                                  "0,0,0,0,0,0,0,0,1\n0,1,1,0,0,0.70710678118654752,0,0,0.70710678118654752\n"
                                  "0,2,9,0,0,0,0,0,1\n0,3,9,0,3,0,0,0,1\n"
                                  "1,2,9,0,0,0,0,0,1\n1,3,9,0.7,0.1,0,0,0,1\n");
  }

  /// Once for all tests.
  static const CageHierarchy& baked() {
    static const CageHierarchy hierarchy = [] {
      BakeOptions options;
      options.coarse = {coarse_rings()[0]};
      return bake(torus(24, 12), options);
    }();
    return hierarchy;
  }

  RunResult replay(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {ENCAGE_REPLAY_BINARY, "--mesh", "ring.obj"});
    if (std::find(arguments.begin(), arguments.end(), "--poses") == arguments.end()) {
      arguments.insert(arguments.end(), {"--poses", "poses.csv"});
    }
    return run(arguments, folder.path());
  }

  ScratchFolder folder;
};

TEST_F(ReplayTool, AllEnginesAgree) {
  const RunResult result = replay({"--cages", "ring.glb", "--json", "replay.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto json = nlohmann::json::parse(folder.read("replay.json"));
  EXPECT_EQ(json.at("steps"), 2);
  EXPECT_EQ(json.at("touching_pairs"), 1);
  EXPECT_EQ(json.at("disagreements"), 0);
  for (const char* engine :
       {"encage", "fcl", "fcl_obb", "fcl_float", "bullet", "ode", "embree_refit", "embree_rebuild"}) {
    EXPECT_EQ(json.at("engines").at(engine).at("touching_pairs"), 1) << engine;
    EXPECT_GT(json.at("engines").at(engine).at("ms_per_step"), 0) << engine;
    EXPECT_EQ(json.at("with_cages").at(engine).at("touching_pairs"), 1) << engine;
    EXPECT_GT(json.at("perfect").at(engine).at("speedup"), 0) << engine;
    EXPECT_EQ(json.at("with_full").contains(engine), std::string(engine) != "encage") << engine;
    EXPECT_NE(result.out.find(std::string("| ") + engine + " "), std::string::npos) << result.out;
  }
}

TEST_F(ReplayTool, RunsWithoutCagesAndWithFewerEngines) {
  const RunResult result = replay({"--engines", "fcl", "--every", "2", "--json", "replay.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto json = nlohmann::json::parse(folder.read("replay.json"));
  EXPECT_EQ(json.at("engines").size(), 1U);
  EXPECT_FALSE(json.contains("with_cages"));
  EXPECT_TRUE(json.contains("with_full"));
  EXPECT_EQ(json.at("steps"), 1);
}

TEST_F(ReplayTool, FrontsAreChosen) {
  const RunResult result = replay({"--engines", "ode", "--cages", "ring.glb", "--front", "none", "--json", "r.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto json = nlohmann::json::parse(folder.read("r.json"));
  EXPECT_FALSE(json.contains("with_cages"));
  EXPECT_FALSE(json.contains("with_full"));
}

TEST_F(ReplayTool, ContinuousDetectionFindsTheContactOnTheWay) {
  const RunResult result = replay({"--engines", "encage", "--continuous", "--json", "replay.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto json = nlohmann::json::parse(folder.read("replay.json")).at("continuous");
  EXPECT_EQ(json.at("steps"), 1);
  EXPECT_EQ(json.at("contacts"), 1);
  EXPECT_EQ(json.at("pairs_left_out"), 0);
  EXPECT_GT(json.at("ratio"), 0);
  EXPECT_NE(result.out.find("Continuous"), std::string::npos) << result.out;
}

TEST_F(ReplayTool, PairsThatTouchedBeforeAreLeftOut) {
  folder.write("poses.csv", std::string(header) +
                                "0,0,0,0,0,0,0,0,1\n0,1,9,0,0,0,0,0,1\n"
                                "1,0,0,0,0,0,0,0,1\n1,1,1,0,0,0,0,0,1\n"
                                "2,0,0,0,0,0,0,0,1\n2,1,1.1,0,0,0,0,0,1\n");
  const RunResult result = replay({"--engines", "encage,fcl,ode", "--free", "--json", "replay.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto json = nlohmann::json::parse(folder.read("replay.json"));
  EXPECT_EQ(json.at("touching_pairs"), 1);  // in step 1
  EXPECT_EQ(json.at("pairs_left_out"), 1);  // in step 2
  EXPECT_EQ(json.at("engines").at("fcl").at("touching_pairs"), 1);
}

TEST_F(ReplayTool, SaysOfWhichPairTheEnginesDiffer) {
  // A ball in a hollow ball: the solids overlap, but no surface touches another, which is all that FCL asks.
  const TriangleMesh inner = shapes::sphere(2), outer = shapes::moved(shapes::scaled(inner, 2), {9, 0, 0});
  folder.write("ring.obj", to_obj(shapes::joined(inner, outer)));
  folder.write("poses.csv", std::string(header) + "7,0,0,0,0,0,0,0,1\n7,4,9,0,0,0,0,0,1\n");
  const RunResult result = replay({"--engines", "encage,fcl", "--front", "none", "--json", "replay.json"});
  EXPECT_EQ(result.status, 1) << result.err;
  EXPECT_NE(result.err.find("step 7, bodies 0 and 4 touch, but only by encage\n"), std::string::npos) << result.err;
  const auto json = nlohmann::json::parse(folder.read("replay.json"));
  EXPECT_EQ(json.at("disagreements"), 1);
  EXPECT_EQ(json.at("disagreeing_pairs").at(0).at("truth"), true);
  EXPECT_EQ(json.at("engines").at("fcl").at("missed"), 1);
  EXPECT_EQ(json.at("engines").at("encage").at("missed"), 0);
}

TEST_F(ReplayTool, RefusesBadInput) {
  folder.write("other.obj", to_obj(torus(20, 12)));
  folder.write("one.csv", std::string(header) + "0,0,0,0,0,0,0,0,1\n");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--engines", "magic"}, "--engines"},
      {{"--front", "magic"}, "--front"},
      {{"--continuous", "--every", "2", "--poses", "one.csv"}, "one.csv"},
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
  const encage::replay::ReplayBody body = encage::replay::load_body(folder.path() / "ring.obj", {});
  EXPECT_EQ(body.levels, 0);
  EXPECT_EQ(body.mesh.triangles.rows(), torus(24, 12).triangles.rows());
  const Eigen::AlignedBox3d box = world_box(*body.shape, {});
  EXPECT_TRUE(box.contains(bounds(body.mesh)));
  EXPECT_NEAR(box.diagonal().norm(), bounds(body.mesh).diagonal().norm(), 1e-5);
}

}  // namespace
}  // namespace encage::test

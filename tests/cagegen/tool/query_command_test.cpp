// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/tool/command.h"

#include <encage/asset.h>
#include <encage/poses.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace encage::tool {
namespace {

TriangleMesh box(double half) {
  TriangleMesh mesh;
  mesh.vertices.resize(8, 3);
  for (int i = 0; i < 8; ++i)
    mesh.vertices.row(i) << (i & 1 ? half : -half), (i & 2 ? half : -half), (i & 4 ? half : -half);
  mesh.triangles.resize(12, 3);
  mesh.triangles << 0, 2, 1, 1, 2, 3, 0, 1, 4, 1, 5, 4, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5, 2, 6, 3, 3, 6, 7, 4, 5, 6,
      5, 7, 6;
  return mesh;
}

/// A box of half width 1 in cages of the given half widths.
CageHierarchy boxes(const std::vector<double>& cages) {
  CageHierarchy h;
  h.fine = box(1);
  h.diagonal = bounds(h.fine).diagonal().norm();
  h.source_volume = 8;
  h.options = "{}";
  for (const double half : cages) {
    CageLevel level{box(half), {}};
    level.certificate.clearance = 1e-3;
    level.certificate.volume = 8 * half * half * half;
    level.certificate.volume_ratio = half * half * half;
    level.certificate.components = 1;
    h.levels.push_back(level);
  }
  return h;
}

class QueryCommand : public testing::Test {
 protected:
  QueryCommand() : folder_(std::filesystem::temp_directory_path() / ("encage_query_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
    write_asset(path("two.glb"), boxes({1.0625, 1.5}));
    write_asset(path("one.glb"), boxes({1.25}));
    write_poses(path("poses.csv"), {step(4, {0, 1.9, 9}), step(5, {0, 2.6, 5.4}), step(6, {0, 4.5})});
  }
  ~QueryCommand() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  // Bodies along (1,1,0), turned so that their faces meet: world boxes overlap up to a distance of 4.
  static PoseStep step(std::int64_t number, const std::vector<double>& places) {
    PoseStep result{number, {}};
    for (const double place : places) {
      BodyPose body;
      body.body = static_cast<std::int32_t>(result.bodies.size());
      body.pose.linear() = Eigen::Quaterniond(0.9238795325112867, 0, 0, 0.3826834323650898).toRotationMatrix();
      body.pose.translation() = Eigen::Vector3d(place, place, 0) / 1.4142135623730951;
      result.bodies.push_back(body);
    }
    return result;
  }

  /// Runs the subcommand; returns what it printed.
  std::string run(std::vector<std::string> arguments) {
    CLI::App app;
    int status = success;
    add_query(app, status);
    arguments.insert(arguments.begin(), "query");
    std::reverse(arguments.begin(), arguments.end());
    testing::internal::CaptureStdout();
    try {
      app.parse(arguments);
    } catch (...) {
      testing::internal::GetCapturedStdout();
      throw;
    }
    EXPECT_EQ(status, success);
    return testing::internal::GetCapturedStdout();
  }

  nlohmann::json json() const { return nlohmann::json::parse(std::ifstream(folder_ / "out.json")); }

  std::filesystem::path folder_;
};

TEST_F(QueryCommand, CountsWhatEachStageLeaves) {
  const std::string table = run({path("two.glb"), "--poses", path("poses.csv"), "--json", path("out.json")});
  const nlohmann::json expected = nlohmann::json::parse(R"([
    {"step": 4, "pairs": 3, "boxes": 1, "cages": [1, 1], "touching": 1},
    {"step": 5, "pairs": 3, "boxes": 2, "cages": [0, 2], "touching": 0},
    {"step": 6, "pairs": 1, "boxes": 0, "cages": [0, 0], "touching": 0}])");
  EXPECT_EQ(json()["steps"], expected);
  EXPECT_EQ(json()["totals"],
            nlohmann::json::parse(R"({"steps": 3, "pairs": 7, "boxes": 3, "cages": [1, 3], "touching": 1})"));
  EXPECT_EQ(json()["levels"][1]["faces_a"], 12);
  EXPECT_NE(table.find("all                                      2.333"), std::string::npos) << table;
  EXPECT_NE(table.find("fine meshes (left: touching)             0.333       0.000"), std::string::npos) << table;
}

TEST_F(QueryCommand, SecondAssetIsForEveryBodyButTheFirst) {
  run({path("one.glb"), path("two.glb"), "--poses", path("poses.csv"), "--json", path("out.json")});
  // Body 0 has the one cage of 1.25: apart from 1.5 at no distance below 2.75, from 1.0625 beyond 2.3125.
  EXPECT_EQ(json()["steps"][1]["cages"], nlohmann::json::parse("[0, 2]"));
  EXPECT_EQ(json()["levels"].size(), 2u);
}

TEST_F(QueryCommand, MarginAndSampling) {
  run({path("two.glb"), "--poses", path("poses.csv"), "--margin", "0.55", "--every", "2", "--json", path("out.json")});
  ASSERT_EQ(json()["steps"].size(), 2u);
  EXPECT_EQ(json()["steps"][1]["step"], 6);
  EXPECT_EQ(json()["totals"]["touching"], 1);
  run({path("two.glb"), "--poses", path("poses.csv"), "--margin", "0.61", "--json", path("out.json")});
  EXPECT_EQ(json()["steps"][1]["touching"], 1) << "0.6 apart";
}

TEST_F(QueryCommand, ContinuousStepsAreMotionsToTheNext) {
  const std::string lines = run({path("two.glb"), "--poses", path("poses.csv"), "--continuous", "--per-step"});
  // 2 moves from 9 to 5.4, 1 from 1.9 to 2.6: their swept boxes meet, but they are never nearer than 2.8; then 2 is
  // gone.
  EXPECT_EQ(lines, "step,pairs,boxes,cages_12,cages_12,touching\n4,3,2,2,1,1\n5,1,1,1,0,0\n");
}

TEST_F(QueryCommand, BadInputIsRefused) {
  const std::string poses = path("poses.csv"), asset = path("two.glb");
  EXPECT_THROW(run({asset, "--poses", path("missing.csv")}), Error);
  EXPECT_THROW(run({path("missing.glb"), "--poses", poses}), Error);
  EXPECT_THROW(run({poses, "--poses", poses}), Error);
  EXPECT_THROW(run({asset, "--poses", poses, "--margin", "-1"}), Error);
  EXPECT_THROW(run({asset, "--poses", poses, "--margin", "inf"}), Error);
  EXPECT_THROW(run({asset, "--poses", poses, "--every", "0"}), Error);
  EXPECT_THROW(run({asset}), CLI::ParseError);
  std::ofstream(path("half_turn.csv")) << "step,body,x,y,z,qx,qy,qz,qw\n0,7,0,0,0,0,0,0,1\n1,7,0,0,0,1,0,0,0\n";
  try {
    run({asset, "--poses", path("half_turn.csv"), "--continuous"});
    ADD_FAILURE() << "a half turn was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.what(),
              path("half_turn.csv") + ": step 0: body 7 turns by 180 degrees or more until the next step");
  }
  std::ofstream(path("out.json")) << "kept";
  EXPECT_THROW(run({asset, "--poses", path("missing.csv"), "--json", path("out.json")}), Error);
  std::string content;
  std::ifstream(path("out.json")) >> content;
  EXPECT_EQ(content, "kept");
}

}  // namespace
}  // namespace encage::tool

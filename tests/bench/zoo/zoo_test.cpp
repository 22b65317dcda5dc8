// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/zoo.h"

#include "tests/cagegen/tool/meshes.h"
#include "tests/cagegen/tool/run.h"

#include <encage/error.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

namespace encage::zoo {
namespace {

namespace fs = std::filesystem;

class Zoo : public ::testing::Test {
 protected:
  Zoo() {
    fs::create_directory(folder.path() / "sub");
    folder.write("ring.obj", test::to_obj(test::torus(12, 8)));
    folder.write("sub/points.OFF", "OFF\n2 0 0\n0 0 0\n1 1 1\n");
    folder.write("notes.txt", "none");
  }
  test::ScratchFolder folder;
};

TEST_F(Zoo, FindsMeshFilesInOrder) {
  EXPECT_EQ(mesh_files({folder.path()}),
            (std::vector<fs::path>{folder.path() / "ring.obj", folder.path() / "sub" / "points.OFF"}));
  EXPECT_EQ(mesh_files({folder.path() / "ring.obj"}).size(), 1U);
  EXPECT_THROW(mesh_files({folder.path() / "missing"}), Error);
}

TEST_F(Zoo, BakesAMeshAndTakesItsPictures) {
  BakeOptions options;
  options.faces = {60};
  const Model model = bake_model(folder.path() / "ring.obj", options, folder.path() / "sub");
  ASSERT_EQ(model.outcome, Model::Outcome::baked) << model.error;
  EXPECT_TRUE(model.clean());
  EXPECT_TRUE(model.certified());
  EXPECT_GT(model.cpu_seconds(), 0);
  EXPECT_GT(model.figures.at("peak_rss_bytes"), 1 << 20);
  for (const char* picture : {"ring.obj-input.png", "ring.obj-section.png", "ring.obj-cage.png"}) {
    EXPECT_TRUE(folder.read(std::string("sub/") + picture).starts_with("\x89PNG")) << picture;
  }
}

TEST_F(Zoo, APointSetIsNoMesh) {
  const Model model = bake_model(folder.path() / "sub" / "points.OFF", {}, {});
  EXPECT_EQ(model.outcome, Model::Outcome::no_mesh);
  EXPECT_NE(model.error, "");
}

TEST_F(Zoo, AMeshWithoutCagesHasFailed) {
  folder.write("point.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n");
  const Model model = bake_model(folder.path() / "point.obj", {}, {});
  EXPECT_EQ(model.outcome, Model::Outcome::failed);
  EXPECT_NE(model.error.find("point.obj"), std::string::npos) << model.error;
}

TEST_F(Zoo, TheProgramWritesItsReports) {
  const test::RunResult result =
      test::run({ENCAGE_ZOO_BINARY, ".", "--faces", "60", "--json", "zoo.json", "--markdown", "zoo.md"}, folder.path());
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_NE(result.out.find("certified: 1 of 1 meshes"), std::string::npos) << result.out;
  EXPECT_EQ(nlohmann::json::parse(folder.read("zoo.json")).at("models").size(), 2U);
  EXPECT_NE(folder.read("zoo.md").find("| ring.obj |"), std::string::npos);
}

TEST_F(Zoo, SetsMethodsSideBySide) {
  const test::RunResult result = test::run({ENCAGE_ZOO_BINARY, ".", "--faces", "30", "--method", "auto,flow,collapse",
                                            "--json", "zoo.json", "--markdown", "zoo.md", "--gallery", "pictures"},
                                           folder.path());
  EXPECT_EQ(result.status, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(folder.read("zoo.json"));
  EXPECT_EQ(json.at("models").size(), 6U);
  for (const char* method : {"auto", "flow", "collapse"}) {
    EXPECT_EQ(json.at("summaries").at(method).at("certified"), 1);
    EXPECT_TRUE(fs::exists(folder.path() / "pictures" / method / "ring.obj-cage.png"));
  }
  const auto excess = [&](int i) { return json["models"][i].at("levels")[0].at("volume_ratio").get<double>(); };
  EXPECT_EQ(json["models"][0].at("method"), "auto");
  EXPECT_LE(excess(0), std::min(excess(2), excess(4)));
  EXPECT_NE(folder.read("zoo.md").find("| ring.obj |"), std::string::npos);
}

TEST_F(Zoo, BaselinesRunOnCleanMeshes) {
  // The offset contour takes the longer the fewer faces it may have.
  folder.write("ring.obj", test::to_obj(test::torus(24, 12)));
  folder.write("sheet.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
  const test::RunResult result =
      test::run({ENCAGE_ZOO_BINARY, "ring.obj", "sheet.obj", "--faces", "2000,500", "--method", "collapse",
                 "--baselines", "--json", "zoo.json", "--markdown", "zoo.md"},
                folder.path());
  EXPECT_EQ(result.status, 0) << result.err;
  const nlohmann::json models = nlohmann::json::parse(folder.read("zoo.json")).at("models");
  // Both meshes by collapse; the baselines on the ring alone, which has fewer faces than the first level.
  ASSERT_EQ(models.size(), 5U);
  const std::vector<std::string> names = {"collapse", "collapse", "alpha wrap", "progressive hull", "offset contour"};
  for (std::size_t i = 0; i < models.size(); ++i) EXPECT_EQ(models[i].at("method"), names[i]);
  for (std::size_t i = 2; i < models.size(); ++i) {
    EXPECT_TRUE(models[i].at("levels").at(0).is_null());
    const nlohmann::json& level = models[i].at("levels").at(1);
    if (level.at("certified")) {
      EXPECT_GT(level.at("volume_ratio"), 1) << names[i];
      EXPECT_EQ(level.at("hits"), 0) << names[i];
    }
  }
  EXPECT_EQ(models[2].at("levels").at(1).at("certified"), true);
  EXPECT_NE(folder.read("zoo.md").find("| alpha wrap | 500 | 1 | 1 | 1 | 0 | 0 |"), std::string::npos);
}

TEST_F(Zoo, ABaselineThatFailsIsNoFailureOfTheRun) {
  Model known;
  known.file = folder.path() / "missing.obj";
  known.outcome = Model::Outcome::baked;
  known.figures = {{"source", {{"faces", 1000}}}, {"clean", true}};
  const Model lost = run_baseline(baselines().front(), known, {100});
  EXPECT_EQ(lost.outcome, Model::Outcome::failed);
  EXPECT_NE(lost.error, "");
  EXPECT_EQ(run_baseline(baselines().front(), known, {1000}).outcome, Model::Outcome::skipped);
  known.figures["clean"] = false;
  EXPECT_EQ(run_baseline(baselines().front(), known, {100}).outcome, Model::Outcome::skipped);
}

TEST_F(Zoo, BadUsageIsRefused) {
  EXPECT_EQ(test::run({ENCAGE_ZOO_BINARY}, folder.path()).status, 2);
  EXPECT_EQ(test::run({ENCAGE_ZOO_BINARY, "missing"}, folder.path()).status, 2);
  EXPECT_EQ(test::run({ENCAGE_ZOO_BINARY, ".", "--json", "nowhere/zoo.json"}, folder.path()).status, 2);
  EXPECT_EQ(test::run({ENCAGE_ZOO_BINARY, ".", "--method", "magic"}, folder.path()).status, 2);
  EXPECT_EQ(test::run({ENCAGE_ZOO_BINARY, ".", "--method", "auto,magic"}, folder.path()).status, 2);
}

}  // namespace
}  // namespace encage::zoo

// SPDX-License-Identifier: GPL-3.0-or-later
// The options of the flow in `encage bake`.
#include "oracles/meshes.h"
#include "tests/cagegen/tool/command_fixture.h"

#include <encage/asset.h>

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace encage::test {
namespace {

using Json = nlohmann::json;

class BakeFlowCommand : public CommandTest {
 protected:
  /// A ball, and coarse meshes for it.
  BakeFlowCommand() {
    folder.write("ball.obj", to_obj(shapes::sphere(3)));
    folder.write("fine.obj", to_obj(shapes::sphere(2)));
    folder.write("coarse.obj", to_obj(shapes::sphere(1)));
  }

  Json options_of(const std::string& asset) { return Json::parse(read_asset(folder.path() / asset).options); }
};

TEST_F(BakeFlowCommand, FlowAndItsFigures) {
  const RunResult result =
      encage({"bake", "ball.obj", "--method", "flow", "--faces", "100,40", "--json", "a.json", "--decimator", "regular",
              "--energy-inflate", "start", "--energy-final", "step", "--path", "history"});
  ASSERT_EQ(result.status, 0) << result.err;
  const Json json = Json::parse(folder.read("a.json"));
  ASSERT_EQ(json.at("levels").size(), 2U);
  for (const Json& level : json["levels"]) {
    EXPECT_EQ(level.at("method"), "flow");
    EXPECT_NE(level.at("start"), "");
    EXPECT_GE(level.at("flow_seconds"), 0);
    EXPECT_GT(level.at("reinflate_seconds"), 0);
    EXPECT_LE(level.at("flow_seconds").get<double>() + level.at("reinflate_seconds").get<double>(),
              level.at("seconds").get<double>());
  }
  EXPECT_FALSE(json.contains("failure"));
  const Json options = options_of("ball.glb");
  EXPECT_EQ(options.at("method"), "flow");
  EXPECT_EQ(options.at("decimator"), "regular");
  EXPECT_EQ(options.at("energy_inflate"), "start");
  EXPECT_EQ(options.at("energy_final"), "step");
  EXPECT_EQ(options.at("path"), "history");
  const RunResult info = encage({"info", "ball.glb"});
  EXPECT_NE(info.out.find(", flow from "), std::string::npos) << info.out;
  EXPECT_EQ(encage({"check", "ball.glb", "--source", "ball.obj"}).status, 0);
}

TEST_F(BakeFlowCommand, AutomaticIsTheDefault) {
  ASSERT_EQ(encage({"bake", "ball.obj", "-o", "default.glb", "--faces", "60"}).status, 0);
  ASSERT_EQ(encage({"bake", "ball.obj", "-o", "auto.glb", "--faces", "60", "--method", "auto"}).status, 0);
  EXPECT_EQ(folder.read("default.glb"), folder.read("auto.glb"));
  EXPECT_EQ(options_of("auto.glb").at("energy_final"), "volume");
}

TEST_F(BakeFlowCommand, CoarseMeshesBecomeCages) {
  // The second one of quadrilaterals.
  folder.write("box.obj",
               "v -2 -2 -2\nv 2 -2 -2\nv 2 2 -2\nv -2 2 -2\nv -2 -2 2\nv 2 -2 2\nv 2 2 2\nv -2 2 2\n"
               "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  const RunResult result = encage({"bake", "ball.obj", "--coarse", "fine.obj,box.obj"});
  ASSERT_EQ(result.status, 0) << result.err;
  const CageHierarchy cages = read_asset(folder.path() / "ball.glb");
  ASSERT_EQ(cages.levels.size(), 2U);
  EXPECT_EQ(cages.levels[0].mesh.triangles.rows(), 128);
  EXPECT_EQ(cages.levels[1].mesh.triangles.rows(), 12);
  EXPECT_EQ(options_of("ball.glb").at("coarse_meshes"), 2);
  EXPECT_EQ(encage({"check", "ball.glb", "--source", "ball.obj"}).status, 0);
}

TEST_F(BakeFlowCommand, BadCoarseMeshesAreNamed) {
  TriangleMesh open = shapes::sphere(1);
  open.triangles.conservativeResize(open.triangles.rows() - 1, 3);
  folder.write("open.obj", to_obj(open));
  folder.write("inward.obj", to_obj(shapes::flipped(shapes::sphere(1))));
  folder.write("crossing.obj",
               to_obj(shapes::joined(shapes::cube(2), shapes::cube(2, Eigen::Vector3d(0.3, 0.2, 0.1)))));
  folder.write("ball.glb", "precious");
  for (const std::string name : {"open", "inward", "crossing"}) {
    expect_refused({"bake", "ball.obj", "-o", "ball.glb", "--coarse", "fine.obj," + name + ".obj"},
                   "encage: ball.obj: level 2: the coarse mesh '" + name + ".obj': ");
  }
  folder.write("nan.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 1\nf 1 2 3\n");
  expect_refused({"bake", "ball.obj", "-o", "ball.glb", "--coarse", "nan.obj"}, "encage: nan.obj");
  expect_refused({"bake", "ball.obj", "-o", "ball.glb", "--coarse", "fine.obj,missing.obj"}, "encage: missing.obj");
  EXPECT_EQ(folder.read("ball.glb"), "precious");
  // Nor is a coarse mesh overwritten.
  folder.write("mine.glb", "precious");
  expect_refused({"bake", "ball.obj", "-o", "mine.glb", "--coarse", "mine.glb"}, "would overwrite the input");
}

/// A ball in the tube of a ring, which as second cage has a handle too many.
TEST_F(BakeFlowCommand, KeepPartialWritesTheLevelsBefore) {
  const auto ball = [](double radius) {
    return to_obj(shapes::moved(shapes::scaled(shapes::sphere(2), radius), {2, 0, 0}));
  };
  folder.write("core.obj", ball(0.3));
  folder.write("around.obj", ball(0.6));
  folder.write("ring.obj", to_obj(shapes::torus(2, 1, 12, 8)));
  folder.write("core.glb", "precious");
  const std::vector<std::string> command = {
      "bake", "core.obj", "-o", "core.glb", "--coarse", "around.obj,ring.obj", "--topology", "keep"};
  expect_refused(command, "encage: core.obj: level 2 (192 faces): ");
  EXPECT_EQ(folder.read("core.glb"), "precious");

  std::vector<std::string> partial = command;
  partial.insert(partial.end(), {"--keep-partial", "--json", "a.json"});
  const RunResult result = encage(partial);
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.err.find("encage: core.obj: level 2 (192 faces): "), std::string::npos) << result.err;
  EXPECT_EQ(read_asset(folder.path() / "core.glb").levels.size(), 1U);
  const Json json = Json::parse(folder.read("a.json"));
  EXPECT_EQ(json.at("levels").size(), 1U);
  EXPECT_TRUE(json.at("failure").get<std::string>().starts_with("level 2 (192 faces): "));
  EXPECT_EQ(encage({"check", "core.glb", "--source", "core.obj"}).status, 0);
}

TEST_F(BakeFlowCommand, ContradictionsNameBothOptions) {
  const std::vector<std::pair<std::vector<std::string>, std::vector<std::string>>> pairs = {
      {{"--coarse", "coarse.obj"}, {"--faces", "60"}},
      {{"--coarse", "coarse.obj"}, {"--ratio", "0.5"}},
      {{"--coarse", "coarse.obj"}, {"--levels", "2"}},
      {{"--coarse", "coarse.obj"}, {"--decimator", "regular"}},
      {{"--method", "collapse"}, {"--coarse", "coarse.obj"}},
      {{"--method", "collapse"}, {"--decimator", "adaptive"}},
      {{"--method", "collapse"}, {"--energy-inflate", "step"}},
      {{"--method", "collapse"}, {"--energy-final", "volume"}},
      {{"--method", "collapse"}, {"--path", "straight"}}};
  for (const auto& [one, other] : pairs) {
    std::vector<std::string> command = {"bake", "ball.obj"};
    command.insert(command.end(), one.begin(), one.end());
    command.insert(command.end(), other.begin(), other.end());
    expect_refused(command, one[0]);
    expect_refused(command, other[0]);
  }
}

TEST_F(BakeFlowCommand, BadOptionsAreNamed) {
  const std::vector<std::vector<std::string>> bad = {{"--decimator", "magic"},
                                                     {"--energy-inflate", "magic"},
                                                     {"--energy-final", "Volume"},
                                                     {"--path", "curved"},
                                                     {"--coarse"},
                                                     {"--decimator"}};
  for (std::vector<std::string> options : bad) {
    const std::string named = options[0];
    options.insert(options.begin(), {"bake", "ball.obj"});
    expect_refused(options, named);
  }
  expect_refused({"bake", "ball.obj", "--energy-final", "magic"}, "start, step, volume");
}

}  // namespace
}  // namespace encage::test

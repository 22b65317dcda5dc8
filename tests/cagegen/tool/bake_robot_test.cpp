// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/tool/urdf.h"
#include "tests/cagegen/tool/command_fixture.h"

#include <encage/asset.h>

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace encage::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class BakeRobot : public CommandTest {
 protected:
  void SetUp() override {
    if (!tool::has_urdf()) GTEST_SKIP() << "built without pugixml";
  }

  static std::string robot(const std::string& links) {
    return "<?xml version=\"1.0\"?>\n<robot name=\"arm\">" + links + "</robot>\n";
  }
  static std::string link(const std::string& name, const std::string& collisions) {
    return "<link name=\"" + name + "\"><visual><geometry><mesh filename=\"never.dae\"/></geometry></visual>" +
           collisions + "</link>";
  }
  static std::string collision(const std::string& mesh, const std::string& origin = "") {
    return "<collision>" + origin + "<geometry><mesh filename=\"" + mesh + "\"/></geometry></collision>";
  }
  static std::string scaled(const std::string& mesh, const std::string& scale) {
    return collision(mesh + "\" scale=\"" + scale);
  }
  CageHierarchy asset(const std::string& name) { return read_asset(folder.path() / name, Verify::all); }
};

TEST_F(BakeRobot, EveryCollisionMeshBecomesAnAsset) {
  folder.write("robot.urdf", robot(link("base", collision("model.obj", "<origin xyz=\"1 2 3\" rpy=\"0 0 1.5\"/>")) +
                                   link("hand/left", scaled("model.obj", "2 1 1") + scaled("model.obj", "-1 1 1")) +
                                   link("wheel", collision("model.obj")) +
                                   link("camera", "<collision><geometry><box size=\"1 1 1\"/></geometry></collision>") +
                                   link("tip", "") + "<joint name=\"j\" type=\"fixed\"/>"));
  const RunResult result =
      encage({"bake", "robot.urdf", "--method", "collapse", "--faces", "12", "--json", "robot.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_NE(result.err.find("note: robot.urdf: skipped: 1 collision shape without a mesh: box\n"), std::string::npos)
      << result.err;
  EXPECT_NE(result.out.find("wrote robot/hand_left_1.glb\n"), std::string::npos) << result.out;

  // The origin is where the link has the mesh: the asset is that of the mesh.
  ASSERT_EQ(encage({"bake", "model.obj", "--method", "collapse", "--faces", "12"}).status, 0);
  EXPECT_EQ(folder.read("robot/base.glb"), folder.read("model.glb"));
  EXPECT_EQ(folder.read("robot/wheel.glb"), folder.read("model.glb"));
  const double volume = asset("model.glb").source_volume;
  EXPECT_NEAR(asset("robot/hand_left_0.glb").source_volume, 2 * volume, 1e-5);
  EXPECT_NEAR(asset("robot/hand_left_1.glb").source_volume, volume, 1e-5);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path() / "robot"), fs::directory_iterator()), 4);

  const Json json = Json::parse(folder.read("robot.json"));
  EXPECT_EQ(json.at("robot"), "arm");
  ASSERT_EQ(json.at("bodies").size(), 4U);
  const Json& base = json["bodies"][0];
  EXPECT_EQ(base.at("link"), "base");
  EXPECT_EQ(base.at("asset"), "robot/base.glb");
  EXPECT_EQ(base.at("origin").at("xyz"), (Json{1, 2, 3}));
  EXPECT_EQ(base.at("origin").at("rpy"), (Json{0, 0, 1.5}));
  EXPECT_LE(base.at("levels").at(0).at("faces"), 12);
  EXPECT_EQ(json["bodies"][2].at("scale"), (Json{-1, 1, 1}));
  // A mirrored mesh is not inside out.
  EXPECT_EQ(json["bodies"][2].at("source").at("sanitize").at("flipped_components"), 0);
}

TEST_F(BakeRobot, PackagesAreFoundAboveTheDescription) {
  fs::create_directories(folder.path() / "arm" / "urdf");
  fs::create_directories(folder.path() / "arm" / "meshes");
  fs::create_directories(folder.path() / "hand-1.2" / "meshes");
  fs::create_directories(folder.path() / "hand-1.2" / "urdf");
  folder.write("arm/meshes/a.obj", folder.read("model.obj"));
  folder.write("hand-1.2/meshes/b.obj", folder.read("model.obj"));
  for (const std::string name : {"package://arm/meshes/a.obj", "model://arm/meshes/a.obj", "../meshes/a.obj"}) {
    folder.write("arm/urdf/arm.urdf", robot(link("a", collision(name))));
    EXPECT_EQ(encage({"bake", "arm/urdf/arm.urdf", "--method", "collapse", "--faces", "12"}).status, 0) << name;
    EXPECT_EQ(asset("arm/a.glb").fine.triangles.rows(), 576);
    fs::remove(folder.path() / "arm/a.glb");
  }
  folder.write("here.urdf", robot(link("a", collision("file://" + (folder.path() / "arm/meshes/a.obj").string()))));
  EXPECT_EQ(encage({"bake", "here.urdf", "--method", "collapse", "--faces", "12", "-o", "new"}).status, 0);
  // A package that was unpacked under another name.
  folder.write("hand-1.2/urdf/hand.urdf", robot(link("b", collision("package://hand/meshes/b.obj"))));
  const RunResult renamed =
      encage({"bake", "hand-1.2/urdf/hand.urdf", "--method", "collapse", "--faces", "12", "-o", "out"});
  EXPECT_EQ(renamed.status, 0) << renamed.err;
  EXPECT_NE(renamed.err.find("no folder is called 'hand'; its files are taken from "), std::string::npos);
}

TEST_F(BakeRobot, LongNamesOfLinksAreCut) {
  const std::string first = std::string(300, 'a') + '1', second = std::string(300, 'a') + '2';
  folder.write("robot.urdf", robot(link(first, collision("model.obj")) + link(second, collision("model.obj"))));
  const RunResult result = encage({"bake", "robot.urdf", "--method", "collapse", "--faces", "12"});
  EXPECT_EQ(result.status, 0) << result.err;
  const fs::path assets = folder.path() / "robot";
  EXPECT_TRUE(fs::exists(assets / (std::string(200, 'a') + ".glb")));
  EXPECT_TRUE(fs::exists(assets / (std::string(200, 'a') + "_.glb")));
}

TEST_F(BakeRobot, GoesThroughPipesIntoAFolder) {
  folder.write("robot.urdf", robot(link("a", collision("model.obj"))));
  const std::string bake =
      std::string(ENCAGE_BINARY) + " bake - --format urdf --method collapse --faces 12 < robot.urdf";
  EXPECT_EQ(run({"/bin/sh", "-c", bake + " -o out/ --json"}, folder.path()).status, 0);
  EXPECT_TRUE(fs::exists(folder.path() / "out" / "a.glb"));
  EXPECT_EQ(run({"/bin/sh", "-c", bake}, folder.path()).status, 2);
}

TEST_F(BakeRobot, BadDescriptionsAreRefused) {
  const auto refused = [&](const std::string& text, const std::string& reason) {
    folder.write("robot.urdf", text);
    expect_refused({"bake", "robot.urdf", "--method", "collapse", "--faces", "12", "--json", "a.json"},
                   "robot.urdf: " + reason);
  };
  folder.write("open.obj", "v 0 0 0\n");
  refused("", "XML, byte 0");
  refused("<robot><link", "XML, byte ");
  refused("<sdf/>", "no robot description: the root element is 'sdf', not 'robot'");
  refused(robot(""), "the robot has no links");
  refused(robot("<link/>"), "a link has no name");
  refused(robot(link("a", "") + link("a", "")), "link 'a': a second one of that name");
  refused(robot(link("a", "")), "no link has a collision mesh");
  refused(robot(link("a", collision(""))), "link 'a': a collision mesh has no filename");
  refused(robot(link("a", collision("lost.obj"))), "link 'a': mesh 'lost.obj' is not there: looked for ./lost.obj");
  refused(robot(link("a", collision("package://lost/a.obj"))),
          "link 'a': mesh 'package://lost/a.obj' is not there: no "
          "folder from ");
  refused(robot(link("a", collision("package:///a.obj"))), "link 'a': 'package:///a.obj' names no package");
  refused(robot(link("a", collision("http://x/a.obj"))), "link 'a': 'http://x/a.obj': only file names");
  refused(robot(link("a", collision("open.obj"))), "link 'a': ./open.obj: no faces (1 vertices)");
  for (const char* scale : {"1 1", "1 1 0", "1 1 1 1", "1,1,1", "nan 1 1", "x"}) {
    refused(robot(link("a", scaled("model.obj", scale))), std::string("link 'a': scale '") + scale + "' is not three");
  }
  refused(robot(link("a", collision("model.obj", "<origin xyz=\"1 2\"/>"))),
          "link 'a': xyz '1 2' is not three numbers");
  refused(robot("<xacro:include filename=\"b\"/>"), "'xacro:include': xacro has to be expanded first");
  // Names that no file can have.
  const std::string endless(300, 'a');
  refused(robot(link("a", collision(endless))), "link 'a': mesh '" + endless + "' is not there");
  refused(robot(link("a", collision("package://" + endless + "/a.obj"))),
          "link 'a': mesh 'package://" + endless + "/a.obj' is not there");

  folder.write("robot.urdf", robot(link("a", collision("model.obj"))));
  expect_refused({"bake", "robot.urdf", "-o", "model.obj"}, "model.obj: is no folder");
  expect_refused({"bake", "robot.urdf", "-o", "no/where"}, "no/where: no such folder");
  expect_refused({"bake", "robot.urdf", "-o", endless}, endless + ": cannot write: File name too long");
  expect_refused({"bake", "robot.urdf", "-o", "-"}, "go into a folder");
  expect_refused({"bake", "robot.urdf", "--coarse", "model.obj"}, "--coarse");
  fs::create_directory(folder.path() / "robot");
  folder.write("robot/a.glb", "somebody's");
  expect_refused({"bake", "robot.urdf", "--method", "collapse", "--faces", "12"},
                 "robot/a.glb: exists and holds no cages");
}

TEST(Urdf, IsReadOrTheMessageSaysWhatIsMissing) {
  std::string message;
  try {
    tool::read_urdf("robot.urdf", "<robot/>");
  } catch (const Error& error) {
    message = error.what();
  }
  EXPECT_NE(message.find(tool::has_urdf() ? "the robot has no links" : "libpugixml-dev"), std::string::npos) << message;
}

}  // namespace
}  // namespace encage::test

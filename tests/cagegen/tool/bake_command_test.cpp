// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/meshes.h"
#include "tests/cagegen/io/gltf_asset.h"
#include "tests/cagegen/tool/command_fixture.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <nlohmann/json.hpp>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace encage::test {
namespace {

using Json = nlohmann::json;

class BakeCommand : public CommandTest {};

TEST_F(BakeCommand, AloneWritesIntoTheCurrentFolder) {
  const RunResult result = encage({"bake", "model.obj"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(folder.names(), (std::vector<std::string>{"model.glb", "model.obj"}));
  const CageHierarchy hierarchy = read_asset(folder.path() / "model.glb", Verify::all);
  ASSERT_FALSE(hierarchy.levels.empty());
  EXPECT_LT(hierarchy.levels[0].mesh.triangles.rows(), 576);
  EXPECT_EQ(hierarchy.fine.triangles.rows(), 576);
  EXPECT_NE(result.out.find("level 1:"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("wrote model.glb"), std::string::npos) << result.out;
}

TEST_F(BakeCommand, AGlbInputIsNotOverwritten) {
  bake_model();
  const std::string before = folder.read("model.glb");
  const RunResult result = encage({"bake", "model.glb", "--method", "collapse", "--faces", "20"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(folder.read("model.glb"), before);
  EXPECT_EQ(folder.names(), (std::vector<std::string>{"model.cages.glb", "model.glb", "model.obj"}));
  expect_refused({"bake", "model.glb", "-o", "./model.glb"}, "input");
}

TEST_F(BakeCommand, AnAssetStandsForItsSource) {
  // Open at one end, and far from 0, so that the asset has caps and an origin.
  TriangleMesh open = torus(24, 12);
  open.vertices.col(0).array() += 4096;
  open.triangles.conservativeResize(open.triangles.rows() - 48, 3);
  folder.write("open.obj", to_obj(open));
  write_rings(4096);
  ASSERT_EQ(encage({"bake", "open.obj", "--coarse", "fine.off,coarse.off"}).status, 0);
  const CageHierarchy first = read_asset(folder.path() / "open.glb", Verify::all);
  ASSERT_GT(first.cap_count, 0);
  ASSERT_NE(first.origin.x(), 0);

  const RunResult result = encage({"bake", "open.glb", "-o", "again.glb", "--coarse", "fine.off"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_NE(result.err.find("note: open.glb: an asset of Encage: its source is read, as stored in float32; its 2 cages "
                            "are left out\n"),
            std::string::npos)
      << result.err;
  EXPECT_NE(result.out.find("open.glb: 528 triangles"), std::string::npos) << result.out;
  const CageHierarchy again = read_asset(folder.path() / "again.glb", Verify::all);
  EXPECT_EQ(again.fine.triangles.topRows(528), first.fine.triangles.topRows(528));
  EXPECT_EQ(again.cap_count, first.cap_count);
  EXPECT_EQ(again.fine_error, 0);
  EXPECT_NEAR(again.source_volume, first.source_volume, 1e-6);
  EXPECT_GT(again.levels[0].certificate.volume_ratio, 1);
  EXPECT_EQ(encage({"check", "again.glb", "--source", "open.glb"}).status, 0);
}

TEST_F(BakeCommand, AnAssetWithoutItsSourceIsRefused) {
  write_rings();
  ASSERT_EQ(encage({"bake", "model.obj", "--coarse", "fine.off", "--no-source"}).status, 0);
  expect_refused({"bake", "model.glb", "-o", "a.glb"},
                 "model.glb: an asset of Encage that holds cages without their source");
  std::string bytes = folder.read("model.glb");
  bytes.back() = static_cast<char>(bytes.back() ^ 1);
  folder.write("damaged.glb", bytes);
  expect_refused({"bake", "damaged.glb", "-o", "a.glb"}, "encage: damaged.glb");
}

TEST_F(BakeCommand, AForeignFileIsReplacedOnlyOnRequest) {
  write_rings();
  folder.write("model.glb", "somebody's other model");
  expect_refused({"bake", "model.obj", "--coarse", "fine.off"}, "model.glb");
  EXPECT_EQ(folder.read("model.glb"), "somebody's other model");
  EXPECT_EQ(encage({"bake", "model.obj", "--coarse", "fine.off", "-o", "model.glb"}).status, 0);
  // What is ours is replaced without asking.
  EXPECT_EQ(encage({"bake", "model.obj", "--coarse", "coarse.off"}).status, 0);
}

TEST_F(BakeCommand, JsonHasTheKeysThatOtherToolsReadAndAgreesWithTheAsset) {
  const RunResult result = encage({"bake", "model.obj", "-o", "a.glb", "--faces", "200,60", "--json", "a.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const Json json = Json::parse(folder.read("a.json"));
  const CageHierarchy hierarchy = read_asset(folder.path() / "a.glb");
  ASSERT_EQ(json.at("levels").size(), hierarchy.levels.size());
  ASSERT_EQ(hierarchy.levels.size(), 2U);
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    const Json& level = json["levels"][i];
    const Certificate& certificate = hierarchy.levels[i].certificate;
    EXPECT_EQ(level.at("faces"), hierarchy.levels[i].mesh.triangles.rows());
    EXPECT_EQ(level.at("volume_ratio"), certificate.volume_ratio.value());
    EXPECT_GT(level.at("volume_ratio"), 1);
    EXPECT_EQ(level.at("max_distance"), certificate.max_distance.value());
    EXPECT_EQ(level.at("mean_distance"), certificate.mean_distance.value());
    EXPECT_EQ(level.at("clearance"), certificate.clearance);
    EXPECT_EQ(level.at("method"), name(certificate.method));
    EXPECT_EQ(level.at("certified"), true);
    EXPECT_GE(level.at("seconds"), 0);
  }
  EXPECT_LE(json["levels"][0]["faces"], 200);
  EXPECT_LE(json["levels"][1]["faces"], 60);
  EXPECT_GT(json.at("seconds"), 0);
  EXPECT_GT(json.at("peak_rss_bytes"), 1 << 20);
  EXPECT_EQ(json.at("source").at("faces"), 576);
  EXPECT_EQ(json.at("source").at("hash"), to_string(hierarchy.source_hash));
}

/// What is kept of the levels of 100 faces and more, all certified, and what is said of the others.
class BakePartial : public CommandTest {
 protected:
  Json partial(std::vector<std::string> options, std::size_t levels, const std::string& said) {
    std::vector<std::string> command = {"bake", "model.obj", "--method", "collapse", "--json", "a.json"};
    command.insert(command.end(), options.begin(), options.end());
    const RunResult result = encage(command);
    EXPECT_EQ(result.status, 1) << result.err;
    EXPECT_NE(result.err.find("note: "), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("encage: model.obj: " + said), std::string::npos) << result.err;
    EXPECT_EQ(encage({"check", "model.glb", "--source", "model.obj"}).status, 0);
    Json json = Json::parse(folder.read("a.json"));
    EXPECT_EQ(json.at("levels").size(), levels);
    EXPECT_EQ(json.at("failure").get<std::string>().find(said), 0U) << json.at("failure");
    return json;
  }

  /// Nothing can be kept: status 1 all the same, and nothing is written.
  void nothing(std::vector<std::string> options, const std::string& said) {
    std::vector<std::string> command = {"bake", "model.obj", "--method", "collapse", "--keep-partial"};
    command.insert(command.end(), options.begin(), options.end());
    const std::vector<std::string> before = folder.names();
    const RunResult result = encage(command);
    EXPECT_EQ(result.status, 1) << result.err;
    EXPECT_NE(result.err.find("encage: model.obj: " + said), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("nothing was written"), std::string::npos) << result.err;
    EXPECT_EQ(folder.names(), before);
    command.erase(command.begin() + 4);
    expect_refused(command, "encage: model.obj: " + said);
  }
};

TEST_F(BakePartial, ATopologyThatCannotBeKept) {
  const Json json = partial({"--keep-partial", "--topology", "keep", "--faces", "100,8,6"}, 1, "level 2 (8 faces): ");
  EXPECT_EQ(json.at("missing_levels"), Json({8, 6}));
  EXPECT_EQ(json.at("truncated"), false);
  std::filesystem::remove(folder.path() / "model.glb");
  std::filesystem::remove(folder.path() / "a.json");
  nothing({"--topology", "keep", "--faces", "8"}, "level 1 (8 faces): ");
}

TEST_F(BakePartial, TooFewFacesForSeveralComponents) {
  folder.write("model.obj", to_obj(shapes::joined(torus(12, 8), shapes::moved(torus(12, 8), {9, 0, 0}))));
  const Json json = partial({"--keep-partial", "--topology", "keep", "--faces", "120,12"}, 1, "level 2 (12 faces): ");
  EXPECT_EQ(json.at("missing_levels"), Json({12}));
  EXPECT_EQ(json["levels"][0].at("components"), 2);
}

TEST_F(BakePartial, MoreLevelsThanPossible) {
  const Json json = partial({"--keep-partial", "--ratio", "0.1", "--levels", "9"}, 2, "only 2 of 9 levels: ");
  EXPECT_EQ(json.at("missing_levels"), Json::array());
  // Without --keep-partial, skipped levels are notes.
  EXPECT_EQ(encage({"bake", "model.obj", "--ratio", "0.1", "--levels", "9", "--method", "collapse"}).status, 0);
}

TEST_F(BakePartial, LevelsThatATimeLimitLeavesOut) {
  const Json json =
      partial({"--faces", "200,60,20", "--time-limit", "1e-9"}, 1, "the time limit leaves out levels of 60, 20 faces");
  EXPECT_EQ(json.at("missing_levels"), Json({60, 20}));
  EXPECT_EQ(json.at("truncated"), true);
  // A limit that leaves nothing out.
  write_rings();
  EXPECT_EQ(encage({"bake", "model.obj", "--coarse", "fine.off", "--time-limit", "1e9", "--json", "a.json"}).status, 0);
  EXPECT_EQ(Json::parse(folder.read("a.json")).at("missing_levels"), Json::array());
}

TEST_F(BakeCommand, RatioAndLevelsChooseTheFaces) {
  ASSERT_EQ(encage({"bake", "model.obj", "--ratio", "0.5", "--levels", "3"}).status, 0);
  const CageHierarchy hierarchy = read_asset(folder.path() / "model.glb");
  ASSERT_EQ(hierarchy.levels.size(), 3U);
  for (std::int64_t i = 0, most = 288; i < 3; ++i, most /= 2) {
    EXPECT_LE(hierarchy.levels[i].mesh.triangles.rows(), most);
    EXPECT_GT(hierarchy.levels[i].mesh.triangles.rows(), most / 2);
  }
}

TEST_F(BakeCommand, NoSourceLeavesLevelZeroOut) {
  write_rings();
  ASSERT_EQ(encage({"bake", "model.obj", "--coarse", "fine.off", "--no-source"}).status, 0);
  EXPECT_EQ(read_asset(folder.path() / "model.glb").fine.triangles.rows(), 0);
}

TEST_F(BakeCommand, SameBytesForAnyNumberOfThreads) {
  ASSERT_EQ(encage({"bake", "model.obj", "-o", "one.glb", "--faces", "200,60", "--threads", "1"}).status, 0);
  ASSERT_EQ(encage({"bake", "model.obj", "-o", "two.glb", "--faces", "200,60", "--threads", "2"}).status, 0);
  EXPECT_EQ(folder.read("one.glb"), folder.read("two.glb"));
}

TEST_F(BakeCommand, BadInputIsNamed) {
  folder.write("nan.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 1\nv 0 1 0\nf 1 2 3\nf 1 2 4\n");
  folder.write("infinite.off", "OFF\n3 1 0\n0 0 0\n1 0 inf\n0 1 0\n3 0 1 2\n");
  folder.write("range.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n");
  folder.write("empty.obj", "");
  folder.write("points.off", "OFF\n2 0 0\n0 0 0\n1 1 1\n");
  folder.write("point.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n");
  folder.write("model.xyz", "0 0 0\n");
  for (const char* file : {"nan.obj", "infinite.off", "range.off", "empty.obj", "points.off", "point.obj", "model.xyz",
                           "missing.obj", "."}) {
    expect_refused({"bake", file, "-o", "out.glb", "--json", "out.json"}, std::string("encage: ") + file);
  }
}

TEST_F(BakeCommand, WhatTheReaderSkippedIsNoted) {
  folder.write("lines.obj", to_obj(torus(24, 12)) + "l 1 2\n");
  write_rings();
  const RunResult result = encage({"bake", "lines.obj", "--coarse", "fine.off"});
  EXPECT_EQ(result.status, 0);
  EXPECT_NE(result.err.find("note: lines.obj: skipped: 1 line element\n"), std::string::npos) << result.err;
}

/// A torus as glTF.
GltfAsset gltf_torus() {
  const TriangleMesh mesh = torus(24, 12);
  const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> points = mesh.vertices.cast<float>();
  const Eigen::Matrix<std::uint16_t, Eigen::Dynamic, 3, Eigen::RowMajor> indices = mesh.triangles.cast<std::uint16_t>();
  return GltfAsset::mesh({points.data(), points.data() + points.size()},
                         {indices.data(), indices.data() + indices.size()});
}

TEST_F(BakeCommand, NotesOfEveryReaderReachTheUser) {
  GltfAsset gltf = gltf_torus();
  gltf.json["scenes"].push_back({{"nodes", {0}}});
  gltf.json["animations"] = Json::array({Json::object()});
  folder.write("a.gltf", gltf.text());
  folder.write("a.glb", gltf.binary());
  for (const char* const format : {"off", "ply", "stl"}) {
    write_mesh(folder.path() / (std::string("a.") + format), torus(24, 12));
  }
  folder.write("a.off", folder.read("a.off") + "3 0 1 2\n");
  std::string ply = folder.read("a.ply");
  const std::string list = "element hole 1\nproperty list uchar int vertex_indices\n";
  folder.write("a.ply", ply.insert(ply.find("end_header"), list) + '\0');
  folder.write("a.stl", folder.read("a.stl") + "behind");
  folder.write("a.obj", "\xEF\xBB\xBF" + folder.read("model.obj"));
  write_rings();
  const std::string skipped = "skipped: 1 other scene", pose = "only the default pose is read: 1 animation";
  const std::vector<std::pair<std::string, std::vector<std::string>>> cases = {
      {"a.gltf", {skipped, pose}},
      {"a.glb", {skipped, pose}},
      {"a.off", {"skipped: the file goes on, at line "}},
      {"a.ply", {"skipped: 1 of element 'hole', which are no faces"}},
      {"a.stl", {"skipped: 6 bytes behind the last of the 576 triangles that the header promises"}},
      {"a.obj", {"a byte order mark was skipped"}}};
  for (const auto& [file, notes] : cases) {
    const RunResult result = encage({"bake", file, "-o", "out.glb", "--coarse", "fine.off", "--json"});
    EXPECT_EQ(result.status, 0) << file << result.err;
    for (const std::string& note : notes) {
      EXPECT_NE(result.err.find("note: " + file + ": " + note), std::string::npos) << result.err;
    }
    // What others read is the JSON alone.
    EXPECT_TRUE(Json::accept(result.out)) << file << result.out;
    EXPECT_EQ(result.out.find("note"), std::string::npos) << file;
    const RunResult checked = encage({"check", "out.glb", "--source", file});
    EXPECT_EQ(checked.status, 0) << file << checked.out << checked.err;
    EXPECT_NE(checked.err.find(file + ": " + notes[0]), std::string::npos) << checked.err;
  }
}

TEST_F(BakeCommand, RefusalsOfGltfNameTheElement) {
  const auto refused = [&](const GltfAsset& asset, const std::string& reason) {
    folder.write("a.gltf", asset.text());
    expect_refused({"bake", "a.gltf", "-o", "out.glb"}, "encage: a.gltf: " + reason);
    folder.write("a.glb", asset.binary());
    expect_refused({"bake", "a.glb", "-o", "out.glb"}, "encage: a.glb: " + reason);
  };
  GltfAsset asset = gltf_torus();
  asset.require("EXT_of_tomorrow");
  refused(asset, "the file requires the extension EXT_of_tomorrow, which Encage does not know");
  asset = gltf_torus();
  asset.json["accessors"][0]["count"] = 1000;
  refused(asset, "mesh 0, primitive 0.attributes.POSITION: accessor 0 reaches beyond buffer view 0");
  asset = gltf_torus();
  asset.primitive()["mode"] = 1;
  refused(asset, "no triangles in the scene (skipped: 1 primitive of lines)");
  asset = gltf_torus();
  asset.json["asset"]["version"] = "1.0";
  refused(asset, "glTF 1.0 is not supported");
}

/// Of a tree of leaf cards, thousands of which are open and half of which face inward.
TEST_F(BakeCommand, NotesAreFewAndInTheUsersWords) {
  TriangleMesh tree = torus(24, 12);
  tree.triangles.col(1).swap(tree.triangles.col(2));
  std::string text = to_obj(tree);
  for (int leaf = 0; leaf < 40; ++leaf) {
    const std::string x = std::to_string(2 + leaf);
    text += "v " + x + " 0 0\nv " + x + ".5 0 0\nv " + x + ".5 .5 .1\nv " + x + " .5 0\nf -4 -3 -2\nf -4 -2 -1\n";
  }
  text += "f 1 2 2\nf 1 2 1\nv 9 9 9\n";
  folder.write("tree.obj", text);
  const RunResult result = encage({"bake", "tree.obj", "--method", "flow", "--faces", "100"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_TRUE(
      result.out.starts_with("tree.obj: 658 triangles, open in 40 places, which are capped; parts that faced "
                             "inward are turned; 2 faces without area or twice there\n"))
      << result.out;
  EXPECT_EQ(result.err.find("note:"), std::string::npos) << result.err;
  const RunResult verbose = encage({"bake", "tree.obj", "--method", "flow", "--faces", "100", "--verbose"});
  EXPECT_NE(verbose.err.find("note: coarse mesh '"), std::string::npos) << verbose.err;

  folder.write("sheet.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  EXPECT_TRUE(encage({"bake", "sheet.obj", "--faces", "12"})
                  .out.starts_with("sheet.obj: 2 triangles, encloses no volume: the cages enclose its surface\n"));
}

TEST_F(BakeCommand, AnExistingOutputSurvivesAFailure) {
  folder.write("out.glb", "precious");
  folder.write("nan.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 1\nf 1 2 3\n");
  expect_refused({"bake", "nan.obj", "-o", "out.glb"}, "nan.obj");
  EXPECT_EQ(folder.read("out.glb"), "precious");
}

TEST_F(BakeCommand, OutputsAreCheckedFirst) {
  // With an input that does not exist: the output's fault is found before anything is read.
  expect_refused({"bake", "missing.obj", "-o", "nowhere/out.glb"}, "nowhere/out.glb: no such folder");
  expect_refused({"bake", "missing.obj", "-o", "out.glb", "--json", "nowhere/a.json"}, "nowhere/a.json");
  expect_refused({"bake", "missing.obj", "-o", "out.obj"}, "out.obj");
  std::filesystem::create_directory(folder.path() / "folder.glb");
  expect_refused({"bake", "missing.obj", "-o", "folder.glb"}, "folder.glb: is a folder");
  expect_refused({"bake", "model.obj", "--json", "model.obj"}, "input");
  // Names that no file can have.
  const std::string endless(300, 'a');
  expect_refused({"bake", "model.obj", "-o", endless + ".glb"}, endless + ".glb: cannot write: File name too long");
  expect_refused({"bake", endless + ".obj"}, ": File name too long");
  expect_refused({"bake", endless + ".obj", "-o", "out.glb"}, endless + ".obj: cannot open: File name too long");
}

TEST_F(BakeCommand, BadOptionsAreNamed) {
  const std::vector<std::vector<std::string>> bad = {
      {"--faces", "0"},          {"--faces", "3"},           {"--faces", "many"},
      {"--faces", "100,-5"},     {"--ratio", "0"},           {"--ratio", "1"},
      {"--ratio", "nan"},        {"--ratio", "x"},           {"--levels", "0"},
      {"--levels", "1.5"},       {"--method", "magic"},      {"--topology", "flat"},
      {"--min-clearance", "-1"}, {"--min-clearance", "nan"}, {"--threads", "-1"},
      {"--time-limit", "0"},     {"--time-limit", "inf"},    {"--ratio", "0.5", "--faces", "100"}};
  for (std::vector<std::string> options : bad) {
    const std::string named = options[0];
    options.insert(options.begin(), {"bake", "model.obj"});
    expect_refused(options, named);
  }
  expect_refused({"bake"}, "input is required");
}

TEST_F(BakeCommand, CtrlCLeavesNothingBehind) {
  folder.write("large.obj", to_obj(torus(600, 200)));
  folder.write("out.glb", "precious");
  const std::vector<std::string> before = folder.names();
  Process bake({ENCAGE_BINARY, "bake", "large.obj", "-o", "out.glb", "--json", "out.json", "--faces", "2000,500,100"},
               folder.path());
  using namespace std::chrono_literals;
  while (bake.running() && !bake.catches(SIGINT)) std::this_thread::sleep_for(1ms);
  std::this_thread::sleep_for(300ms);
  ASSERT_TRUE(bake.running());
  bake.signal(SIGINT);
  const RunResult result = bake.wait();
  EXPECT_EQ(result.status, 130) << result.out << result.err;
  EXPECT_NE(result.err.find("cancelled"), std::string::npos) << result.err;
  EXPECT_EQ(folder.names(), before);
  EXPECT_EQ(folder.read("out.glb"), "precious");
}

}  // namespace
}  // namespace encage::test

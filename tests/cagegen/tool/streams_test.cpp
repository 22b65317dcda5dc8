// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cagegen/tool/command_fixture.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <filesystem>
#include <string>
#include <thread>
#include <vector>

// Results that go elsewhere than into regular files, and inputs that come from elsewhere.

namespace encage::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class Streams : public CommandTest {
 protected:
  Streams() { folder.write("poses.csv", "step,body,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,0,1\n0,1,5,0,0,0,0,0,1\n"); }

  void SetUp() override {
    bake_model();
    write_rings();
  }

  /// A line of the shell; $ENCAGE is the program.
  RunResult shell(const std::string& line) {
    return run({"/bin/sh", "-c", "ENCAGE='" + std::string(ENCAGE_BINARY) + "'; " + line}, folder.path());
  }
};

const std::vector<std::string> every_command = {"bake model.obj --coarse fine.off -o new.glb",
                                                "check model.glb",
                                                "info model.glb",
                                                "export model.glb --level 1 -o cage.obj",
                                                "render model.glb -o model.png --size 64x48",
                                                "query model.glb --poses poses.csv"};

TEST_F(Streams, JsonMeansTheSameInEveryCommand) {
  for (const std::string& command : every_command) {
    const RunResult text = shell("$ENCAGE " + command);
    EXPECT_EQ(text.status, 0) << command << text.err;
    EXPECT_FALSE(Json::accept(text.out)) << command;
    // To a file: beside the text.
    const RunResult beside = shell("$ENCAGE " + command + " --json figures.json");
    EXPECT_EQ(beside.status, 0) << command << beside.err;
    EXPECT_FALSE(Json::accept(beside.out)) << command;
    EXPECT_NE(beside.out, "") << command;
    const Json figures = Json::parse(folder.read("figures.json"));
    EXPECT_TRUE(figures.is_object()) << command;
    // To standard output: instead of the text.
    for (const char* option : {" --json", " --json -", " --json /dev/stdout"}) {
      const RunResult instead = shell("$ENCAGE " + command + option);
      EXPECT_EQ(instead.status, 0) << command << instead.err;
      ASSERT_TRUE(Json::accept(instead.out)) << command << option << instead.out;
      for (const auto& [key, value] : figures.items()) EXPECT_TRUE(Json::parse(instead.out).contains(key)) << key;
    }
  }
  // The file's name goes to the positional argument first.
  EXPECT_TRUE(Json::accept(shell("$ENCAGE info --json model.glb").out));
}

TEST_F(Streams, AFullDeviceIsNoticedByEveryCommand) {
  std::vector<std::string> lines = {"--help", "--version", "bake --help"};
  for (const std::string& command : every_command) {
    lines.push_back(command);
    lines.push_back(command + " --json");
  }
  lines.emplace_back("bake model.obj --coarse fine.off -o -");
  lines.emplace_back("export model.glb --level 1 --format obj -o -");
  lines.emplace_back("render model.glb --size 64x48 -o -");
  for (const std::string& line : lines) {
    const RunResult result = shell("$ENCAGE " + line + " > /dev/full");
    EXPECT_EQ(result.status, 2) << line;
    EXPECT_NE(result.err.find("cannot write"), std::string::npos) << line << ": " << result.err;
  }
}

TEST_F(Streams, MeshesAndAssetsGoThroughPipes) {
  const RunResult bake = shell("$ENCAGE bake - --format obj --coarse fine.off,coarse.off -o - < model.obj > piped.glb");
  EXPECT_EQ(bake.status, 0) << bake.err;
  EXPECT_EQ(folder.read("piped.glb"), folder.read("model.glb"));
  EXPECT_NE(bake.err.find("standard input: 576 triangles"), std::string::npos) << bake.err;

  EXPECT_EQ(shell("cat model.glb | $ENCAGE info -").out, encage({"info", "model.glb"}).out);
  EXPECT_EQ(shell("cat model.glb | $ENCAGE check - --source model.obj").out,
            encage({"check", "model.glb", "--source", "model.obj"}).out);
  EXPECT_EQ(shell("cat model.obj | $ENCAGE check model.glb --source - --format obj").status, 0);
  ASSERT_EQ(encage({"export", "model.glb", "--level", "2", "-o", "cage.ply"}).status, 0);
  EXPECT_EQ(shell("cat model.glb | $ENCAGE export - --level 2 --format ply -o -").out, folder.read("cage.ply"));
  ASSERT_EQ(encage({"render", "model.glb", "-o", "a.png", "--size", "64x48"}).status, 0);
  EXPECT_EQ(shell("cat model.glb | $ENCAGE render - --size 64x48 -o -").out, folder.read("a.png"));
  EXPECT_TRUE(shell("cat model.obj | $ENCAGE render - --format obj --size 64x48 -o -").out.starts_with("\x89PNG"));
  EXPECT_EQ(shell("cat poses.csv | $ENCAGE query model.glb --poses - --per-step").out,
            encage({"query", "model.glb", "--poses", "poses.csv", "--per-step"}).out);
}

TEST_F(Streams, NamedPipesAreReadOnce) {
  ASSERT_EQ(mkfifo((folder.path() / "pipe.obj").c_str(), 0600), 0);
  ASSERT_EQ(mkfifo((folder.path() / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(
      shell("cat model.obj > pipe.obj & $ENCAGE bake pipe.obj --coarse fine.off,coarse.off -o piped.glb; wait").status,
      0);
  EXPECT_EQ(folder.read("piped.glb"), folder.read("model.glb"));
  EXPECT_EQ(shell("cat model.glb > pipe & $ENCAGE info pipe; wait").out, encage({"info", "model.glb"}).out);
}

TEST_F(Streams, AFormatGoesBeforeTheExtension) {
  folder.write("mesh.txt", folder.read("model.obj"));
  EXPECT_EQ(encage({"bake", "mesh.txt", "--format", "obj", "--coarse", "fine.off"}).status, 0);
  expect_refused({"bake", "mesh.txt"}, "mesh.txt: unknown format 'txt'");
  expect_refused({"bake", "model.obj", "--format", "off", "-o", "a.glb"}, "model.obj: line 1: not an OFF file");
  expect_refused({"bake", "model.obj", "--format", "xyz", "-o", "a.glb"}, "unknown format 'xyz'");
  EXPECT_EQ(encage({"export", "model.glb", "--level", "1", "-o", "cage.mesh", "--format", "off"}).status, 0);
  EXPECT_TRUE(folder.read("cage.mesh").starts_with("OFF\n"));
}

TEST_F(Streams, WhatHasNoNameNeedsOne) {
  expect_refused({"bake", "-", "--format", "obj"}, "choose it with -o");
  expect_refused({"bake", "-", "-o", "a.glb"}, "standard input: has no extension that tells the format");
  expect_refused({"export", "model.glb", "--level", "1", "-o", "-"}, "--format");
  expect_refused({"export", "model.glb", "--level", "1", "-o", "-", "--format", "obj", "--json", "-"}, "same file");
  expect_refused({"bake", "model.obj", "-o", "-", "--json"}, "same file");
  expect_refused({"bake", "model.obj", "-o", "a.glb", "--json", "./a.glb"}, "same file");
}

TEST_F(Streams, PipesAndDevicesAreWrittenThroughAndLinksStay) {
  const fs::path pipe = folder.path() / "pipe", device = folder.path() / "null";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  // As root, a wrong program would replace the system's device: this one is the test's own.
  const bool has_device = mknod(device.c_str(), S_IFCHR | 0600, makedev(1, 3)) == 0;
  folder.write("target", "old");
  fs::create_symlink("target", folder.path() / "link.json");
  fs::create_symlink("target.glb", folder.path() / "link.glb");

  const std::string bake = "$ENCAGE bake model.obj --coarse fine.off,coarse.off ";
  EXPECT_EQ(shell("cat pipe > read & " + bake + "-o a.glb --json pipe; wait").status, 0);
  EXPECT_TRUE(Json::accept(folder.read("read")));
  EXPECT_EQ(shell("cat pipe > read.glb & " + bake + "-o pipe; wait").status, 0);
  EXPECT_EQ(folder.read("read.glb"), folder.read("model.glb"));
  EXPECT_EQ(shell("cat pipe > read & $ENCAGE export model.glb --level 1 --format off -o pipe; wait").status, 0);
  EXPECT_TRUE(folder.read("read").starts_with("OFF\n"));
  EXPECT_TRUE(fs::is_fifo(pipe));
  if (has_device) {
    EXPECT_EQ(shell(bake + "-o a.glb --json null").status, 0);
    EXPECT_EQ(shell(bake + "-o null").status, 0);
    EXPECT_EQ(shell("$ENCAGE render model.glb --size 64x48 -o null").status, 0);
    EXPECT_TRUE(fs::is_character_file(device));
  }

  EXPECT_EQ(shell(bake + "-o link.glb --json link.json").status, 0);
  EXPECT_TRUE(fs::is_symlink(folder.path() / "link.json") && fs::is_symlink(folder.path() / "link.glb"));
  EXPECT_TRUE(Json::accept(folder.read("target")));
  EXPECT_EQ(folder.read("target.glb"), folder.read("model.glb"));
  // A link to the input is the input.
  fs::create_symlink("model.obj", folder.path() / "input.glb");
  expect_refused({"bake", "model.obj", "-o", "input.glb"}, "would overwrite the input");
}

/// Text and JSON that go to one file through its descriptor stand there one after the other.
TEST_F(Streams, StandardOutputGoesOnWhereItIs) {
  ASSERT_EQ(shell("$ENCAGE info model.glb --json > json.txt").status, 0);
  EXPECT_EQ(shell("{ echo before; $ENCAGE info model.glb --json -; echo after; } > all.txt").status, 0);
  EXPECT_EQ(folder.read("all.txt"), "before\n" + folder.read("json.txt") + "after\n");
}

TEST_F(Streams, PicturesAreOfOneFormat) {
  for (const char* name : {"a.jpg", "a.jpeg", "a", "a.pn", "a.png.bmp"}) {
    expect_refused({"render", "model.glb", "-o", name}, std::string(name) + ": pictures are written as .png only");
  }
}

}  // namespace
}  // namespace encage::test

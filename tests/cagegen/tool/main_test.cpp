// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cagegen/tool/command_fixture.h"

#include <encage/version.h>

#include <string>

namespace encage::test {
namespace {

const std::vector<std::string> commands = {"bake", "check", "info", "export", "render", "query"};

TEST_F(CommandTest, HelpNamesEveryCommand) {
  const RunResult result = encage({"--help"});
  EXPECT_EQ(result.status, 0);
  for (const std::string& command : commands) EXPECT_NE(result.out.find("  " + command + " "), std::string::npos);
}

TEST_F(CommandTest, HelpOfEveryCommandHasExamples) {
  for (const std::string& command : commands) {
    const RunResult result = encage({command, "--help"});
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.out.find("encage " + command + " "), std::string::npos) << result.out;
  }
}

TEST_F(CommandTest, PrintsItsVersion) {
  const RunResult result = encage({"--version"});
  EXPECT_EQ(result.status, 0);
  const Version v = version();
  EXPECT_EQ(result.out,
            "encage " + std::to_string(v.major) + "." + std::to_string(v.minor) + "." + std::to_string(v.patch) + "\n");
}

TEST_F(CommandTest, WrongUsageIsRefused) {
  expect_refused({}, "which command?");
  expect_refused({"melt", "model.obj"}, "melt");
  for (const char* command : {"bake", "check", "info"}) {
    expect_refused({command, "model.obj", "--frobnicate"}, "--frobnicate");
  }
}

TEST_F(CommandTest, BadInputOfQueryIsNamed) {
  bake_model();
  folder.write("short.csv", "step,body,x,y,z,qx,qy,qz,qw\n0,0,0,0\n");
  folder.write("poses.csv", "step,body,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,0,1\n");
  expect_refused({"query", "missing.glb", "--poses", "poses.csv"}, "encage: missing.glb");
  expect_refused({"query", "model.glb", "--poses", "missing.csv"}, "encage: missing.csv");
  expect_refused({"query", "model.glb", "--poses", "short.csv"}, "encage: short.csv");
  expect_refused({"query", "model.glb"}, "--poses is required");
}

TEST_F(CommandTest, ResultsThatCannotBePrintedAreAnError) {
  bake_model();
  const RunResult result =
      run({"/bin/sh", "-c", std::string(ENCAGE_BINARY) + " info model.glb > /dev/full"}, folder.path());
  EXPECT_EQ(result.status, 2);
  EXPECT_NE(result.err.find("standard output"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace encage::test

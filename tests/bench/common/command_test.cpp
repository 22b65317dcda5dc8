// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/command.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <streambuf>
#include <string>
#include <vector>

namespace encage::bench {
namespace {

struct TestArguments {
  std::filesystem::path asset, poses, json;
  std::vector<std::filesystem::path> files;
  std::int64_t every = 1;
  int runs = 3;
  double speed = 0.5;
  std::string scene = "gas";
  std::vector<std::string> engines = {"fcl"};
  std::vector<int> threads = {1, 2};
  bool cages = false;
};

/// A command that writes to arguments outside, and how it ended.
class CommandLine : public testing::Test {
 protected:
  Command command(std::string name = "bench") {
    const auto define = [this](CommandOptions& options) {
      options.add("files", a.files, "Files");
      options.asset(a.asset);
      options.every(a.every);
      options.runs(a.runs, "Runs");
      options.json(a.json);
      options.add("--speed", a.speed, "Speed").within(0, 10).environment("ENCAGE_TEST_SPEED");
      auto scene = options.add("--scene", a.scene, "Scene").one_of({"gas", "pile"});
      options.add("--engines", a.engines, "Engines").one_of({"fcl", "ode", "bullet"});
      options.add("--threads", a.threads, "Threads").between(1, 8).excludes(scene);
      options.flag("--cages", a.cages, "Cages").needs(scene);
    };
    return {name, "A test", "", define, [this, name] {
              ran = name;
              if (fails) throw Error("a.csv: no poses");
              return answer;
            }};
  }

  static std::vector<char*> pointers(std::vector<std::string>& words) {
    std::vector<char*> all;
    for (std::string& word : words) all.push_back(word.data());
    return all;
  }

  int run(std::vector<std::string> words) {
    words.emplace(words.begin(), "bench");
    std::vector<char*> argv = pointers(words);
    return run_command(command(), static_cast<int>(argv.size()), argv.data());
  }

  TestArguments a;
  std::string ran;
  bool answer = true, fails = false;
};

TEST_F(CommandLine, WithoutOptionsTheDefaultsStay) {
  EXPECT_EQ(run({}), 0);
  EXPECT_EQ(ran, "bench");
  EXPECT_EQ(a.runs, 3);
  EXPECT_EQ(a.threads, (std::vector<int>{1, 2}));
}

/// As in the program encage: without a file, JSON takes the place of what is printed.
TEST_F(CommandLine, JsonWithoutAFileGoesToStandardOutput) {
  EXPECT_EQ(run({"--json", "a.json"}), 0);
  EXPECT_EQ(a.json, "a.json");
  std::streambuf* const before = std::cout.rdbuf();
  for (const std::vector<std::string>& words : {std::vector<std::string>{"--json"}, {"--json", "-"}}) {
    a.json.clear();
    testing::internal::CaptureStdout();
    const int status = run(words);
    std::cout << "a table";
    std::cout.rdbuf(before);
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
    EXPECT_EQ(status, 0);
    EXPECT_EQ(a.json, "-");
  }
}

TEST_F(CommandLine, TakesEveryKindOfValue) {
  EXPECT_EQ(run({"a.off", "--asset", "a.glb", "--every", "40", "--speed", "2.5", "--engines", "ode,bullet", "--scene",
                 "pile", "--cages", "b.off"}),
            0);
  EXPECT_EQ(a.asset, "a.glb");
  EXPECT_EQ(a.every, 40);
  EXPECT_EQ(a.speed, 2.5);
  EXPECT_EQ(a.engines, (std::vector<std::string>{"ode", "bullet"}));
  EXPECT_EQ(a.scene, "pile");
  EXPECT_TRUE(a.cages);
  EXPECT_EQ(a.files, (std::vector<std::filesystem::path>{"a.off", "b.off"}));
}

TEST_F(CommandLine, ANamedListEndsWithItsWord) {
  EXPECT_EQ(run({"--threads", "3,4", "a.off"}), 0);
  EXPECT_EQ(a.threads, (std::vector<int>{3, 4}));
  EXPECT_EQ(a.files.size(), 1U);
}

TEST_F(CommandLine, RefusesWhatIsOutOfLimits) {
  for (const std::vector<std::string>& bad : std::vector<std::vector<std::string>>{{"--every", "0"},
                                                                                   {"--runs", "x"},
                                                                                   {"--runs", "1.5"},
                                                                                   {"--speed", "-0.1"},
                                                                                   {"--scene", "stirred"},
                                                                                   {"--engines", "fcl,magic"},
                                                                                   {"--threads", "4,9"},
                                                                                   {"--threads", "2", "--scene", "gas"},
                                                                                   {"--cages"},
                                                                                   {"--unknown"}}) {
    ran.clear();
    EXPECT_EQ(run(bad), 2) << bad[0];
    EXPECT_EQ(ran, "") << bad[0];
  }
}

TEST_F(CommandLine, TheEnvironmentStandsInForAnOption) {
  ASSERT_EQ(setenv("ENCAGE_TEST_SPEED", "4", 1), 0);
  EXPECT_EQ(run({}), 0);
  EXPECT_EQ(a.speed, 4);
  EXPECT_EQ(run({"--speed", "5"}), 0);
  EXPECT_EQ(a.speed, 5);
  unsetenv("ENCAGE_TEST_SPEED");
}

TEST_F(CommandLine, TheExitStatusSaysHowItEnded) {
  answer = false;
  EXPECT_EQ(run({}), 1);
  fails = true;
  EXPECT_EQ(run({}), 2);
  EXPECT_EQ(run({"--help"}), 0);
}

TEST_F(CommandLine, ASubcommandIsChosenByItsName) {
  const auto run_named = [&](std::vector<std::string> words) {
    words.emplace(words.begin(), "benches");
    std::vector<char*> argv = pointers(words);
    return run_commands("benches", "Tests", {command("one"), command("two")}, static_cast<int>(argv.size()),
                        argv.data());
  };
  EXPECT_EQ(run_named({"two", "--runs", "9"}), 0);
  EXPECT_EQ(ran, "two");
  EXPECT_EQ(a.runs, 9);
  ran.clear();
  for (const std::vector<std::string>& bad :
       std::vector<std::vector<std::string>>{{}, {"three"}, {"--runs", "2"}, {"one", "--runs", "0"}}) {
    EXPECT_EQ(run_named(bad), 2);
    EXPECT_EQ(ran, "");
  }
}

TEST(CheckOutputs, RefusesFoldersThatAreNotThereAndInputs) {
  const std::filesystem::path here = std::filesystem::current_path();
  EXPECT_NO_THROW(check_outputs({"", here / "out.json"}, {here, ""}));
  EXPECT_THROW(check_outputs({"", here / "missing" / "out.json"}, {}), Error);
  EXPECT_THROW(check_outputs({here}, {}), Error);
  EXPECT_THROW(check_outputs({here / "CMakeCache.txt", ENCAGE_TEST_DATA}, {}), Error);
}

}  // namespace
}  // namespace encage::bench

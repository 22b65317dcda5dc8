// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench threads.

#include "tests/bench/tools/recorded_tool.h"

#include <nlohmann/json.hpp>

namespace encage::test {
namespace {

class ThreadsTool : public RecordedTool {
 protected:
  ThreadsTool()
      : RecordedTool("threads",
                     // The first step lacks a body.
                     "0,0,0,0,0,0,0,0,1\n"
                     "1,0,0,0,0,0,0,0,1\n1,1,1,0,0,0.70710678118654752,0,0,0.70710678118654752\n"
                     "2,0,0,0,0.1,0,0,0,1\n2,1,1,0.2,0,0.70710678118654752,0,0,0.70710678118654752\n"
                     "3,0,0,0,0.2,0,0,0,1\n3,1,1,0.4,0,0.70710678118654752,0,0,0.70710678118654752\n") {}
};

TEST_F(ThreadsTool, ComparesNumbersOfThreads) {
  const RunResult result = run_tool({"--threads", "1,2,3", "--copies", "4", "--every", "2", "--continuous",
                                     "--triangles", "--runs", "2", "--json", "threads.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_NE(result.out.find("8 bodies, 2 steps"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("The same results in the same order."), std::string::npos);
  const auto json = nlohmann::json::parse(folder.read("threads.json"));
  EXPECT_EQ(json.at("bodies"), 8);
  EXPECT_EQ(json.at("steps"), 2);
  EXPECT_EQ(json.at("different_steps"), 0);
  ASSERT_EQ(json.at("threads").size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const auto& one = json.at("threads").at(i);
    EXPECT_EQ(one.at("threads"), i + 1);
    EXPECT_GT(one.at("search_ms_per_step"), 0);
    EXPECT_GT(one.at("update_ms_per_step"), 0);
    EXPECT_GT(one.at("search_ratio"), 0);
  }
}

TEST_F(ThreadsTool, RefusesBadInput) {
  expect_refused({"--threads", "0"}, "--threads");
  expect_refused({"--every", "0"}, "--every");
  expect_refused({"--json", "poses.csv"}, "poses.csv");
  write_poses("empty.csv", "");
  expect_refused({}, "no poses", "empty.csv");
}

}  // namespace
}  // namespace encage::test

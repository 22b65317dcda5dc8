// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench distance.

#include "tests/bench/tools/recorded_tool.h"

#include <nlohmann/json.hpp>

namespace encage::test {
namespace {

class DistanceTool : public RecordedTool {
 protected:
  DistanceTool()
      : RecordedTool("distance",
                     "0,0,0,0,0,0,0,0,1\n0,1,1,0,1.5,0,0,0,1\n"
                     "1,0,0,0,0.1,0,0,0,1\n1,1,1,0,1.5,0,0,0,1\n2,0,0,0,0.2,0,0,0,1\n2,1,1,0,0.62,0,0,0,1\n") {}
};

TEST_F(DistanceTool, AgreesWithFcl) {
  const RunResult result = run_tool({"--every", "1", "--runs", "2", "--json", "distance.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_NE(result.out.find("| FCL, OBBRSS |"), std::string::npos) << result.out;
  const auto json = nlohmann::json::parse(folder.read("distance.json"));
  const auto& classes = json.at("classes");
  ASSERT_GE(classes.size(), 2U);
  EXPECT_EQ(classes.back().at("class"), "10 diagonals and more");
  EXPECT_EQ(classes.back().at("pairs"), 3);
  for (const auto& one : classes) {
    ASSERT_EQ(one.at("rows").size(), 7U);
    for (const auto& row : one.at("rows")) EXPECT_EQ(row.at("wrong"), 0) << row;
  }
}

TEST_F(DistanceTool, RefusesBadInput) {
  expect_refused({"--every", "0"}, "--every");
  expect_refused({"--runs", "0"}, "--runs");
  expect_refused({"--json", "poses.csv"}, "poses.csv");
  write_poses("alone.csv", "0,0,0,0,0,0,0,0,1\n");
  expect_refused({}, "no pairs", "alone.csv");
}

}  // namespace
}  // namespace encage::test

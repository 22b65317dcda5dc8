// SPDX-License-Identifier: GPL-3.0-or-later
// The program encage-covers.

#include "tests/bench/tools/recorded_tool.h"

#include <nlohmann/json.hpp>

namespace encage::test {
namespace {

class CoversTool : public RecordedTool {
 protected:
  CoversTool()
      : RecordedTool(ENCAGE_COVERS_BINARY,
                     "0,0,0,0,0,0,0,0,1\n0,1,1,0,1.5,0,0,0,1\n"
                     "1,0,0,0,0.1,0,0,0,1\n1,1,1,0,1.5,0,0,0,1\n2,0,0,0,0.2,0,0,0,1\n2,1,1,0,0.62,0,0,0,1\n") {}
};

TEST_F(CoversTool, ComparesCovers) {
  const RunResult result =
      run_tool({"--balls", "20,50", "--boxes", "30", "--every", "1", "--runs", "2", "--json", "covers.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_NE(result.out.find("At rest: 3 steps"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("| 20 balls, then cage of "), std::string::npos) << result.out;
  const auto json = nlohmann::json::parse(folder.read("covers.json"));
  EXPECT_EQ(json.at("moving").at("steps"), 2);
  for (const char* kind : {"resting", "moving"}) {
    const auto& all = json.at(kind).at("representations");
    ASSERT_EQ(all.size(), 10U);
    EXPECT_EQ(all.at(0).at("name"), "fine mesh");
    EXPECT_EQ(all.at(0).at("rejected"), json.at(kind).at("rejectable"));
  }
}

TEST_F(CoversTool, RefusesBadInput) {
  expect_refused({"--balls", "0"}, "--balls");
  expect_refused({"--every", "0"}, "--every");
  expect_refused({"--json", "poses.csv"}, "poses.csv");
  write_poses("empty.csv", "");
  expect_refused({}, "no poses", "empty.csv");
}

}  // namespace
}  // namespace encage::test

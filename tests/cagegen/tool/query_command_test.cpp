// SPDX-License-Identifier: GPL-3.0-or-later
#include <nlohmann/json.hpp>
#include <string>

#include "tests/cagegen/tool/command_fixture.h"

namespace encage::test {
namespace {

// Two tori in one place, then apart by more than their boxes.
const std::string poses =
    "step,body,x,y,z,qx,qy,qz,qw\n"
    "0,0,0,0,0,0,0,0,1\n"
    "0,1,0.1,0,0,0,0,0,1\n"
    "1,0,0,0,0,0,0,0,1\n"
    "1,1,9,0,0,0,0,0,1\n";

class QueryCommand : public CommandTest {
 protected:
  QueryCommand() { folder.write("poses.csv", poses); }
};

TEST_F(QueryCommand, CountsWhatEachStageLeaves) {
  bake_model();
  const RunResult result = encage({"query", "model.glb", "--poses", "poses.csv", "--json", "query.json"});
  EXPECT_EQ(result.status, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(folder.read("query.json"));
  ASSERT_EQ(json.at("steps").size(), 2U);
  EXPECT_EQ(json["steps"][0].at("pairs"), 1);
  EXPECT_EQ(json["steps"][0].at("touching"), 1);
  EXPECT_EQ(json["steps"][1].at("boxes"), 0);
  EXPECT_EQ(json["steps"][1].at("touching"), 0);
}

TEST_F(QueryCommand, BadRequestsAreRefused) {
  bake_model();
  folder.write("short.csv", "step,body,x,y,z,qx,qy,qz,qw\n0,0,0,0\n");
  expect_refused({"query", "missing.glb", "--poses", "poses.csv"}, "encage: missing.glb");
  expect_refused({"query", "model.obj", "--poses", "poses.csv"}, "encage: model.obj");
  expect_refused({"query", "model.glb", "--poses", "missing.csv"}, "encage: missing.csv");
  expect_refused({"query", "model.glb", "--poses", "short.csv"}, "encage: short.csv");
  expect_refused({"query", "model.glb"}, "--poses is required");
  expect_refused({"query", "model.glb", "--poses", "poses.csv", "--margin", "-1"}, "--margin");
  expect_refused({"query", "model.glb", "--poses", "poses.csv", "--margin", "nan"}, "--margin");
  expect_refused({"query", "model.glb", "--poses", "poses.csv", "--json", "nowhere/q.json"}, "encage: nowhere/q.json");
}

}  // namespace
}  // namespace encage::test

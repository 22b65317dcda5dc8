// SPDX-License-Identifier: GPL-3.0-or-later
// The program encage-micro, each bench run for a moment.

#include "tests/cagegen/tool/run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <set>
#include <string>
#include <vector>

namespace encage::test {
namespace {

class MicroTool : public testing::Test {
 protected:
  RunResult micro(std::vector<std::string> arguments) const {
    arguments.emplace(arguments.begin(), ENCAGE_MICRO_BINARY);
    return run(arguments, folder.path());
  }

  ScratchFolder folder;
};

TEST_F(MicroTool, EveryBenchCountsItems) {
  const RunResult result = micro({"--benchmark_min_time=0.0001", "--benchmark_out=micro.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto json = nlohmann::json::parse(folder.read("micro.json"));
  EXPECT_EQ(json.at("context").at("shape"), "torus");
  std::set<std::string> names;
  for (const auto& bench : json.at("benchmarks")) {
    const std::string name = bench.at("name");
    EXPECT_TRUE(names.insert(name).second) << name;
    EXPECT_FALSE(bench.contains("error_occurred")) << name;
    EXPECT_GT(bench.at("items_per_second"), 0) << name;
  }
  for (const char* name : {"kernel/triangles_apart/moving_full", "kernel/vertex_face_time", "kernel/edge_edge_time",
                           "kernel/locate/cage_0", "stage/world_box/moving", "stage/separated/moving/cage_0",
                           "stage/separated/rest/cage_2+fine", "stage/separated/moving/fine",
                           "stage/half_space/free/moving", "stage/first_contact", "stage/box_tree/10000",
                           "stage/world_collect/1000", "load/load_shape", "load/make_shape"}) {
    EXPECT_TRUE(names.contains(name)) << name;
  }
}

TEST_F(MicroTool, RefusesBadUsage) {
  for (const std::vector<std::string>& bad : std::vector<std::vector<std::string>>{
           {"--asset", "a.glb"}, {"--asset", "a.glb", "--poses", "p.csv"}, {"--benchmark_filter=none"}, {"extra"}}) {
    const RunResult result = micro(bad);
    EXPECT_EQ(result.status, 2) << bad[0];
    EXPECT_FALSE(result.err.empty());
  }
}

}  // namespace
}  // namespace encage::test

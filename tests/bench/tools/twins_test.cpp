// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench twins, run on few pairs.

#include "tests/cagegen/tool/run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace encage::test {
namespace {

class TwinsTool : public testing::Test {
 protected:
  RunResult twins(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {ENCAGE_BENCH_BINARY, "twins"});
    return run(arguments, folder.path());
  }

  ScratchFolder folder;
};

TEST_F(TwinsTool, AsksEveryKindAndMissesNothing) {
  const RunResult result = twins({"--pairs", "1500", "--threads", "2", "--json", "twins.json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto json = nlohmann::json::parse(folder.read("twins.json"));
  EXPECT_EQ(json.at("pairs"), 1500);
  EXPECT_EQ(json.at("missed"), 0);
  EXPECT_TRUE(json.at("misses").empty());
  EXPECT_EQ(json.at("kinds").size(), 14U);
  std::int64_t sum = 0;
  for (const auto& [name, kind] : json.at("kinds").items()) {
    sum += kind.at("pairs").get<std::int64_t>();
    EXPECT_GT(kind.at("rejected"), 0) << name;
    EXPECT_NE(result.out.find(name), std::string::npos) << result.out;
  }
  EXPECT_EQ(sum, 1500);
}

TEST_F(TwinsTool, APairIsTheSameAloneAndAmongOthers) {
  const auto rejected = [&](const std::string& first, const std::string& pairs) {
    const RunResult result = twins(
        {"--kinds", "triangles,half-space", "--seed", "5", "--first", first, "--pairs", pairs, "--json", "t.json"});
    EXPECT_EQ(result.status, 0) << result.err;
    const auto json = nlohmann::json::parse(folder.read("t.json"));
    return json.at("kinds").at("triangles").at("rejected").get<int>();
  };
  // Shares of 14 and 4: 14 triangles and 4 half-spaces, and so on.
  EXPECT_EQ(rejected("0", "18") + rejected("14", "36"), rejected("0", "54"));
}

TEST_F(TwinsTool, RefusesWhatItDoesNotKnow) {
  for (const std::vector<std::string>& bad : std::vector<std::vector<std::string>>{
           {"--kinds", "squares"}, {"--pairs", "0"}, {"--first", "-1"}, {"--threads", "0"}, {"extra"}}) {
    const RunResult result = twins(bad);
    EXPECT_EQ(result.status, 2) << bad[0];
    EXPECT_FALSE(result.err.empty());
  }
  EXPECT_EQ(twins({"--pairs", "1", "--json", "missing/t.json"}).status, 2);
}

}  // namespace
}  // namespace encage::test

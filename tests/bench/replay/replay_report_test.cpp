// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/replay_report.h"

#include <gtest/gtest.h>

#include <sstream>

namespace encage::replay {
namespace {

Replay example() {
  Replay replay;
  replay.steps = 10;
  replay.touching = 7;
  replay.engines = {{"encage", {"", 0.5, 7, 0, 0}, {{"cages", 0.25, 7, 0, 0}}, 0.1},
                    {"fcl", {"", 4, 8, 0, 1}, {{"cages", 2, 7, 1, 1}, {"full", 1, 7, 0, 0}}, 0.5}};
  replay.disagreements = {{3, {1, 4}, false, {"fcl", "fcl+cages"}}, {5, {2, 4}, true, {"encage", "fcl"}}};
  return replay;
}

TEST(Report, Json) {
  const auto json = to_json(example(), Continuous{9, 2, 30, 4, 3, 1.5, 0.5});
  EXPECT_EQ(json.at("engines").at("fcl").at("ms_per_step"), 4);
  EXPECT_EQ(json.at("engines").at("fcl").at("touching_pairs"), 8);
  EXPECT_EQ(json.at("engines").at("fcl").at("spurious"), 1);
  EXPECT_EQ(json.at("with_cages").at("fcl").at("ms_per_step"), 2);
  EXPECT_EQ(json.at("with_cages").at("fcl").at("missed"), 1);
  EXPECT_EQ(json.at("with_full").at("fcl").at("speedup"), 4);
  EXPECT_FALSE(json.at("with_full").contains("encage"));
  EXPECT_EQ(json.at("perfect").at("fcl").at("speedup"), 8);
  EXPECT_EQ(json.at("continuous").at("ratio"), 3);
  EXPECT_EQ(json.at("continuous").at("pairs_left_out"), 2);
  EXPECT_EQ(json.at("disagreements"), 2);
  EXPECT_EQ(json.at("disagreeing_pairs").at(0).at("truth"), false);
  EXPECT_EQ(json.at("disagreeing_pairs").at(1).at("touching").size(), 2U);
  EXPECT_FALSE(to_json(example(), {}).contains("continuous"));
}

TEST(Report, Table) {
  std::ostringstream out;
  print(out, example(), Continuous{9, 2, 30, 4, 3, 1.5, 0.5});
  std::istringstream rows(out.str());
  std::vector<std::vector<std::string>> cells;
  for (std::string row; std::getline(rows, row) && !row.empty();) {
    std::istringstream stream(row);
    cells.emplace_back();
    for (std::string cell; std::getline(stream, cell, '|');) {
      const auto first = cell.find_first_not_of(' ');
      if (first != std::string::npos)
        cells.back().push_back(cell.substr(first, cell.find_last_not_of(' ') + 1 - first));
    }
  }
  ASSERT_EQ(cells.size(), 4U) << out.str();
  EXPECT_EQ(cells[0], (std::vector<std::string>{"engine", "ms/step", "/ Encage", "with cages", "gain", "with full",
                                                "gain", "perfect", "bound", "touching", "missed", "spurious"}));
  EXPECT_EQ(cells[1].size(), cells[0].size());
  EXPECT_EQ(cells[2], (std::vector<std::string>{"encage", "0.500", "1.00", "0.250", "2.00", "-", "-", "0.100", "5.00",
                                                "7", "0", "0"}));
  EXPECT_EQ(cells[3], (std::vector<std::string>{"fcl", "4.000", "8.00", "2.000", "2.00", "1.000", "4.00", "0.500",
                                                "8.00", "8", "0", "1"}));
  EXPECT_NE(out.str().find("ratio 3.00"), std::string::npos);
}

TEST(Report, Disagreements) {
  std::ostringstream out;
  print(out, "tool: ", example().disagreements);
  EXPECT_EQ(out.str(),
            "tool: step 3, bodies 1 and 4 do not touch, but by fcl fcl+cages\n"
            "tool: step 5, bodies 2 and 4 touch, but only by encage fcl\n");
}

}  // namespace
}  // namespace encage::replay

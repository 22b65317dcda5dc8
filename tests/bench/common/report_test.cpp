// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/report.h"

#include <gtest/gtest.h>

#include <sstream>

namespace encage::bench {
namespace {

TEST(Format, TakesTextOfAnyLength) {
  EXPECT_EQ(format("%d faces, %.2f", 12, 0.5), "12 faces, 0.50");
  const std::string large(10'000, 'x');
  EXPECT_EQ(format("<%s>", large.c_str()), "<" + large + ">");
}

TEST(Escaped, StaysInItsCell) { EXPECT_EQ(escaped("a|b\nc||"), "a\\|b c\\|\\|"); }

TEST(MarkdownTable, FirstColumnLeftTheOthersRight) {
  std::ostringstream out;
  MarkdownTable table(out, {"engine", "ms"});
  table.row({"fcl", "1.5"});
  EXPECT_EQ(out.str(), "| engine | ms |\n|---|--:|\n| fcl | 1.5 |\n");
}

TEST(MarkdownTable, PadsToItsWidths) {
  std::ostringstream out;
  MarkdownTable table(out, {"engine", "ms"}, 8, 5);
  table.row({"fcl", "1.5"});
  table.row({"too_long_for_it", "123456"});
  EXPECT_EQ(out.str(),
            "| engine   |    ms |\n|----------|------:|\n| fcl      |   1.5 |\n| too_long_for_it | 123456 |\n");
}

}  // namespace
}  // namespace encage::bench

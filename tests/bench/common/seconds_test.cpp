// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/seconds.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <string>

namespace encage::bench {
namespace {

TEST(Seconds, NumbersAndFractions) {
  EXPECT_EQ(parse_seconds("--dt", "0.25"), 0.25);
  EXPECT_EQ(parse_seconds("--dt", "1/960"), 1.0 / 960);
  EXPECT_EQ(parse_seconds("--dt", "2"), 2);
}

TEST(Seconds, RefusesTheRestNamingTheOption) {
  for (const char* text : {"", "x", "1/", "/2", "1/2/3", "1/0", "0", "-1", "nan", "inf", "1/2 "}) {
    try {
      parse_seconds("--dt", text);
      FAIL() << text;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find("--dt " + std::string(text)), 0U) << error.what();
    }
  }
}

}  // namespace
}  // namespace encage::bench

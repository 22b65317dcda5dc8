// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/progress.h"

#include <gtest/gtest.h>

#include <chrono>
#include <sstream>

namespace encage::tool {
namespace {

using namespace std::chrono_literals;

TEST(Progress, LinesComeAtNewStagesAndEveryTenPercent) {
  std::ostringstream out;
  Progress progress(out, Progress::Style::lines, 0s);
  for (int percent = 0; percent <= 25; ++percent) progress.update(percent / 100.0, "start");
  progress.update(0.26, "level 1");
  EXPECT_EQ(out.str(), "0 % start\n10 % start\n20 % start\n26 % level 1\n");
}

TEST(Progress, TheBarRedrawsItselfAndIsClearedAtTheEnd) {
  std::ostringstream out;
  {
    Progress progress(out, Progress::Style::bar, 0s);
    progress.update(0.5, "level 1");
    progress.update(0.501, "level 1");
  }
  EXPECT_EQ(out.str(), "\r\033[K[###############...............] 50 % level 1\r\033[K");
}

TEST(Progress, NotesStandAboveTheBar) {
  std::ostringstream out;
  Progress progress(out, Progress::Style::bar, 0s);
  progress.update(1, "x");
  out.str("");
  progress.note("level skipped");
  EXPECT_EQ(out.str(), "\r\033[Knote: level skipped\n");
}

TEST(Progress, NothingIsDrawnWithinTheInterval) {
  std::ostringstream out;
  Progress progress(out, Progress::Style::lines, 24h);
  progress.update(0.9, "level 1");
  EXPECT_EQ(out.str(), "");
}

TEST(Progress, TheContextLeadsHere) {
  std::ostringstream out;
  std::atomic<bool> cancel{false};
  Progress progress(out, Progress::Style::lines, 0s);
  const BakeContext context = progress.context(&cancel);
  context.progress(2, "beyond the end");
  context.log("hello");
  EXPECT_EQ(out.str(), "100 % beyond the end\nnote: hello\n");
  EXPECT_EQ(context.cancel, &cancel);
}

}  // namespace
}  // namespace encage::tool

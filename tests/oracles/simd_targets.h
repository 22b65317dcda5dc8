// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <vector>

namespace encage::test {

/// Expects answer() to be the same with every instruction set of this machine, and returns it.
template <class Answer>
auto expect_same_on_all_targets(Answer&& answer) {
  const auto choose = [](std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  };
  choose(0);
  const auto expected = answer();
  std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  targets.push_back(HWY_STATIC_TARGET);  // code for the least instruction set, emulated where it has no vectors
  for (const std::int64_t target : targets) {
    choose(target);
    EXPECT_TRUE(answer() == expected) << hwy::TargetName(target);
    testing::Test::RecordProperty(hwy::TargetName(target), "compared");
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
  return expected;
}

}  // namespace encage::test

// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/encage_engine.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/bench/replay/bodies.h"

namespace encage::replay {
namespace {

TEST(EncageEngine, FindsThePairsThatTouch) {
  test::expect_exact(
      [](const encage::test::Sample&, const ShapePtr& shape) { return std::make_unique<EncageEngine>(shape); });
}

}  // namespace
}  // namespace encage::replay

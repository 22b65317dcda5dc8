// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/render/levels.h"

#include "tests/cagegen/render/shapes.h"

#include <gtest/gtest.h>

namespace encage::render {
namespace {

TEST(Levels, SourceSolidOutermostTranslucent) {
  const std::vector<TriangleMesh> levels{test::cube(1), test::cube(2), test::cube(3), test::cube(4)};
  const std::vector<Item> items = nested_items(levels);
  ASSERT_EQ(items.size(), 4U);
  EXPECT_EQ(items[0].style, Style::solid);
  EXPECT_EQ(items[1].style, Style::section);
  EXPECT_EQ(items[2].style, Style::section);
  EXPECT_EQ(items[3].style, Style::translucent);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(items[i].mesh, &levels[i]);
    EXPECT_EQ(items[i].color, level_color(static_cast<int>(i)));
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT((items[i].color - items[j].color).norm(), 0.2F);
  }
}

TEST(Levels, ASourceThatIsNotStoredIsSkipped) {
  const std::vector<TriangleMesh> levels{TriangleMesh(), test::cube(2), test::cube(3)};
  const std::vector<Item> items = nested_items(levels);
  ASSERT_EQ(items.size(), 2U);
  EXPECT_EQ(items[0].style, Style::solid);
  EXPECT_EQ(items[0].color, level_color(1));
  EXPECT_EQ(items[1].style, Style::translucent);
}

TEST(Levels, OneMeshAloneIsSolid) {
  const std::vector<TriangleMesh> levels{test::cube(1)};
  EXPECT_EQ(nested_items(levels).at(0).style, Style::solid);
  EXPECT_FALSE(level_item(levels[0], 0).edges);
  EXPECT_TRUE(level_item(levels[0], 3).edges);
}

}  // namespace
}  // namespace encage::render

// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/world/triangle_lists.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace encage::test {
namespace {

using List = TriangleLists::List;

constexpr int block = TriangleLists::block_size;
constexpr int room = block * TriangleLists::block_count;

List write(TriangleLists& lists, int number, int size) {
  TriangleLists::Writer writer(lists);
  for (int i = 0; i < size; ++i) {
    if (!writer.push({number, i})) break;
  }
  return writer.list();
}

void expect_content(const TriangleLists& lists, const List& list, int number, int size) {
  std::vector<TrianglePair> copy = {{-7, -7}};
  const auto got = lists.read(list, copy);
  ASSERT_EQ(got.size(), static_cast<std::size_t>(size));
  for (int i = 0; i < size; ++i) {
    ASSERT_EQ(got[i].a, number);
    ASSERT_EQ(got[i].b, i);
  }
}

TEST(TriangleLists, HoldWhatThreadsWroteAtOnce) {
  TriangleLists lists;
  const std::vector<int> sizes = {0, 1, block - 1, block, block + 1, 2 * block, 10 * block + 3};
  for (int round = 0; round < 3; ++round) {
    lists.clear();
    std::vector<std::vector<List>> written(3);
    {
      std::vector<std::jthread> threads;
      for (int t = 0; t < 3; ++t) {
        threads.emplace_back([&, t] {
          for (const int size : sizes) written[t].push_back(write(lists, t, size));
        });
      }
    }
    for (int t = 0; t < 3; ++t) {
      for (std::size_t i = 0; i < sizes.size(); ++i) expect_content(lists, written[t][i], t, sizes[i]);
    }
  }
}

TEST(TriangleLists, SayWhenThereIsNoRoom) {
  TriangleLists lists;
  lists.clear();
  const List most = write(lists, 1, room - block);
  const List last = write(lists, 2, block);
  EXPECT_TRUE(most.complete() && last.complete());
  EXPECT_FALSE(write(lists, 3, 1).complete());
  EXPECT_TRUE(write(lists, 3, 0).complete());
  expect_content(lists, most, 1, room - block);
  expect_content(lists, last, 2, block);
  lists.clear();
  EXPECT_FALSE(write(lists, 4, room + 1).complete());
  lists.clear();
  const List all = write(lists, 5, room);
  expect_content(lists, all, 5, room);
  TriangleLists::Writer writer(lists);
  EXPECT_FALSE(writer.push({}));
  EXPECT_FALSE(writer.push({}));
  EXPECT_FALSE(writer.list().complete());
}

}  // namespace
}  // namespace encage::test

// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/geometry/triangle_tree.h"

#include "cagegen/geometry/obstacle.h"
#include "tests/cagegen/geometry/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace encage::makers {
namespace {

using shapes::Random;
using Box = Eigen::AlignedBox3d;

struct Plane {
  Point normal;
  double offset;
};

/// A box and half-spaces, as BoxFilter holds them.
struct Query {
  Box box;
  std::vector<Plane> planes;
  double magnitude;

  BoxFilter filter() const {
    BoxFilter result(box, magnitude);
    for (const Plane& plane : planes) result.below(plane.normal, plane.offset);
    return result;
  }
  /// In double; every condition loosened by `slack`.
  bool accepts(const Box& other, double slack) const {
    if ((other.min().array() > box.max().array() + slack).any()) return false;
    if ((other.max().array() < box.min().array() - slack).any()) return false;
    return std::all_of(planes.begin(), planes.end(), [&](const Plane& plane) {
      Point lowest;
      for (int k = 0; k < 3; ++k) lowest[k] = plane.normal[k] > 0 ? other.min()[k] : other.max()[k];
      return plane.normal.dot(lowest) <= plane.offset + slack * std::max(1.0, plane.normal.norm());
    });
  }
};

Box random_box(Random& random, const Point& centre, const std::vector<Box>& earlier) {
  const int kind = random.integer(12);
  if (kind == 0) return {};
  if (kind == 1 && !earlier.empty()) return earlier[random.integer(static_cast<int>(earlier.size()))];
  Box box;
  box.extend(centre + random.point(1));
  box.extend(centre + random.point(1));
  if (kind > 4) box.max() = box.min() + 0.05 * (box.max() - box.min());
  if (kind == 2 || kind == 5) box.max()[random.integer(3)] = box.min()[random.integer(3)];
  if (kind == 3) box.max() = box.min();
  // The flat ones may have been turned inside out above.
  return Box(box.min().cwiseMin(box.max()).eval(), box.min().cwiseMax(box.max()).eval());
}

Query random_query(Random& random, const Point& centre) {
  Query query;
  const Point middle = centre + random.point(1);
  const double half = random(0, 1);
  query.box = Box(middle.array() - half, middle.array() + half);
  for (int i = random.integer(6); i > 0; --i) {
    Point normal = random.point(1).normalized();
    if (i == 2) normal *= random(1, 1e4);
    query.planes.push_back({normal, normal.dot(middle + random.point(half))});
  }
  query.magnitude = centre.cwiseAbs().maxCoeff() + 1;
  return query;
}

std::vector<std::int32_t> found(const TriangleTree& tree, const BoxFilter& filter) {
  std::vector<std::int32_t> result;
  tree.traverse(filter, [&](std::int32_t i) { result.push_back(i); });
  std::vector<std::int32_t> ranked;
  const auto rank = [&](const Float4(&low)[3], const Float4(&)[3]) { return low[0]; };
  tree.traverse_ranked(filter, rank, [&](std::int32_t i) { ranked.push_back(i); });
  std::sort(result.begin(), result.end());
  std::sort(ranked.begin(), ranked.end());
  EXPECT_EQ(result, ranked);
  EXPECT_EQ(std::adjacent_find(result.begin(), result.end()), result.end()) << "visited twice";
  return result;
}

/// Everything that the linear scan finds, and nothing that it misses by more than rounding.
void expect_scan(const TriangleTree& tree, const std::vector<Box>& boxes, const Query& query) {
  const std::vector<std::int32_t> visited = found(tree, query.filter());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const bool seen = std::binary_search(visited.begin(), visited.end(), static_cast<std::int32_t>(i));
    if (boxes[i].isEmpty()) {
      EXPECT_FALSE(seen);
    } else if (query.accepts(boxes[i], 0)) {
      EXPECT_TRUE(seen) << i;
    } else if (!query.accepts(boxes[i], 1e-5 * query.magnitude)) {
      EXPECT_FALSE(seen) << i;
    }
  }
}

/// The tree's corner coordinates may be this far from 0: 4.5 diagonals (local_origin).
std::vector<Point> slot_centres() { return {Point(0, 0, 0), Point(3, -2, 1), Point(15, -15, 15)}; }

TEST(TriangleTree, FindsWhatALinearScanFinds) {
  Random random(1);
  for (const int count : {0, 1, 2, 4, 5, 9, 40, 700}) {
    for (const Point& centre : slot_centres()) {
      std::vector<Box> boxes;
      for (int i = 0; i < count; ++i) boxes.push_back(random_box(random, centre, boxes));
      const TriangleTree tree(boxes);
      EXPECT_EQ(tree.empty(), std::all_of(boxes.begin(), boxes.end(), [](const Box& b) { return b.isEmpty(); }));
      for (int i = 0; i < 40; ++i) expect_scan(tree, boxes, random_query(random, centre));
    }
  }
}

TEST(TriangleTree, CoincidentBoxes) {
  Random random(2);
  const std::vector<Box> boxes(300, Box(Point(1, 1, 1), Point(1, 2, 2)));
  const TriangleTree tree(boxes);
  for (int i = 0; i < 50; ++i) expect_scan(tree, boxes, random_query(random, {1, 1, 1}));
}

TEST(TriangleTree, UpdateAndRemove) {
  Random random(3);
  for (const Point& centre : slot_centres()) {
    std::vector<Box> boxes;
    for (int i = 0; i < 200; ++i) boxes.push_back(random_box(random, centre, boxes));
    TriangleTree tree(boxes);
    for (int round = 0; round < 200; ++round) {
      const int i = random.integer(200);
      if (boxes[i].isEmpty()) continue;
      if (round % 3 == 0) {
        tree.remove(i);
        boxes[i] = Box();
      } else {
        do boxes[i] = random_box(random, centre, boxes);
        while (boxes[i].isEmpty());
        tree.update(i, boxes[i]);
      }
      expect_scan(tree, boxes, random_query(random, centre));
    }
  }
}

TEST(TriangleTree, Refit) {
  Random random(6);
  for (const Point& centre : slot_centres()) {
    for (const int count : {1, 3, 5, 6, 40, 300}) {
      std::vector<Box> boxes;
      while (boxes.size() < static_cast<std::size_t>(count)) {
        const Box box = random_box(random, centre, boxes);
        // Those that are left out at first stay out.
        if (!box.isEmpty() || count > 100) boxes.push_back(box);
      }
      TriangleTree tree(boxes);
      for (int round = 0; round < 6; ++round) {
        for (Box& box : boxes) {
          if (box.isEmpty() || random.integer(3) == 0) continue;
          do box = random_box(random, centre + random.point(1), {});
          while (box.isEmpty());
        }
        const int gone = random.integer(count);
        if (count > 3 && !boxes[gone].isEmpty()) {
          tree.remove(gone);
          boxes[gone] = Box();
        }
        tree.refit(boxes);
        for (int i = 0; i < 20; ++i) {
          const Query query = random_query(random, centre);
          expect_scan(tree, boxes, query);
          // The same as of a tree made afresh, boxes as tight at the leaves.
          EXPECT_EQ(found(tree, query.filter()), found(TriangleTree(boxes), query.filter()));
        }
      }
    }
  }
}

TEST(TriangleTree, RefitShrinksWhatUpdatesHaveGrown) {
  std::vector<Box> boxes;
  for (int i = 0; i < 64; ++i) boxes.emplace_back(Point(i, 0, 0), Point(i + 0.5, 1, 1));
  TriangleTree tree(boxes);
  for (int i = 0; i < 64; ++i) tree.update(i, Box(Point(-900, 5, 0), Point(900, 6, 1)));
  tree.refit(boxes);
  // How many boxes, of inner nodes too, a query looks into.
  int accepted = 0;
  const BoxFilter filter(Box(Point(10.1, 0.1, 0.1), Point(10.2, 0.2, 0.2)), 64);
  const auto counted = [&](const Float4(&low)[3], const Float4(&high)[3]) {
    const Mask4 mask = filter(low, high);
    for (int lane = 0; lane < 4; ++lane) accepted += mask.lane(lane);
    return mask;
  };
  std::vector<std::int32_t> visited;
  tree.traverse(counted, [&](std::int32_t i) { visited.push_back(i); });
  EXPECT_EQ(visited, std::vector<std::int32_t>{10});
  EXPECT_EQ(accepted, 3) << "64 leaves, four a node";
}

TEST(TriangleTree, Renumber) {
  Random random(4);
  std::vector<Box> boxes;
  for (int i = 0; i < 300; ++i) boxes.push_back(random_box(random, Point::Zero(), boxes));
  TriangleTree tree(boxes);
  const std::vector<std::int32_t> old_number = tree.renumber();
  std::vector<Box> moved;
  for (const std::int32_t i : old_number) moved.push_back(boxes[i]);
  // A permutation of those that are not empty.
  std::vector<std::int32_t> sorted = old_number;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(std::adjacent_find(sorted.begin(), sorted.end()), sorted.end());
  EXPECT_EQ(moved.size(), static_cast<std::size_t>(
                              std::count_if(boxes.begin(), boxes.end(), [](const Box& b) { return !b.isEmpty(); })));
  for (int i = 0; i < 40; ++i) expect_scan(tree, moved, random_query(random, Point::Zero()));
  // The new numbers are the ones to edit by.
  for (std::int32_t i = 0; i < 100; ++i) {
    moved[i] = Box(moved[i].min() - Point(2, 0, 0), moved[i].max() - Point(2, 0, 0));
    tree.update(i, moved[i]);
  }
  tree.remove(120);
  moved[120] = Box();
  for (int i = 0; i < 40; ++i) expect_scan(tree, moved, random_query(random, Point(-1, 0, 0)));
}

TEST(BoxFilter, NeverPrunesABoxWithAPointInAllHalfSpaces) {
  Random random(5);
  int pruned = 0;
  for (int i = 0; i < 60000; ++i) {
    const Point centre = slot_centres()[i % 3] * random(0.5, 1);
    Box box;
    box.extend(centre + random.point(1));
    if (i % 4) box.extend(centre + random.point(std::pow(10.0, -random.integer(7))));
    // A point of the box, often a corner of it; all planes and the query box touch it.
    Point x;
    for (int k = 0; k < 3; ++k) {
      const int place = random.integer(3);
      x[k] = place == 0 ? box.min()[k] : place == 1 ? box.max()[k] : random(box.min()[k], box.max()[k]);
    }
    Query query;
    query.magnitude = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
    query.box = Box(x, x);
    for (int k = 0; k < 3; ++k) (random.integer(2) ? query.box.min() : query.box.max())[k] += random(-0.1, 0.1);
    query.box.extend(x);
    for (int p = random.integer(6); p > 0; --p) {
      Point normal = random.point(1);
      normal *= p == 1 ? random(1, 1e6) / normal.norm() : 1 / normal.norm();
      // As far as double computes it: the callers' own offsets are rounded as well.
      query.planes.push_back({normal, normal.dot(x)});
    }
    const BoxFilter filter = query.filter();
    const TriangleTree tree(std::span(&box, 1));
    ASSERT_EQ(found(tree, filter).size(), 1u) << i;
    // The filter is not blind either.
    query.planes.assign(1, {random.point(1).normalized(), 0});
    Plane& plane = query.planes[0];
    plane.offset = std::min(plane.normal.dot(box.center()) - box.diagonal().norm(), plane.offset);
    query.box = box;
    if (plane.offset < plane.normal.dot(box.center()) - 1.1 * box.diagonal().norm() - 1e-4) {
      ++pruned;
      EXPECT_TRUE(found(tree, query.filter()).empty());
    }
  }
  EXPECT_GT(pruned, 10000);
}

TEST(BoxFilter, SetBelowReplaces) {
  const Box box(Point(0, 0, 0), Point(1, 1, 1));
  const TriangleTree tree(std::span(&box, 1));
  BoxFilter filter(Box(Point(-9, -9, -9), Point(9, 9, 9)), 1);
  filter.below(Point(1, 0, 0), -0.5);
  EXPECT_TRUE(found(tree, filter).empty());
  filter.set_below(0, Point(1, 0, 0), 0.5);
  EXPECT_EQ(found(tree, filter).size(), 1u);
  filter.below(Point(0, -1, 0), -1.5);
  EXPECT_TRUE(found(tree, filter).empty());
}

TEST(BoxFilter, DepthBelowTheFirstHalfSpace) {
  BoxFilter filter(Box(Point(-9, -9, -9), Point(9, 9, 9)), 1);
  filter.below(Point(0, 0, 1), 0.75);
  const Float4 zero = Float4::broadcast(0);
  const Float4 one = Float4::broadcast(1);
  const Float4 low[3] = {zero, zero, Float4::broadcast(0.25F)};
  const Float4 high[3] = {one, one, one};
  EXPECT_NEAR(filter.depth(low, high).lanes[2], 0.5, 1e-5);
}

}  // namespace
}  // namespace encage::makers

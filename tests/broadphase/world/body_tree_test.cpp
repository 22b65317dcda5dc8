// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/world/body_tree.h"

#include "oracles/count_allocations.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <utility>
#include <vector>

namespace encage::test {
namespace {

using Box = Eigen::AlignedBox3d;
using Vector = Eigen::Vector3d;
using ItemPair = std::pair<std::uint32_t, std::uint32_t>;

constexpr double unbounded = std::numeric_limits<double>::infinity();

/// Distributions of random boxes.
enum class Scene { uniform, lattice, points, nested, same, line, clusters, sizes, mixed };
constexpr std::array<Scene, 9> scenes = {Scene::uniform, Scene::lattice, Scene::points,   Scene::nested, Scene::same,
                                         Scene::line,    Scene::sizes,   Scene::clusters, Scene::mixed};

class Boxes {
 public:
  explicit Boxes(Scene scene, unsigned seed = 1) : scene_(scene), random_(seed) {}

  Box next() {
    switch (scene_ == Scene::mixed ? scenes[random_() % 8] : scene_) {
      case Scene::uniform: return around(point(10), point(1));
      case Scene::lattice: {  // boxes that touch, and equal faces
        const Vector corner(integer(6), integer(6), integer(6));
        return {corner, corner + Vector(integer(2), integer(2), integer(2))};
      }
      case Scene::points: return around(Vector(integer(4), integer(4), integer(4)), Vector::Zero());
      case Scene::nested: return around(Vector::Zero(), Vector::Constant(std::pow(2.0, 1 + integer(60) / 2.0)));
      case Scene::same: return {Vector(1, 2, 3), Vector(4, 5, 6)};
      case Scene::line: return around(Vector(static_cast<double>(++count_), 0, 0), Vector::Constant(0.5));
      case Scene::clusters: return around(Vector(100.0 * integer(3), 0, 0) + point(0.1), point(0.02));
      case Scene::sizes: return around(point(10), point(1) * std::pow(10.0, uniform() * 3 - 1));
      case Scene::mixed: break;
    }
    return special();
  }

  /// Returns an empty, infinite, huge or half-infinite box, or one with NaN.
  Box special() {
    switch (random_() % 6) {
      case 0: return Box();
      case 1: return {Vector::Constant(-unbounded), Vector::Constant(unbounded)};
      case 2: return {Vector::Constant(-1e200), Vector::Constant(1e300)};
      case 3: return {Vector(-unbounded, 1, 2), Vector(3, 4, unbounded)};
      case 4: return {Vector(0, 0, std::nan("")), Vector(1, 1, 1)};
      default: return {Vector::Constant(1e300), Vector::Constant(1e300)};
    }
  }

  double uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  int integer(int largest) { return static_cast<int>(random_() % static_cast<unsigned>(largest + 1)); }
  Vector point(double size) { return Vector(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5) * 2 * size; }

 private:
  static Box around(const Vector& centre, const Vector& half) {
    return {centre - half.cwiseAbs(), centre + half.cwiseAbs()};
  }

  Scene scene_;
  std::minstd_rand random_;
  int count_ = 0;
};

/// A tree and its expected content in plain lists.
struct TreeTwin {
  struct Entry {
    BodyTree::Leaf leaf = -1;
    FloatBox box;
    bool moved = false;
  };
  BodyTree tree;
  std::map<std::uint32_t, Entry> entries;

  void insert(std::uint32_t item, const FloatBox& box) { entries[item] = {tree.insert(box, item), box, true}; }
  void remove(std::uint32_t item) {
    tree.remove(entries.at(item).leaf);
    entries.erase(item);
  }
  void update(std::uint32_t item, const FloatBox& box) {
    Entry& entry = entries.at(item);
    tree.update(entry.leaf, box);
    entry.box = box;
    entry.moved = true;
  }
  void clear_moved() {
    tree.clear_moved();
    for (auto& [item, entry] : entries) entry.moved = false;
  }

  std::vector<std::uint32_t> query(const FloatBox& box) const {
    std::vector<std::uint32_t> found;
    tree.query(box, [&](std::uint32_t item) { found.push_back(item); });
    std::sort(found.begin(), found.end());
    return found;
  }
  std::vector<std::uint32_t> query_all(const FloatBox& box) const {
    std::vector<std::uint32_t> found;
    for (const auto& [item, entry] : entries) {
      if (entry.box.overlaps(box)) found.push_back(item);
    }
    return found;
  }
  std::vector<ItemPair> moved_pairs(double margin) {
    std::vector<ItemPair> found;
    tree.refresh();
    tree.query_moved_pairs(margin, [&](std::uint32_t a, std::uint32_t b) { found.emplace_back(std::minmax(a, b)); });
    std::sort(found.begin(), found.end());
    return found;
  }
  /// The pairs that must be found, or with `may` also those that may be: the query may enlarge either box.
  std::vector<ItemPair> moved_pairs_of_all(double margin, bool may) const {
    std::vector<ItemPair> found;
    for (auto a = entries.begin(); a != entries.end(); ++a) {
      for (auto b = std::next(a); b != entries.end(); ++b) {
        const Entry &x = a->second, &y = b->second;
        if (!x.moved && !y.moved) continue;
        const bool first = (margin > 0 ? x.box.enlarged(margin) : x.box).overlaps(y.box);
        const bool second = (margin > 0 ? y.box.enlarged(margin) : y.box).overlaps(x.box);
        if (may ? (first && x.moved) || (second && y.moved) : (first || !x.moved) && (second || !y.moved)) {
          found.emplace_back(a->first, b->first);
        }
      }
    }
    return found;
  }
  void check_moved_pairs(double margin) {
    const std::vector<ItemPair> found = moved_pairs(margin), must = moved_pairs_of_all(margin, false),
                                may = moved_pairs_of_all(margin, true);
    ASSERT_EQ(std::adjacent_find(found.begin(), found.end()), found.end());
    ASSERT_TRUE(std::includes(found.begin(), found.end(), must.begin(), must.end()));
    ASSERT_TRUE(std::includes(may.begin(), may.end(), found.begin(), found.end()));
    if (margin == 0) {
      ASSERT_EQ(must, may);
    }
  }
  /// Of a tree that need not be refreshed: the leaves that overlap, and those that are stale.
  std::vector<std::uint32_t> query_in_order(const FloatBox& box) const {
    std::vector<std::uint32_t> found;
    const auto keys = [&](const BoxLanes& lanes) {
      std::array<double, BoxLanes::width> all;
      for (int lane = 0; lane < BoxLanes::width; ++lane) {
        all[lane] = lanes.at(lane).overlaps(box) ? 0 : std::nan("");
      }
      return all;
    };
    tree.query_in_order(
        keys, [] { return unbounded; }, [&](std::uint32_t item) { found.push_back(item); });
    for (const BodyTree::Leaf leaf : tree.stale()) {
      if (tree.box(leaf).overlaps(box)) found.push_back(tree.item(leaf));
    }
    std::sort(found.begin(), found.end());
    return found;
  }
  /// The first item of those with the least lower bound.
  std::uint32_t least_in_order() const {
    std::uint32_t best = 0;
    double least = unbounded;
    const auto keys = [&](const BoxLanes& lanes) {
      std::array<double, BoxLanes::width> all;
      for (int lane = 0; lane < BoxLanes::width; ++lane) all[lane] = static_cast<double>(lanes.lower[0][lane]);
      return all;
    };
    const auto look = [&](std::uint32_t item) {
      const auto key = static_cast<double>(entries.at(item).box.lower[0]);
      if (key < least || (key == least && item < best)) {
        least = key;
        best = item;
      }
    };
    tree.query_in_order(
        keys, [&] { return least; }, look);
    for (const BodyTree::Leaf leaf : tree.stale()) look(tree.item(leaf));
    return best;
  }
  std::uint32_t least_of_all() const {
    std::uint32_t best = entries.begin()->first;
    for (const auto& [item, entry] : entries) {
      if (entry.box.lower[0] < entries.at(best).box.lower[0]) best = item;
    }
    return best;
  }
  void check_queries_in_order(Boxes& boxes) const {
    for (int i = 0; i < 5; ++i) {
      const FloatBox box = FloatBox::around(boxes.next());
      ASSERT_EQ(query_in_order(box), query_all(box));
    }
    if (!entries.empty()) {
      ASSERT_EQ(least_in_order(), least_of_all());
    }
  }
  void check(Boxes& boxes) {
    ASSERT_EQ(tree.defect(), "");
    check_queries_in_order(boxes);
    tree.refresh();
    ASSERT_EQ(tree.defect(), "");
    check_queries_in_order(boxes);
    ASSERT_EQ(tree.size(), static_cast<int>(entries.size()));
    for (int i = 0; i < 20; ++i) {
      const FloatBox box = FloatBox::around(i % 5 == 0 ? boxes.special() : boxes.next());
      ASSERT_EQ(query(box), query_all(box));
    }
  }
};

TEST(FloatBoxes, ContainTheBoxAndAreTight) {
  Boxes boxes(Scene::sizes);
  for (int i = 0; i < 10'000; ++i) {
    const double scale = std::pow(10.0, boxes.integer(80) - 40), margin = i % 2 == 0 ? 0 : boxes.uniform() * scale;
    Box box = boxes.next();
    box.min() *= scale;
    box.max() *= scale;
    const FloatBox f = FloatBox::around(box, margin);
    for (int k = 0; k < 3; ++k) {
      // long double has 11 more bits.
      const auto lower = static_cast<long double>(box.min()[k]) - margin,
                 upper = static_cast<long double>(box.max()[k]) + margin;
      const bool in_range = std::abs(lower) < 1e38L && std::abs(upper) < 1e38L;
      ASSERT_LT(f.lower[k], lower);
      ASSERT_GT(f.upper[k], upper);
      if (in_range) {
        ASSERT_LE(lower - f.lower[k], std::abs(lower) * 2.5e-7L + 2e-38L);
        ASSERT_LE(f.upper[k] - upper, std::abs(upper) * 2.5e-7L + 2e-38L);
      }
    }
  }
}

TEST(FloatBoxes, NotANumberIsTheWholeLine) {
  const FloatBox f = FloatBox::around({Vector::Constant(std::nan("")), Vector::Constant(std::nan(""))});
  EXPECT_TRUE(f.overlaps(FloatBox::around({Vector::Constant(1e30), Vector::Constant(1e30)})));
  EXPECT_TRUE(f.contains(FloatBox::around({Vector::Constant(-unbounded), Vector::Constant(unbounded)})));
}

TEST(FloatBoxes, OverlapIsThatOfClosedBoxes) {
  const FloatBox a{{0, 0, 0}, {1, 1, 1}};
  EXPECT_TRUE(a.overlaps({{1, 1, 1}, {2, 2, 2}}));
  EXPECT_FALSE(a.overlaps({{0, 0, std::nextafter(1.f, 2.f)}, {2, 2, 2}}));
  EXPECT_FALSE(a.overlaps({{-2, -1, -1}, {-1e-30f, 2, 2}}));
  EXPECT_TRUE(a.overlaps({{0.5f, 0.5f, 0.5f}, {0.5f, 0.5f, 0.5f}}));
  EXPECT_TRUE(a.contains(a));
  EXPECT_FALSE(a.contains({{0, 0, 0}, {1, 1, std::nextafter(1.f, 2.f)}}));
  EXPECT_FALSE(a.contains({{0, -1e-30f, 0}, {1, 1, 1}}));
  EXPECT_EQ(a.merged({{2, -1, 0.5f}, {3, 0, 0.75f}}), (FloatBox{{0, -1, 0}, {3, 1, 1}}));
}

TEST(BodyTrees, EmptyTree) {
  TreeTwin twin;
  Boxes boxes(Scene::uniform);
  twin.check(boxes);
  EXPECT_EQ(twin.moved_pairs(1).size(), 0u);
  twin.insert(7, FloatBox{});
  twin.check(boxes);
  twin.remove(7);
  twin.check(boxes);
}

/// Inserts, moves slightly or far, and removes leaves in random order.
void run_twin(Scene scene, int steps, unsigned seed) {
  TreeTwin twin;
  Boxes boxes(scene, seed);
  std::minstd_rand random(seed + 1);
  std::uint32_t next_item = 0;
  const auto any_item = [&] { return std::next(twin.entries.begin(), random() % twin.entries.size())->first; };
  for (int i = 0; i < steps && !testing::Test::HasFatalFailure(); ++i) {
    const unsigned action = random() % 16;
    const bool growing = (i / 400) % 3 != 2;
    if (twin.entries.empty() || action < (growing ? 6u : 2u)) {
      twin.insert(next_item++, FloatBox::around(boxes.next()));
    } else if (action < 8) {
      twin.remove(any_item());
    } else {
      twin.update(any_item(), FloatBox::around(boxes.next()));
    }
    if (i % 100 == 49) {
      ASSERT_EQ(twin.tree.defect(), "");
      twin.check_queries_in_order(boxes);
      if (i % 300 == 49) twin.tree.refresh();
    }
    if (i % 100 == 99) {
      twin.check(boxes);
      for (const double margin : {0.0, 0.3, unbounded}) twin.check_moved_pairs(margin);
      if (i % 200 == 199) twin.clear_moved();
    }
  }
}

TEST(BodyTrees, FindWhatBruteForceFinds) {
  for (const Scene scene : scenes) {
    SCOPED_TRACE(static_cast<int>(scene));
    run_twin(scene, 3000, 17 + static_cast<unsigned>(scene));
  }
}

TEST(BodyTrees, OneLevelOrMore) {
  // These numbers of leaves are close to those at which nodes and levels are full.
  for (const int count : {1, 7, 8, 9, 63, 64, 65, 511, 512, 513, 600}) {
    TreeTwin twin;
    Boxes boxes(Scene::uniform, static_cast<unsigned>(count));
    for (int i = 0; i < count; ++i) {
      twin.insert(static_cast<std::uint32_t>(i), FloatBox::around(boxes.next()));
      if (i % 100 == 50) twin.check(boxes);
    }
    twin.check(boxes);
    twin.check_moved_pairs(0);
    twin.clear_moved();
    for (int i = 0; i < count; i += 3) twin.update(static_cast<std::uint32_t>(i), FloatBox::around(boxes.next()));
    twin.check(boxes);
    twin.check_moved_pairs(0);
    for (int i = 0; i + 1 < count; ++i) twin.remove(static_cast<std::uint32_t>(i));
    twin.check(boxes);
    twin.check_moved_pairs(0);
  }
}

/// Number of pairs of nodes tested per node after all leaves have moved.
double work_of(BodyTree& tree) {
  tree.refresh();
  tree.query_moved_pairs(0, [](std::uint32_t, std::uint32_t) {});
  tree.clear_moved();
  return static_cast<double>(tree.work()) * BoxLanes::width / tree.size();
}

TEST(BodyTrees, SearchesLookAtFewNodes) {
  for (const bool sorted : {false, true}) {
    Boxes boxes(Scene::uniform);
    std::vector<Vector> centres;
    for (int i = 0; i < 20'000; ++i) centres.push_back(boxes.point(14));
    if (sorted)
      std::sort(centres.begin(), centres.end(), [](const Vector& a, const Vector& b) { return a.x() < b.x(); });
    BodyTree tree;
    for (std::uint32_t i = 0; i < centres.size(); ++i) {
      tree.insert(FloatBox::around({centres[i], centres[i] + Vector::Ones()}), i);
    }
    // Eight boxes share a cell of width two, or of width three with their extents: about 27 neighbours.
    EXPECT_LT(work_of(tree), 45);
    EXPECT_EQ(tree.defect(), "");
  }
}

TEST(BodyTrees, TreesThatAreWornAreOrderedAnew) {
  // All leaves change their positions: boxes of nodes become large, but not for long.
  Boxes boxes(Scene::uniform);
  BodyTree tree;
  std::vector<BodyTree::Leaf> leaves;
  const auto box = [&] {
    const Vector corner = boxes.point(10);
    return FloatBox::around({corner, corner + Vector::Ones()});
  };
  for (std::uint32_t i = 0; i < 4000; ++i) leaves.push_back(tree.insert(box(), i));
  const double ordered = work_of(tree);
  for (const BodyTree::Leaf leaf : leaves) tree.update(leaf, box());
  EXPECT_GT(work_of(tree), 4 * ordered);
  for (const BodyTree::Leaf leaf : leaves) tree.touch(leaf);
  EXPECT_LT(work_of(tree), 1.2 * ordered);
  EXPECT_EQ(tree.defect(), "");
}

TEST(BodyTrees, AFewLeavesFarAwayOrHugeDoNotSlowDownTheOthers) {
  Boxes boxes(Scene::uniform);
  BodyTree tree;
  const auto insert = [&](const Vector& at, double size) {
    tree.insert(FloatBox::around({at, at + Vector::Constant(size)}), 0);
  };
  for (int i = 0; i < 4000; ++i) insert(boxes.point(8), 1);
  const double without = work_of(tree);
  for (const double distance : {1e7, 1e20, 1e30}) insert(Vector::Constant(distance), distance / 10);
  for (int i = 0; i < 5; ++i) insert(boxes.point(8) - Vector::Constant(20), 40);
  for (int i = 0; i < 4008; ++i) tree.touch(i);
  EXPECT_LT(work_of(tree), 2 * without);
}

TEST(BodyTrees, ChangesOfManyLeavesDoNotAllocate) {
  BodyTree tree, other;
  Boxes boxes(Scene::uniform);
  std::vector<BodyTree::Leaf> leaves;
  for (std::uint32_t i = 0; i < 1000; ++i) leaves.push_back(tree.insert(FloatBox::around(boxes.next()), i));
  other.make_room_for(tree);
  const long before = allocations;
  other = tree;
  for (BodyTree* t : {&tree, &other}) {
    for (int step = 0; step < 20; ++step) {
      for (const BodyTree::Leaf leaf : leaves) t->update(leaf, FloatBox::around(boxes.next()));
      t->refresh();
      t->query_moved_pairs(0, [](std::uint32_t, std::uint32_t) {});
      t->clear_moved();
    }
    for (const BodyTree::Leaf leaf : leaves) t->remove(leaf);
    t->refresh();
  }
  EXPECT_EQ(allocations, before);
}

TEST(BodyTrees, PairsOfMovedLeavesAreGivenOnceAndWithinTheMargin) {
  TreeTwin twin;
  for (std::uint32_t i = 0; i < 4; ++i) {
    const float x = 2 * static_cast<float>(i);
    twin.insert(i, {{x, 0, 0}, {x + 1, 1, 1}});
  }
  EXPECT_EQ(twin.moved_pairs(0.5), std::vector<ItemPair>());
  EXPECT_EQ(twin.moved_pairs(1), (std::vector<ItemPair>{{0, 1}, {1, 2}, {2, 3}}));
  EXPECT_EQ(twin.moved_pairs(unbounded).size(), 6u);
  twin.clear_moved();
  EXPECT_EQ(twin.moved_pairs(unbounded), std::vector<ItemPair>());
  twin.tree.touch(twin.entries.at(2).leaf);
  twin.tree.touch(twin.entries.at(2).leaf);
  EXPECT_EQ(twin.moved_pairs(1), (std::vector<ItemPair>{{1, 2}, {2, 3}}));
  twin.remove(2);
  EXPECT_TRUE(twin.tree.moved().empty());
}

TEST(BodyTrees, TheSameCallsGiveTheSameOrder) {
  const auto run = [] {
    Boxes boxes(Scene::mixed, 9);
    BodyTree tree;
    std::vector<BodyTree::Leaf> leaves;
    for (std::uint32_t i = 0; i < 500; ++i) leaves.push_back(tree.insert(FloatBox::around(boxes.next()), i));
    for (const BodyTree::Leaf leaf : leaves) {
      const FloatBox box = FloatBox::around(boxes.next());
      tree.update(leaf, box);
    }
    tree.refresh();
    std::vector<ItemPair> order;
    tree.query_moved_pairs(0, [&](std::uint32_t a, std::uint32_t b) { order.emplace_back(a, b); });
    return order;
  };
  const auto first = run();
  EXPECT_GT(first.size(), 100u);
  EXPECT_EQ(first, run());
}

}  // namespace
}  // namespace encage::test

// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/contact/feature_pair.h"

#include "oracles/exact_ccd.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

constexpr double cell = 0x1p-22;

std::optional<double> ask(Features kind, const MovingPoints& points, const ContactOptions& options = {}) {
  return kind == Features::vertex_face ? vertex_face_time(points, options) : edge_edge_time(points, options);
}

template <class Function>
void change(MovingPoints& points, const Function& function) {
  for (Vector& p : points.start) p = function(p);
  for (Vector& p : points.end) p = function(p);
}

double largest_difference(const MovingPoints& points) {
  double largest = 0;
  for (const auto& ends : {points.start, points.end}) {
    for (const Vector& p : ends) largest = std::max(largest, (p - ends[0]).cwiseAbs().maxCoeff());
  }
  return largest;
}

class FeaturePairs : public testing::TestWithParam<Features> {
 protected:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vector point() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }
  int integer(int size) { return static_cast<int>(random_() % (2 * size + 1)) - size; }
  Vector lattice_point(int size) {
    const int x = integer(size), y = integer(size), z = integer(size);
    return Vector(x, y, z);
  }
  MovingPoints lattice(int size) {
    MovingPoints points;
    for (auto* ends : {&points.start, &points.end}) {
      for (Vector& p : *ends) p = lattice_point(size);
    }
    return points;
  }
  MovingPoints generic() {
    MovingPoints points;
    for (auto* ends : {&points.start, &points.end}) {
      for (Vector& p : *ends) p = point();
    }
    return points;
  }
  // Returns a matrix of small integers, which is sometimes singular.
  Eigen::Matrix3d matrix() {
    Eigen::Matrix3d m;
    for (int k = 0; k < 3; ++k) m.row(k) = lattice_point(2);
    return m;
  }
  bool coin() { return random_() % 2 == 0; }

  struct Counts {
    int contacts = 0, free = 0, spurious = 0;
  };
  // Checks that no contact is missed or late, and that none is early by more than rounding.
  Counts compare(int count, const std::function<MovingPoints()>& make) {
    Counts counts;
    for (int i = 0; i < count; ++i) {
      const MovingPoints points = make();
      const std::optional<double> said = ask(GetParam(), points);
      const std::optional<TimeBounds> exact = exact_first_contact(GetParam(), points);
      counts.contacts += exact.has_value();
      counts.free += !exact && !said;
      counts.spurious += !exact && said;
      if (exact) {
        EXPECT_LE(said.value_or(2), exact->high) << "query " << i;
      }
      if (said && !(exact && *said > exact->low - 2 * cell)) {
        const double tolerance = 0x1p-44 * largest_difference(points);
        const std::optional<double> close = first_within(GetParam(), points, tolerance, 0, cell / 4);
        EXPECT_TRUE(close && *close < *said + 2 * cell) << "query " << i << " at " << *said;
      }
      if (HasFailure()) break;
    }
    return counts;
  }

  std::minstd_rand random_{7};
};

TEST_P(FeaturePairs, SmallIntegers) {
  for (const int size : {1, 2, 3}) {
    const Counts counts = compare(1'200, [&] { return lattice(size); });
    EXPECT_GT(counts.contacts, 80);
    EXPECT_GT(counts.free, 500);
    EXPECT_EQ(counts.spurious, 0);
  }
}

TEST_P(FeaturePairs, AnyPlace) {
  const Counts counts = compare(2'000, [&] { return generic(); });
  EXPECT_GT(counts.contacts, 50);
  EXPECT_GT(counts.free, 1'000);
}

TEST_P(FeaturePairs, Translations) {
  const Counts counts = compare(4'000, [&] {
    MovingPoints points = lattice(3);
    const Vector u = lattice_point(3), v = lattice_point(2);
    for (int i = 0; i < 4; ++i) points.end[i] = points.start[i] + (i < 2 ? u : v);
    return points;
  });
  EXPECT_GT(counts.contacts, 100);
  EXPECT_EQ(counts.spurious, 0);
}

TEST_P(FeaturePairs, CoplanarThroughout) {
  const Counts counts = compare(100, [&] {
    MovingPoints points = lattice(3);
    const Eigen::Matrix3d m = matrix();
    change(points, [&](const Vector& p) { return Vector(m * Vector(p.x(), p.y(), 0)); });
    return points;
  });
  EXPECT_GT(counts.contacts, 10);
  EXPECT_GT(counts.free, 10);
  EXPECT_EQ(counts.spurious, 0);
}

TEST_P(FeaturePairs, SlidingInAndAboveThePlane) {
  const Counts counts = compare(400, [&] {
    MovingPoints points = lattice(3);
    const Eigen::Matrix3d m = matrix();
    const int height = integer(1);
    for (int i = 0; i < 4; ++i) {
      points.start[i].z() = points.end[i].z() = i < 2 && GetParam() == Features::edge_edge ? height : 0;
      if (i > 1) points.end[i] = points.start[i];
    }
    if (GetParam() == Features::vertex_face) points.start[0].z() = points.end[0].z() = height;
    change(points, [&](const Vector& p) { return Vector(m * p); });
    return points;
  });
  EXPECT_GT(counts.contacts, 40);
  EXPECT_GT(counts.free, 100);
  EXPECT_EQ(counts.spurious, 0);
}

TEST_P(FeaturePairs, OnALine) {
  const Counts counts = compare(100, [&] {
    MovingPoints points = lattice(5);
    const Vector direction = lattice_point(3);
    change(points, [&](const Vector& p) { return Vector(direction * p.x() + Vector(1, 2, 3)); });
    return points;
  });
  EXPECT_GT(counts.contacts, 20);
  EXPECT_EQ(counts.spurious, 0);
}

TEST_P(FeaturePairs, DegenerateFeatures) {
  const Counts counts = compare(500, [&] {
    MovingPoints points = lattice(2);
    const int i = std::abs(integer(3)), j = std::abs(integer(3));
    points.start[i] = points.start[j];
    if (coin()) points.end[i] = points.end[j];
    return points;
  });
  EXPECT_GT(counts.contacts, 100);
  EXPECT_EQ(counts.spurious, 0);
}

TEST_P(FeaturePairs, ParallelEdges) {
  const Counts counts = compare(1'000, [&] {
    MovingPoints points = lattice(2);
    points.start[3] = points.start[2] + points.start[1] - points.start[0];
    if (coin()) points.end[3] = points.end[2] + (points.end[1] - points.end[0]) * integer(2);
    return points;
  });
  EXPECT_GT(counts.contacts, 50);
  EXPECT_EQ(counts.spurious, 0);
}

// The integers are small, or have so many bits that projections are rounded. At the end of the step the features only
// touch, so nothing but the rounding bound prevents a false proof.
TEST_P(FeaturePairs, ContactAtTheEndsOfTheStep) {
  const Counts counts = compare(2'000, [&] {
    MovingPoints points = lattice(coin() ? 3 : 1 << 26);
    auto& ends = coin() ? points.start : points.end;
    // The vertex lies in the face or on its corner; the edges cross or meet end to end.
    if (GetParam() == Features::vertex_face) {
      ends[0] = integer(1) == 0 ? ends[1] : Vector((ends[1] + ends[2] + 2 * ends[3]) / 4);
    } else {
      ends[3] = integer(1) == 0 ? ends[0] : Vector((3 * ends[0] + ends[1]) / 2 - ends[2]);
    }
    return points;
  });
  EXPECT_EQ(counts.contacts, 2'000);
}

TEST_P(FeaturePairs, FarFromTheOrigin) {
  const Counts counts = compare(1'000, [&] {
    MovingPoints points = lattice(3);
    const Vector offset = lattice_point(3) * 1e9;
    change(points, [&](const Vector& p) { return Vector(p / 8 + offset); });
    return points;
  });
  EXPECT_GT(counts.contacts, 50);
  EXPECT_EQ(counts.spurious, 0);
}

TEST_P(FeaturePairs, TinyAndHuge) {
  for (const double scale : {0x1p-130, 0x1p-60, 0x1p60, 0x1p130}) {
    const Counts counts = compare(500, [&] {
      MovingPoints points = lattice(3);
      change(points, [&](const Vector& p) { return Vector(p * scale); });
      return points;
    });
    EXPECT_GT(counts.contacts, 25) << scale;
    EXPECT_EQ(counts.spurious, 0) << scale;
  }
}

// At small scales norms and products underflow, and still no contact may be missed; at large ones no overflow may count
// as a proof.
TEST_P(FeaturePairs, NothingMissedBeyondTheRangeOfProofs) {
  for (const double scale : {0x1p-1060, 0x1p-500, 0x1p-300, 0x1p-200, 0x1p200, 0x1p500, 0x1p1000}) {
    for (int i = 0; i < 500; ++i) {
      MovingPoints points = lattice(2);
      const bool touches = exact_first_contact(GetParam(), points).has_value();
      change(points, [&](const Vector& p) { return Vector(p * scale); });
      if (touches) {
        ASSERT_TRUE(ask(GetParam(), points)) << scale;
      }
    }
  }
}

// The features touch at their boundaries, moved by a few units in the last place.
TEST_P(FeaturePairs, NearlyTouching) {
  const Counts counts = compare(1'500, [&] {
    MovingPoints points = lattice(2);
    change(points, [&](const Vector& p) {
      Vector q = p;
      for (int k = 0; k < 3; ++k) q[k] += integer(1) * uniform(0, 1) * 0x1p-50;
      return q;
    });
    return points;
  });
  EXPECT_GT(counts.contacts, 100);
  EXPECT_GT(counts.free, 300);
  RecordProperty("spurious", counts.spurious);
}

// The features are on both sides of a plane, and within one cell of the grid of times they move along it by far more
// than the gap.
TEST_P(FeaturePairs, NearMissesAreFree) {
  const int upper = GetParam() == Features::vertex_face ? 1 : 2;
  for (int i = 0; i < 5'000; ++i) {
    MovingPoints points = generic();
    for (auto* ends : {&points.start, &points.end}) {
      for (int k = 0; k < 4; ++k) {
        const double height = integer(2) == 0 ? 0 : uniform(0, 1);
        (*ends)[k].z() = k < upper ? height : -height;
      }
    }
    const double gap = std::pow(10.0, integer(4) - 9);
    for (int k = 0; k < upper; ++k) points.start[k].z() += gap, points.end[k].z() += gap;
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(uniform(-3, 3), point().normalized()).toRotationMatrix();
    change(points, [&](const Vector& p) { return Vector(turn * p); });
    EXPECT_FALSE(ask(GetParam(), points)) << "query " << i << ", gap " << gap;
    EXPECT_FALSE(ask(GetParam(), points, {.margin = gap / 2})) << "query " << i << ", gap " << gap;
  }
}

TEST_P(FeaturePairs, MarginAndArc) {
  int contacts = 0, free = 0;
  for (int i = 0; i < 3'000; ++i) {
    const MovingPoints points = i % 2 == 0 ? generic() : lattice(2);
    const double margin = i % 3 == 0 ? 0 : uniform(0, 0.3);
    const double arc = i % 5 == 0 ? 0 : uniform(0, 0.3);
    const std::optional<double> said = ask(GetParam(), points, {.margin = margin, .arc = arc});
    // A time that first_within() reports for the smaller margin is certainly within the larger one.
    const double fine = 0x1p-26, slack = 32 * fine;
    const auto surely = margin > slack ? first_within(GetParam(), points, margin - slack, arc, fine) : std::nullopt;
    // Where the closest features change, a fixed axis loses their motion within one cell.
    const double loss = cell * 8;
    const auto perhaps = first_within(GetParam(), points, margin + loss, arc, fine);
    if (surely) {
      ASSERT_TRUE(said) << "query " << i;
      ASSERT_LE(*said, *surely + fine) << "query " << i;
    }
    if (said) {
      ASSERT_TRUE(perhaps) << "query " << i;
      ASSERT_GE(*said, *perhaps - 2 * cell) << "query " << i;
    }
    contacts += surely.has_value();
    free += !said;
  }
  EXPECT_GT(contacts, 500);
  EXPECT_GT(free, 500);
}

TEST_P(FeaturePairs, TinyAxesDoNotShrinkTheMargin) {
  for (const double size : {1e-30, 1e-60, 1e-80, 1e-85, 1e-100, 1e-150, 1e-160, 1e-170, 1e-300}) {
    for (const double z : {0.85, 0.9, 0.99}) {
      // A tiny face below a vertex, two tiny edges, or two long edges that are almost parallel.
      const std::array<Vector, 4> tiny = {Vector(0, 0, z), Vector(size, 0, GetParam() == Features::edge_edge ? z : 0),
                                          Vector(-size, size, 0), Vector(0, -size, 0)};
      const std::array<Vector, 4> parallel = {Vector(0, 0, z), Vector(10, 10 * size, z), Vector(-10, 0, 0),
                                              Vector(1, 0, 0)};
      for (const auto& points : {tiny, GetParam() == Features::edge_edge ? parallel : tiny}) {
        MovingPoints moving = {points, points};
        for (Vector& p : moving.end) p += Vector(1, 2, 3);
        moving.end[0].x() += size;
        EXPECT_EQ(ask(GetParam(), moving, {.margin = 1}), 0.0) << size << " at " << z;
        EXPECT_FALSE(ask(GetParam(), moving, {.margin = 0.8})) << size << " at " << z;
      }
    }
  }
}

TEST_P(FeaturePairs, LatestOnlyCuts) {
  int cut = 0, kept = 0;
  for (int i = 0; i < 3'000; ++i) {
    const MovingPoints points = i % 2 == 0 ? generic() : lattice(2);
    const std::optional<double> whole = ask(GetParam(), points, {.margin = 0.1});
    const double latest = i % 3 == 0 && whole ? *whole : uniform(0, 1);
    const std::optional<double> said = ask(GetParam(), points, {.margin = 0.1, .latest = latest});
    const bool expected = whole && *whole <= latest;
    EXPECT_EQ(said.has_value(), expected);
    if (said && whole) {
      EXPECT_EQ(*said, *whole);
      EXPECT_EQ(std::round(*said / cell), *said / cell);
    }
    kept += expected;
    cut += whole && !expected;
  }
  EXPECT_GT(cut, 100);
  EXPECT_GT(kept, 100);
}

TEST_P(FeaturePairs, InvalidNumbersAreContact) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const MovingPoints apart = {{Vector(0, 0, 5), Vector(1, 0, 6), Vector(0, 1, 0), Vector(1, 1, 0)},
                              {Vector(0, 0, 5), Vector(1, 0, 6), Vector(0, 1, 0), Vector(1, 1, 0)}};
  // points[1] belongs to the face, which is therefore lowered.
  MovingPoints good = apart;
  if (GetParam() == Features::vertex_face) good.start[1].z() = good.end[1].z() = 0;
  ASSERT_FALSE(ask(GetParam(), good));
  for (const double bad : {nan, infinity, -infinity}) {
    for (int i = 0; i < 24; ++i) {
      MovingPoints points = good;
      (i < 12 ? points.start : points.end)[i / 3 % 4][i % 3] = bad;
      EXPECT_EQ(ask(GetParam(), points), 0.0) << i;
    }
    if (bad > 0 || std::isnan(bad)) {
      EXPECT_EQ(ask(GetParam(), good, {.margin = bad}), 0.0);
      EXPECT_EQ(ask(GetParam(), good, {.arc = bad}), 0.0);
    }
  }
  EXPECT_EQ(ask(GetParam(), good, {.margin = -1}), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Kinds, FeaturePairs, testing::Values(Features::vertex_face, Features::edge_edge),
                         [](const auto& i) { return i.param == Features::vertex_face ? "VertexFace" : "EdgeEdge"; });

}  // namespace
}  // namespace encage::test

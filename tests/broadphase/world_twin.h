// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Worlds of small bodies, and what they should find.

#include "tests/broadphase/sample_shapes.h"

#include <encage/world.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace encage::test {

using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

inline Pose shift(double x, double y = 0, double z = 0) {
  Pose pose = Pose::Identity();
  pose.translation() = Vector(x, y, z);
  return pose;
}

inline ShapePtr sample_shape(const std::string& name) {
  for (const Sample& s : sample_shapes(0)) {
    if (s.name == name) return make_shape(s.hierarchy);
  }
  throw std::runtime_error("no sample " + name);
}

/// A candidate without its triangles. Half-spaces come after the bodies.
struct Found {
  std::uint32_t a = 0;
  bool half_space = false;
  std::uint32_t b = 0;
  Stage stage = Stage::box;
  int level = -1;

  friend auto operator<=>(const Found&, const Found&) = default;
  friend std::ostream& operator<<(std::ostream& out, const Found& f) {
    return out << f.a << (f.half_space ? " plane " : " ") << f.b << " (stage " << static_cast<int>(f.stage)
               << ", level " << f.level << ")";
  }
};

inline Found found(const CandidatePair& pair) {
  const bool plane = pair.b == BodyId::none;
  EXPECT_NE(plane, pair.half_space == HalfSpaceId::none);
  return {static_cast<std::uint32_t>(pair.a), plane,
          plane ? static_cast<std::uint32_t>(pair.half_space) : static_cast<std::uint32_t>(pair.b), pair.verdict.stage,
          pair.verdict.level};
}

inline std::vector<Found> candidates(World& world, const CandidateOptions& options = {},
                                     CandidateStatistics* counts = nullptr) {
  std::vector<Found> all;
  const CandidateStatistics s = world.find_candidates(options, [&](const CandidatePair& pair) {
    EXPECT_FALSE(pair.verdict.separated);
    all.push_back(found(pair));
  });
  EXPECT_EQ(s.candidates, static_cast<std::int64_t>(all.size()));
  EXPECT_EQ(s.overlapping, s.refused + s.separated[0] + s.separated[1] + s.separated[2] + s.candidates);
  if (counts != nullptr) *counts = s;
  return all;
}

// ---- Against brute force -------------------------------------------------

inline bool may_pair(const BodyOptions& a, const BodyOptions& b) {
  if (a.is_static && b.is_static) return false;
  if (a.group == b.group && a.group > 0) return true;
  if (a.group == b.group && a.group < 0) return false;
  return (a.filter.category & b.filter.mask) && (b.filter.category & a.filter.mask);
}

/// A world and the same bodies in plain lists.
class Twin {
 public:
  explicit Twin(unsigned seed) : random_(seed) {
    for (const Sample& s : sample_shapes(0)) {
      add_shape(s);
      add_shape(without_cages(s));
      add_shape(without_fine(s));
    }
    for (int i = 0; i < 2; ++i) add_half_space();
  }

  void add_body() {
    Entry e;
    e.shape = random_() % shapes_.size();
    e.options.is_static = random_() % 5 == 0;
    e.options.margin = random_() % 4 == 0 ? uniform() : 0;
    if (random_() % 4 == 0) e.options.filter = {1u << random_() % 3, static_cast<std::uint32_t>(random_() % 8)};
    if (random_() % 4 == 0) e.options.group = static_cast<int>(random_() % 5) - 2;
    const Pose start = pose();
    e.motion = Motion::resting(start);
    const BodyId id = world.add_body(static_cast<ShapeId>(e.shape), start, e.options);
    ASSERT_EQ(static_cast<std::size_t>(id), bodies_.size());
    bodies_.push_back(e);
  }
  void add_half_space() {
    planes_.push_back({{Vector(uniform() - 0.5, uniform() - 0.5, 1).normalized(), -3 - uniform()},
                       {1u << random_() % 3, random_() % 2 == 0 ? ~0u : 5u}});
    world.add_half_space(planes_.back().half_space, planes_.back().filter);
  }
  void change(unsigned kind) {
    const std::size_t n = random_() % bodies_.size();
    Entry& e = bodies_[n];
    if (e.removed) return;
    const auto id = static_cast<BodyId>(n);
    if (kind == 0) {
      world.remove_body(id);
      e.removed = true;
    } else if (kind < 4 || e.options.is_static) {
      e.motion = Motion::resting(pose());
      world.set_pose(id, e.motion.start);
    } else {  // goes on from where it is, near or far
      e.motion.start = e.motion.end;
      e.motion.end.translation() += direction() * (kind < 6 ? 3 : 0.2);
      e.motion.end.linear() *= Eigen::AngleAxisd(2 * uniform(), direction().normalized()).toRotationMatrix();
      e.motion.end.linear() = Eigen::Quaterniond(e.motion.end.linear()).normalized().toRotationMatrix();
      world.set_motion(id, e.motion);
    }
  }

  /// Candidates by increasing numbers, from all pairs.
  std::vector<Found> brute_force(const PairOptions& options) const {
    std::vector<Found> all;
    const auto keep = [&](std::size_t a, bool plane, std::size_t b, const Verdict& v) {
      if (!v.separated)
        all.push_back({static_cast<std::uint32_t>(a), plane, static_cast<std::uint32_t>(b), v.stage, v.level});
    };
    for (std::size_t a = 0; a < bodies_.size(); ++a) {
      const Entry& x = bodies_[a];
      if (x.removed) continue;
      PairOptions o = options;
      for (std::size_t b = a + 1; b < bodies_.size(); ++b) {
        const Entry& y = bodies_[b];
        if (y.removed || !may_pair(x.options, y.options)) continue;
        o.margin = options.margin + x.options.margin + y.options.margin;
        keep(a, false, b, separated(*shapes_[x.shape], x.motion, *shapes_[y.shape], y.motion, o));
      }
      for (std::size_t p = 0; p < planes_.size(); ++p) {
        const Filter &f = x.options.filter, &g = planes_[p].filter;
        if (x.options.is_static || !(f.category & g.mask) || !(g.category & f.mask)) continue;
        const double margin = options.margin + x.options.margin;
        keep(a, true, p, separated(*shapes_[x.shape], x.motion, planes_[p].half_space, margin));
      }
    }
    return all;
  }

  /// Another world with the same bodies under the same numbers, that has never seen anything else.
  World fresh() const {
    World other;
    for (const ShapePtr& shape : shapes_) other.add_shape(shape);
    for (const Entry& e : bodies_) {
      const BodyId id = other.add_body(static_cast<ShapeId>(e.shape), e.motion.start, e.options);
      other.set_motion(id, e.motion);
      if (e.removed) other.remove_body(id);
    }
    for (const Plane& plane : planes_) other.add_half_space(plane.half_space, plane.filter);
    return other;
  }

  World world;

 private:
  struct Entry {
    std::size_t shape = 0;
    BodyOptions options;
    Motion motion;
    bool removed = false;
  };
  struct Plane {
    HalfSpace half_space;
    Filter filter;
  };
  double uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  int integer() { return static_cast<int>(random_() % 7) - 3; }
  Vector direction() { return Vector(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5) * 2; }
  Pose pose() {
    Pose p = Pose::Identity();
    if (random_() % 3 == 0) {  // faces that touch
      p.translation() = Vector(integer(), integer(), integer());
    } else {
      p.translation() = direction() * 6;
      p.linear() =
          Eigen::Quaterniond(uniform() + 0.01, uniform(), uniform(), uniform()).normalized().toRotationMatrix();
    }
    return p;
  }
  void add_shape(const Sample& sample) {
    shapes_.push_back(make_shape(sample.hierarchy));
    world.add_shape(shapes_.back());
  }

  std::minstd_rand random_;
  std::vector<ShapePtr> shapes_;
  std::vector<Entry> bodies_;
  std::vector<Plane> planes_;
};

}  // namespace encage::test

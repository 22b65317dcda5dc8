// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Worlds of small bodies, and their expected candidates.

#include "oracles/body.h"
#include "oracles/sample_shapes.h"

#include <encage/primitives.h>
#include <encage/rigid_pose.h>
#include <encage/world.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <ostream>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace encage::test {

using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

inline ShapePtr sample_shape(const std::string& name) {
  for (const Sample& s : sample_shapes(0)) {
    if (s.name == name) return make_shape(s.hierarchy);
  }
  throw std::runtime_error("no sample " + name);
}

/// A candidate, or a pair that no longer is one. The order is that of the visits.
struct Found {
  enum class What { ends, begins, persists };
  std::uint32_t a = 0;
  bool half_space = false;  // after the bodies
  std::uint32_t b = 0;
  What what = What::begins;
  std::uint32_t generation_a = 0, generation_b = 0;
  Stage stage = Stage::box;
  int level = -1;

  friend auto operator<=>(const Found&, const Found&) = default;
  friend std::ostream& operator<<(std::ostream& out, const Found& f) {
    return out << f.a << "/" << f.generation_a << (f.half_space ? " plane " : " ") << f.b << "/" << f.generation_b
               << (f.what == What::ends     ? " ends"
                   : f.what == What::begins ? " begins"
                                            : " persists")
               << " (stage " << static_cast<int>(f.stage) << ", level " << f.level << ")";
  }
};

inline Found found(const CandidatePair& pair) {
  const bool plane = pair.b == BodyId::none;
  EXPECT_NE(plane, pair.half_space == HalfSpaceId::none);
  Found f;
  f.a = index(pair.a);
  f.generation_a = generation(pair.a);
  f.half_space = plane;
  f.b = plane ? index(pair.half_space) : index(pair.b);
  f.generation_b = plane ? generation(pair.half_space) : generation(pair.b);
  f.what = pair.event == PairEvent::end     ? Found::What::ends
           : pair.event == PairEvent::begin ? Found::What::begins
                                            : Found::What::persists;
  if (pair.event != PairEvent::end) {
    f.stage = pair.verdict.stage;
    f.level = pair.verdict.level;
  }
  return f;
}

/// Returns candidates and ended pairs.
inline std::vector<Found> events(World& world, CandidateOptions options = {}, CandidateStatistics* counts = nullptr) {
  std::vector<Found> all;
  std::int64_t ended = 0;
  options.ended = [&](const CandidatePair& pair) {
    EXPECT_EQ(pair.event, PairEvent::end);
    EXPECT_TRUE(pair.triangles.empty());
    all.push_back(found(pair));
    ++ended;
  };
  const CandidateStatistics s = world.find_candidates(options, [&](const CandidatePair& pair) {
    EXPECT_NE(pair.event, PairEvent::end);
    EXPECT_FALSE(pair.verdict.separated);
    all.push_back(found(pair));
  });
  EXPECT_EQ(s.candidates + ended, static_cast<std::int64_t>(all.size()));
  EXPECT_EQ(s.overlapping, s.refused + s.separated[0] + s.separated[1] + s.separated[2] + s.candidates);
  EXPECT_LE(s.overlapping, s.listed);
  if (counts != nullptr) *counts = s;
  return all;
}

/// Returns the candidates among these, without their events.
inline std::vector<Found> only_candidates(std::vector<Found> all) {
  std::erase_if(all, [](const Found& f) { return f.what == Found::What::ends; });
  for (Found& f : all) f.what = Found::What::begins;
  return all;
}

inline std::vector<Found> candidates(World& world, const CandidateOptions& options = {},
                                     CandidateStatistics* counts = nullptr) {
  return only_candidates(events(world, options, counts));
}

inline std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

// ---- Against brute force -------------------------------------------------

inline bool may_pair(const BodyOptions& a, const BodyOptions& b) {
  const int still = (a.kind == BodyKind::static_ ? 1 : 0) + (b.kind == BodyKind::static_ ? 1 : 0);
  const bool dynamic = a.kind == BodyKind::dynamic || b.kind == BodyKind::dynamic;
  if (!dynamic && (still == 2 || (!a.sensor && !b.sensor))) return false;
  if (a.group == b.group && a.group > 0) return true;
  if (a.group == b.group && a.group < 0) return false;
  return (a.filter.category & b.filter.mask) && (b.filter.category & a.filter.mask);
}

/// A world, and the same bodies in plain lists.
class Twin {
 public:
  explicit Twin(unsigned seed, const WorldOptions& options = {}) : world(options), random_(seed) {
    for (const Sample& s : sample_shapes(0)) {
      add_shape(s);
      add_shape(without_cages(s));
      add_shape(without_fine(s));
    }
    for (const ShapePtr& primitive :
         {make_sphere(0.5), make_capsule(0.7, 0.25), make_box({0.5, 1, 0.25}), make_cylinder(0.5, 0.75)}) {
      add_shape(primitive);
    }
    for (int i = 0; i < 2; ++i) add_half_space();
  }

  void add_body() {
    Entry e;
    e.shape = random_() % shapes_.size();
    e.options = options();
    const Pose start = pose();
    take(e, Motion::resting(start, e.options.scale));
    e.awake = e.options.kind != BodyKind::static_;
    e.id = world.add_body(shapes_[e.shape].id, start, e.options);
    put(bodies_, e);
  }
  void add_half_space() {
    Plane p;
    p.half_space = {Vector(uniform() - 0.5, uniform() - 0.5, 1).normalized(), -3 - uniform()};
    p.filter = {1u << random_() % 3, random_() % 2 == 0 ? ~0u : 5u};
    p.id = world.add_half_space(p.half_space, p.filter);
    put(planes_, p);
  }

  enum Change : unsigned {
    remove,
    pose_last = 3,
    motion_last = 9,
    awake,
    new_options,
    shape,
    deformation,
    plane,
    last
  };

  /// Changes some property of a body.
  void change(unsigned kind) {
    Entry& e = bodies_[random_() % bodies_.size()];
    if (e.removed) return;
    if (kind == Change::awake) {
      if (e.options.kind != BodyKind::static_) e.awake = !e.awake;
      return world.set_awake(e.id, e.awake);
    }
    if (kind == Change::plane) return change_plane();
    const Entry before = e;
    if (kind == Change::remove) {
      world.remove_body(e.id);
      e.removed = true;
    } else if (kind == Change::new_options) {
      const bool was_static = e.options.kind == BodyKind::static_;
      BodyOptions changed = options();
      if (!e.motion.at_rest() && changed.kind == BodyKind::static_) changed.kind = BodyKind::kinematic;
      e.options = changed;
      e.motion.scale = e.given.scale = changed.scale;
      if (was_static || changed.kind == BodyKind::static_) e.awake = changed.kind != BodyKind::static_;
      world.set_options(e.id, changed);
    } else if (kind == Change::shape) {
      e.shape = random_() % shapes_.size();
      world.set_shape(e.id, shapes_[e.shape].id);
    } else if (kind == Change::deformation) {
      e.deformation = uniform();
      world.set_deformation(e.id, e.deformation);
    } else if (kind <= Change::pose_last || e.options.kind == BodyKind::static_) {
      take(e, Motion::resting(pose(), e.options.scale));
      world.set_pose(e.id, e.given.start);
    } else {  // continues from its present position, near or far
      Motion motion = e.motion;
      motion.start = motion.end;
      motion.end.translation() += direction() * (kind < 6 ? 3 : 0.2);
      motion.end.linear() *= Eigen::AngleAxisd(2 * uniform(), direction().normalized()).toRotationMatrix();
      motion.end.linear() = Eigen::Quaterniond(motion.end.linear()).normalized().toRotationMatrix();
      spoil(motion.end);
      take(e, motion);
      world.set_motion(e.id, e.given);
    }
    e.changed = e.changed || e.shape != before.shape || e.deformation != before.deformation ||
                e.deviation != before.deviation || e.options != before.options ||
                e.motion.start.matrix() != before.motion.start.matrix() ||
                e.motion.end.matrix() != before.motion.end.matrix();
  }

  /// Returns the expected results of the next search, in order, from all pairs. The search must follow, since the call
  /// updates the twin's state.
  std::vector<Found> brute_force(const PairOptions& asked) {
    std::vector<Found> all;
    std::set<Found> now;
    left_out_ = 0;
    if (asked.margin > least_margin_) {
      for (Entry& e : bodies_) e.changed = true;
      least_margin_ = asked.margin;
    }
    least_margin_ = std::min(least_margin_, asked.margin);
    const auto look = [&](const Entry& x, const auto& y, bool allowed, auto&& verdict) {
      Found f = named(x, y);
      const bool known = candidates_.contains(f);
      if (!is_active(x) && !is_active(y)) {
        if (known) now.insert(f), ++left_out_;
        return;
      }
      const Verdict v = allowed ? verdict() : Verdict{.separated = true};
      if (v.separated) return;
      now.insert(f);
      f.what = known ? Found::What::persists : Found::What::begins;
      f.stage = v.stage;
      f.level = v.level;
      all.push_back(f);
    };
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Entry& x = bodies_[i];
      if (x.removed) continue;
      for (std::size_t j = i + 1; j < bodies_.size(); ++j) {
        const Entry& y = bodies_[j];
        if (y.removed) continue;
        look(x, y, may_pair(x.options, y.options), [&] {
          PairOptions o = asked;
          o.margin += margin(x) + margin(y);
          return separated(*shapes_[x.shape].shape, x.motion, *shapes_[y.shape].shape, y.motion, o);
        });
      }
      for (const Plane& p : planes_) {
        const Filter &f = x.options.filter, &g = p.filter;
        const bool meets =
            x.options.kind == BodyKind::dynamic || (x.options.kind == BodyKind::kinematic && x.options.sensor);
        const bool allowed = meets && (f.category & g.mask) != 0 && (g.category & f.mask) != 0;
        if (p.removed) continue;
        look(x, p, allowed,
             [&] { return separated(*shapes_[x.shape].shape, x.motion, p.half_space, asked.margin + margin(x)); });
      }
    }
    for (Found f : candidates_) {
      if (now.contains(f)) continue;
      f.what = Found::What::ends;
      all.push_back(f);
    }
    candidates_ = now;
    for (Entry& e : bodies_) e.changed = false;
    for (Plane& p : planes_) p.changed = false;
    std::sort(all.begin(), all.end());
    return all;
  }

  /// Number of pairs that the last search left out although they are candidates.
  int left_out() const { return left_out_; }

  /// Returns another world with the same bodies under the same ids, all awake, without any history.
  World fresh() const {
    World other(world.options());
    for (const SharedShape& s : shapes_) other.add_shape(s.shape, s.margin);
    for (const Entry& e : bodies_) {
      const auto add = [&] { return other.add_body(shapes_[e.shape].id, e.given.start, e.options); };
      BodyId id = add();
      while (id != e.id) {
        other.remove_body(id);
        id = add();
      }
      other.set_motion(id, e.given);
      other.set_deformation(id, e.deformation);
    }
    for (const Entry& e : bodies_) {
      if (e.removed) other.remove_body(e.id);
    }
    for (const Plane& p : planes_) {
      HalfSpaceId id = other.add_half_space(p.half_space, p.filter);
      while (id != p.id) {
        other.remove_half_space(id);
        id = other.add_half_space(p.half_space, p.filter);
      }
    }
    for (const Plane& p : planes_) {
      if (p.removed) other.remove_half_space(p.id);
    }
    return other;
  }

  World world;

 private:
  struct SharedShape {
    ShapePtr shape;
    double margin = 0;
    ShapeId id{};
  };
  struct Entry {
    BodyId id{};
    std::size_t shape = 0;
    BodyOptions options;
    Motion given, motion;  // motion: as corrected
    double deviation = 0;
    double deformation = 0;
    bool awake = true, changed = true, removed = false;
  };
  struct Plane {
    HalfSpaceId id{};
    HalfSpace half_space;
    Filter filter;
    bool changed = true, removed = false;
  };

  static bool is_active(const Entry& e) { return e.awake || e.changed; }
  static bool is_active(const Plane& p) { return p.changed; }
  template <class Other>
  static Found named(const Entry& x, const Other& y) {
    Found f;
    f.a = index(x.id);
    f.half_space = std::is_same_v<Other, Plane>;
    f.b = index(y.id);
    f.generation_a = generation(x.id);
    f.generation_b = generation(y.id);
    return f;
  }
  /// Stores an object at its index.
  template <class T>
  static void put(std::vector<T>& all, const T& one) {
    const std::size_t i = index(one.id);
    ASSERT_LE(i, all.size());
    if (i == all.size()) return all.push_back(one);
    ASSERT_TRUE(all[i].removed);
    ASSERT_EQ(generation(one.id), generation(all[i].id) + 1);
    all[i] = one;
  }
  double margin(const Entry& e) const {
    const SharedShape& shared = shapes_[e.shape];
    double sum = e.options.margin + shared.margin + e.deformation;
    sum += correction_margin(*shared.shape, e.deviation, e.options.scale);
    if (world.options().arcs) sum += arc_margin(*shared.shape, e.motion, e.options.pivot);
    return sum;
  }

  /// Rounds some rotations to float, where the world accepts that.
  void spoil(Pose& pose) {
    if (world.options().pose_tolerance == 0 || random_() % 2 == 0) return;
    pose.linear() = pose.linear().cast<float>().cast<double>().eval();
  }
  static void take(Entry& e, const Motion& given) {
    e.given = e.motion = given;
    e.deviation = 0;
    for (Pose* pose : {&e.motion.start, &e.motion.end}) {
      if (is_usable(Motion::resting(*pose))) continue;
      const RigidPose rigid = nearest_rigid(pose->matrix());
      *pose = rigid.pose;
      e.deviation = std::max(e.deviation, rigid.deviation);
    }
  }

  BodyOptions options() {
    BodyOptions o;
    const auto kind = random_() % 6;
    o.kind = kind == 0 ? BodyKind::static_ : kind == 1 ? BodyKind::kinematic : BodyKind::dynamic;
    o.margin = random_() % 4 == 0 ? uniform() : 0;
    if (random_() % 4 == 0) o.scale = 0.5 + uniform();
    if (random_() % 4 == 0) o.filter = {1u << random_() % 3, static_cast<std::uint32_t>(random_() % 8)};
    if (random_() % 4 == 0) o.group = static_cast<int>(random_() % 5) - 2;
    o.sensor = random_() % 4 == 0;
    if (random_() % 4 == 0) o.pivot = direction();
    return o;
  }
  void change_plane() {
    Plane& p = planes_[random_() % planes_.size()];
    if (p.removed) return;
    world.remove_half_space(p.id);
    p.removed = true;
    if (random_() % 2 == 0) add_half_space();
  }
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
    spoil(p);
    return p;
  }
  void add_shape(const Sample& sample) { add_shape(make_shape(sample.hierarchy)); }
  void add_shape(const ShapePtr& made) {
    SharedShape s{.shape = made, .margin = shapes_.size() % 5 == 0 ? 0.1 : 0};
    s.id = world.add_shape(s.shape, s.margin);
    shapes_.push_back(s);
  }

  std::minstd_rand random_;
  std::vector<SharedShape> shapes_;
  std::vector<Entry> bodies_;
  std::vector<Plane> planes_;
  int left_out_ = 0;
  double least_margin_ = 1e9;   // at which pairs have been left out
  std::set<Found> candidates_;  // candidates of the previous search, and those that have been left out since
};

}  // namespace encage::test

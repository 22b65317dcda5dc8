// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/shape/compound.h"

#include "oracles/body.h"
#include "oracles/count_allocations.h"
#include "oracles/exact_pair.h"
#include "oracles/meshes.h"
#include "oracles/twin_bodies.h"

#include <encage/contact.h>
#include <encage/error.h>
#include <encage/separated.h>
#include <encage/world.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace encage::test {
namespace {

using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;
using LongVector = Eigen::Matrix<long double, 3, 1>;

/// A compound and its parts.
struct Group {
  std::vector<const Body*> bodies;
  std::vector<CompoundPart> parts;
  ShapePtr shape;

  Motion motion(std::size_t i, const Motion& whole) const {
    const auto placed = [&](const Pose& pose) {
      Pose result = pose * shift(0, 0, 0);
      result.linear() = pose.linear() * parts[i].pose.linear();
      result.translation() = pose * (whole.scale * parts[i].pose.translation());
      return result;
    };
    return {placed(whole.start), placed(whole.end), whole.scale * parts[i].scale};
  }
};

class Groups {
 public:
  explicit Groups(std::uint64_t seed) : random(seed), bodies_(twin_bodies()) {
    std::erase_if(bodies_, [](const Body& body) { return !body.has_fine() || !body.solid() || body.diagonal() > 20; });
  }

  Group make(unsigned most) {
    Group group;
    for (unsigned n = 1 + random.below(most); n > 0; --n) {
      const Body& body = random.one_of(bodies_);
      Pose pose = Pose::Identity();
      pose.linear() = Eigen::AngleAxisd(random.uniform(0, 3), random.direction()).toRotationMatrix();
      pose.translation() = random.point(3) - pose.linear() * (body.scale * body.origin());
      group.bodies.push_back(&body);
      group.parts.push_back({body.shape, pose, body.scale});
    }
    group.shape = make_compound(group.parts);
    return group;
  }

  Motion motion(bool rest) {
    Pose pose = Pose::Identity();
    pose.linear() = Eigen::AngleAxisd(random.uniform(0, 3), random.direction()).toRotationMatrix();
    pose.translation() = random.point(4);
    Motion motion = Motion::resting(pose, random.coin() ? 1 : random.uniform(0.3, 2));
    if (rest) return motion;
    motion.end.linear() =
        Eigen::AngleAxisd(random.uniform(0, 0.4), random.direction()).toRotationMatrix() * pose.linear();
    motion.end.translation() += random.point(1);
    return motion;
  }

  TwinRandom random;

 private:
  std::vector<Body> bodies_;
};

TEST(Compounds, PartsAreWhereTheirPlacesSay) {
  Groups groups(1);
  for (int i = 0; i < 200; ++i) {
    const Group group = groups.make(3);
    Motion motion = groups.motion(true);
    motion.start.translation() *= i % 2 == 0 ? 1 : 1e6;
    for (std::size_t p = 0; p < group.parts.size(); ++p) {
      const MovingPart part = moving_part(group.shape->compound(), p, motion);
      const CompoundPart& given = group.parts[p];
      for (int k = 0; k < 4; ++k) {
        const Vector x = group.bodies[p]->origin() + groups.random.point(1);
        const LongVector inner =
            given.pose.linear().cast<long double>() * (static_cast<long double>(given.scale) * x.cast<long double>()) +
            given.pose.translation().cast<long double>();
        const LongVector exact =
            motion.start.linear().cast<long double>() * (static_cast<long double>(motion.scale) * inner) +
            motion.start.translation().cast<long double>();
        const LongVector computed = part.motion.start.linear().cast<long double>() *
                                        (static_cast<long double>(part.motion.scale) * x.cast<long double>()) +
                                    part.motion.start.translation().cast<long double>();
        EXPECT_LE((exact - computed).norm(), part.slack);
      }
    }
  }
}

TEST(Compounds, NoContactOfPartsIsMissed) {
  Groups groups(2);
  int rejected = 0, contacts = 0, kept = 0;
  for (int i = 0; i < 300; ++i) {
    const Group a = groups.make(6), b = groups.make(6);
    const Motion motion_a = groups.motion(true), motion_b = groups.motion(true);
    const double margin = groups.random.coin() ? 0 : groups.random.uniform(0, 0.5);
    const bool apart =
        separated(*a.shape, motion_a, *b.shape, motion_b, {.margin = margin, .cages = CageUse::always}).separated;
    // The exact oracle does not model the rounding of the parts' positions, which is below 1e-12.
    const auto meet = [&](double distance) {
      for (std::size_t p = 0; p < a.parts.size(); ++p) {
        const Motion of_a = a.motion(p, motion_a);
        const ExactBody exact_a(a.bodies[p]->origin(), a.bodies[p]->sample.source, of_a.start, of_a.scale);
        for (std::size_t q = 0; q < b.parts.size(); ++q) {
          const Motion of_b = b.motion(q, motion_b);
          const ExactBody exact_b(b.bodies[q]->origin(), b.bodies[q]->sample.source, of_b.start, of_b.scale);
          if (surfaces_meet(exact_a, exact_b, distance) || holds_component(exact_a, exact_b) ||
              holds_component(exact_b, exact_a)) {
            return true;
          }
        }
      }
      return false;
    };
    if (apart) {
      ++rejected;
      EXPECT_FALSE(meet(margin)) << i;
    } else if (meet(margin)) {
      ++contacts;
    } else if (!meet(margin + 0.05)) {
      ++kept;
    }
  }
  EXPECT_GT(rejected, 40);
  EXPECT_GT(contacts, 40);
  EXPECT_EQ(kept, 0);
}

/// The answer to every query about a compound is the union of the answers about its parts.
TEST(Compounds, CandidatesAndContactsAreThoseOfTheParts) {
  Groups groups(3);
  int candidates = 0, contacts = 0;
  for (int i = 0; i < 120; ++i) {
    const Group a = groups.make(5), b = groups.make(40);
    const Motion motion_a = groups.motion(i % 2 == 0), motion_b = groups.motion(i % 3 == 0);
    const double margin = groups.random.coin() ? 0 : groups.random.uniform(0, 0.1);
    std::set<std::pair<std::int32_t, std::int32_t>> found, expected;
    for_each_triangle_pair(*a.shape, motion_a, *b.shape, motion_b, margin, [&](TrianglePair pair) {
      EXPECT_TRUE(found.emplace(pair.a, pair.b).second);
      return true;
    });
    std::optional<Contact> first;
    PairContact all(*a.shape, motion_a, *b.shape, motion_b, {.margin = margin});
    for (std::size_t p = 0; p < a.parts.size(); ++p) {
      const MovingPart part_a = moving_part(a.shape->compound(), p, motion_a);
      for (std::size_t q = 0; q < b.parts.size(); ++q) {
        const MovingPart part_b = moving_part(b.shape->compound(), q, motion_b);
        const double part_margin = margin + part_a.slack + part_b.slack;
        for_each_triangle_pair(*part_a.shape, part_a.motion, *part_b.shape, part_b.motion, part_margin,
                               [&](TrianglePair t) {
                                 expected.emplace(part_a.first_triangle + t.a, part_b.first_triangle + t.b);
                                 all.test(part_a.first_triangle + t.a, part_b.first_triangle + t.b);
                                 return true;
                               });
      }
    }
    EXPECT_EQ(found, expected);
    candidates += static_cast<int>(found.size());
    for (const auto& [ta, tb] : found) {
      const PartTriangle part = part_triangle(*a.shape, ta);
      EXPECT_EQ(ta, moving_part(a.shape->compound(), static_cast<std::size_t>(part.part), motion_a).first_triangle +
                        part.triangle);
    }
    first = first_contact(*a.shape, motion_a, *b.shape, motion_b, {.margin = margin});
    ASSERT_EQ(first.has_value(), all.first().has_value());
    if (!first) continue;
    ++contacts;
    EXPECT_EQ(first->time, all.first()->time);
    EXPECT_EQ(first->vertices, all.first()->vertices);
    EXPECT_EQ(first->point, all.first()->point);
    EXPECT_EQ(first->normal, all.first()->normal);
  }
  EXPECT_GT(candidates, 1000);
  EXPECT_GT(contacts, 20);
}

TEST(Compounds, BoxesHoldEveryPart) {
  Groups groups(4);
  for (int i = 0; i < 60; ++i) {
    const Group group = groups.make(i % 2 == 0 ? 5 : 60);
    const Motion motion = groups.motion(false);
    const Eigen::AlignedBox3d box = world_box(*group.shape, motion);
    const double arc = arc_margin(*group.shape, motion);
    for (std::size_t p = 0; p < group.parts.size(); ++p) {
      const Motion part = group.motion(p, motion);
      const TriangleMesh& mesh = group.bodies[p]->sample.source;
      for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v) {
        const Vector x = group.bodies[p]->origin() + mesh.vertex(v);
        EXPECT_TRUE(box.contains(Vector(part.start * (part.scale * x))));
        EXPECT_TRUE(box.contains(Vector(part.end * (part.scale * x))));
      }
      const Vector pivot = group.parts[p].pose.inverse().translation() / group.parts[p].scale;
      EXPECT_GE(arc * (1 + 1e-9), arc_margin(*group.bodies[p]->shape, part, pivot));
    }
    EXPECT_GT(arc, 0);
  }
}

TEST(Compounds, AnswerLikeTheirOnePart) {
  const ShapePtr cube = make_shape(shapes::cube(1));
  const CompoundPart one[] = {{cube, shift(0.5, 0, 0), 2}};
  const ShapePtr group = make_compound(one);
  const Motion rest = Motion::resting(Pose::Identity()), moved = Motion::resting(shift(0.5, 0, 0), 2);
  EXPECT_EQ(part_count(*group), 1);
  for (const double x : {2.0, 3.4, 3.6, 9.0}) {
    const Motion other = Motion::resting(shift(x, 0, 0));
    EXPECT_EQ(separated(*group, rest, *cube, other).separated, separated(*cube, moved, *cube, other).separated) << x;
    const HalfSpace wall{-Vector::UnitX(), -x};
    EXPECT_EQ(separated(*group, rest, wall).separated, separated(*cube, moved, wall).separated) << x;
    const auto contact = first_contact(*group, rest, wall), same = first_contact(*cube, moved, wall);
    ASSERT_EQ(contact.has_value(), same.has_value());
    if (contact) {
      EXPECT_EQ(contact->point, same->point);
    }
  }
  const Motion turn{Pose::Identity(), Pose(Eigen::AngleAxisd(0.3, Vector::UnitZ()))};
  EXPECT_NEAR(arc_margin(*group, turn),
              arc_margin(*cube, {turn.start * shift(0.5, 0, 0), turn.end * shift(0.5, 0, 0), 2}, Vector(-0.25, 0, 0)),
              1e-9);
}

TEST(Compounds, AreTakenApartWhenPutIntoOthers) {
  const ShapePtr cube = make_shape(shapes::cube(1));
  const CompoundPart two[] = {{cube, shift(-5, 0, 0)}, {cube, shift(5, 0, 0), 0.5}};
  const ShapePtr pair = make_compound(two);
  const CompoundPart nested[] = {{cube}, {pair, shift(0, 10, 0), 2}};
  const ShapePtr group = make_compound(nested);
  EXPECT_EQ(part_count(*group), 3);
  const auto meets = [&](double x, double y) {
    return !separated(*group, Motion::resting(Pose::Identity()), *cube, Motion::resting(shift(x, y, 0), 0.01))
                .separated;
  };
  EXPECT_TRUE(meets(0, 0));
  EXPECT_TRUE(meets(-11.9, 10));
  EXPECT_FALSE(meets(-12.1, 10));
  EXPECT_TRUE(meets(9.1, 10.9));
  EXPECT_FALSE(meets(9.1, 11.1));
}

TEST(Compounds, PlacesThatCancelInNestsCountInFull) {
  const ShapePtr cube = make_shape(shapes::cube(1));
  Pose there = Pose::Identity(), back = Pose::Identity();
  there.linear() = Eigen::AngleAxisd(0.7, Vector(1, 2, 3).normalized()).toRotationMatrix();
  there.translation() = Vector(1e9, -3e8, 7e8);
  back.linear() = there.linear().transpose();
  back.translation() = -(back.linear() * there.translation());
  const CompoundPart inner[] = {{cube, there}};
  const CompoundPart outer[] = {{make_compound(inner), back}};
  const ShapePtr nest = make_compound(outer);
  const MovingPart part = moving_part(nest->compound(), 0, Motion::resting(Pose::Identity()));
  double farthest = 0;
  for (const Vector& corner : {Vector(1, 1, 1), Vector(-1, 1, -1), Vector(1, -1, -1), Vector(-1, -1, 1)}) {
    const LongVector moved =
        there.linear().cast<long double>() * corner.cast<long double>() + there.translation().cast<long double>();
    const LongVector exact = back.linear().cast<long double>() * moved + back.translation().cast<long double>();
    const LongVector computed = part.motion.start.linear().cast<long double>() * corner.cast<long double>() +
                                part.motion.start.translation().cast<long double>();
    farthest = std::max(farthest, static_cast<double>((exact - computed).norm()));
    EXPECT_TRUE(world_box(*nest, Motion::resting(Pose::Identity())).contains(exact.cast<double>()));
  }
  // The size of the resulting position does not account for this error.
  EXPECT_GT(farthest, 1e-9);
  EXPECT_LE(farthest, part.slack);

  // The pivot is the computed position of the part; the arc is that of its farthest corner.
  Motion turn;
  turn.end.linear() = Eigen::AngleAxisd(1, Vector::UnitZ()).toRotationMatrix();
  const Vector pivot = part.motion.start.translation();
  double radius = 0;
  for (int i = 0; i < 8; ++i) {
    const LongVector corner(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    const LongVector moved = there.linear().cast<long double>() * corner + there.translation().cast<long double>();
    const LongVector exact = back.linear().cast<long double>() * moved + back.translation().cast<long double>();
    radius = std::max(radius, static_cast<double>((exact - pivot.cast<long double>()).norm()));
  }
  EXPECT_GT(radius, std::sqrt(3.0) * (1 + 1e-8));
  EXPECT_GE(arc_margin(*nest, turn, pivot), radius * (1 - std::cos(0.5)));
}

TEST(Compounds, NestsThatLeaveTheRangeOfNumbersAreRefused) {
  const ShapePtr cube = make_shape(shapes::cube(0.5));
  const auto in = [](const ShapePtr& shape, double scale, const Pose& pose = Pose::Identity()) {
    const CompoundPart parts[] = {{shape, pose, scale}};
    return make_compound(parts);
  };
  const auto message = [](auto&& make) -> std::string {
    try {
      make();
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  // Without the check, the scale would collapse: 1e-322 has two digits, 1e-350 none.
  const ShapePtr tiny = in(cube, 1e-50);
  EXPECT_EQ(message([&] { in(tiny, 1e-50); }), "part 0: its part 0: the scale is 1e-100, not between 1e-50 and 1e50");
  EXPECT_EQ(message([&] { in(in(cube, 1e50), 1e50); }),
            "part 0: its part 0: the scale is 1e+100, not between 1e-50 and 1e50");
  EXPECT_EQ(message([&] { in(tiny, 1e50); }), "");
  CageHierarchy far;
  far.fine = shapes::cube(0.5);
  far.origin = Vector(1e150, 1e150, 0);
  const CompoundPart lost[] = {{cube}, {make_shape(far)}};
  EXPECT_EQ(message([&] { make_compound(lost); }),
            "part 1: it reaches 1.41421356237e+150 from the origin, farther than 1e150");
  EXPECT_EQ(message([&] { in(in(cube, 1, shift(1e140, 0, 0)), 1e20); }),
            "part 0: its part 0: the pose in the whole is not finite, beyond 1e150 or farther than 1e-10 from rigid");
  // The departures of poses from rigid add up.
  Pose larger = Pose::Identity();
  larger.linear() *= 1 + 2e-13;
  ShapePtr nest = cube;
  std::string refused;
  int depth = 0;
  for (; refused.empty() && depth < 400; ++depth) refused = message([&] { nest = in(nest, 1, larger); });
  EXPECT_EQ(refused,
            "part 0: its part 0: the pose in the whole is not finite, beyond 1e150 or farther than 1e-10 from rigid");
  EXPECT_NEAR(depth, 1e-10 / (std::sqrt(3.0) * 4e-13), 2);  // in the Frobenius norm
}

TEST(Compounds, LiveInAWorldAndAllocateNothing) {
  const ShapePtr cube = make_shape(shapes::cube(0.5));
  std::vector<CompoundPart> ring;
  for (int i = 0; i < 100; ++i) {
    Pose pose(Eigen::AngleAxisd(0.0628 * i, Vector::UnitZ()));
    pose.translation() = pose.linear() * Vector(20, 0, 0);
    ring.push_back({cube, pose});
  }
  World world;
  const BodyId a = world.add_body(world.add_shape(make_compound(ring)), Pose::Identity());
  const BodyId b = world.add_body(world.add_shape(cube), shift(0, 0, 0));
  CandidateOptions options;
  options.triangles = true;
  std::size_t triangles = 0;
  const auto count = [&] {
    triangles = 0;
    return world.find_candidates(options, [&](const CandidatePair& pair) { triangles += pair.triangles.size(); })
        .candidates;
  };
  EXPECT_EQ(count(), 0);
  world.set_pose(b, shift(20.2, 0, 0));
  EXPECT_EQ(count(), 1);
  EXPECT_GT(triangles, 0U);
  world.set_pose(a, shift(0, 0, 2));
  EXPECT_EQ(count(), 0);
  world.set_pose(a, Pose::Identity());
  const long before = allocations;
  count();
  EXPECT_EQ(allocations, before);
}

TEST(Compounds, BadInputNamesThePart) {
  const ShapePtr cube = make_shape(shapes::cube(0.5));
  const auto message = [&](const CompoundPart& bad) -> std::string {
    const CompoundPart parts[] = {{cube}, bad};
    try {
      make_compound(parts);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message({}), "part 1: no shape");
  EXPECT_EQ(message({cube, Pose::Identity(), -2}), "part 1: the scale is -2, not between 1e-50 and 1e50");
  Pose sheared = Pose::Identity();
  sheared.linear()(0, 1) = 1e-10;
  EXPECT_EQ(message({cube, sheared}), "part 1: the pose is not finite, beyond 1e150 or farther than 1e-12 from rigid");
  Pose mirrored = Pose::Identity();
  mirrored.linear()(0, 0) = -1;
  EXPECT_EQ(message({cube, mirrored}), "part 1: the pose mirrors it");
  EXPECT_THROW(make_compound({}), Error);
}

}  // namespace
}  // namespace encage::test

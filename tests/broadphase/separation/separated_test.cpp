// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/body.h"
#include "oracles/count_allocations.h"
#include "oracles/exact_pair.h"
#include "oracles/meshes.h"
#include "tests/broadphase/separation/ask_pairs.h"

#include <encage/separated.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace encage::test {
namespace {

using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

Verdict ask(const Body& a, const Pose& pose_a, const Body& b, const Pose& pose_b, double margin = 0) {
  return separated(*a.shape, Motion::resting(pose_a), *b.shape, Motion::resting(pose_b),
                   {.margin = margin, .cages = CageUse::always});
}

// ---- Against brute force -------------------------------------------------

constexpr int resting_shards = 4;

class SeparatedResting : public testing::TestWithParam<int> {};

TEST_P(SeparatedResting, NeverMissesAContactOfBruteForce) {
  const twins::Tally figures = ask_pairs("resting", twins::resting_pairs(), 44'000, resting_shards, GetParam());
  // The test is significant only if both answers are common.
  EXPECT_GT(figures.rejected, figures.pairs / 5);
  EXPECT_LE(figures.far_kept, figures.far / 100);
  // With fewer samples the fractions are left to chance (sanitizers run few pairs).
  if (figures.sampled < 50) return;
  EXPECT_GT(figures.touching + figures.within_margin, figures.sampled / 5);
  EXPECT_GT(figures.far, figures.sampled / 20);
}

INSTANTIATE_TEST_SUITE_P(Shards, SeparatedResting, testing::Range(0, resting_shards));

TEST(Separated, SampleCagesNest) {
  std::vector<Sample> all = sample_shapes(1e-4);
  for (const auto& more : {large_sample_shapes(1e-4), flat_shapes(1e-4), large_flat_shapes(1e-4), thin_shapes(1e-4)}) {
    all.insert(all.end(), more.begin(), more.end());
  }
  for (const Sample& s : all) {
    const TriangleMesh* inner = &s.source;
    for (const CageLevel& level : s.hierarchy.levels) {
      EXPECT_GT(signed_volume(level.mesh), 0) << s.name;
      const ExactBody exact_inner(Vector::Zero(), *inner, Pose::Identity());
      const ExactBody cage(Vector::Zero(), level.mesh, Pose::Identity());
      EXPECT_FALSE(surfaces_meet(exact_inner, cage, 0)) << s.name;
      for (std::int64_t v = 0; v < inner->vertices.rows(); ++v) {
        const Vector p = inner->vertices.row(v).transpose();
        EXPECT_EQ(winding_number(cage, p), 1) << s.name;
      }
      // The second condition: no cavity of the cage lies in the solid.
      if (s.hierarchy.solid == Solid::closed) {
        EXPECT_FALSE(holds_component(exact_inner, cage)) << s.name;
      }
      inner = &level.mesh;
    }
  }
}

// ---- Known answers -------------------------------------------------------

TEST(Separated, NamesTheStageOfTheProof) {
  const std::vector<Body> all = sample_bodies();
  const Body& box = find(all, "box");  // half 1, cages 1.05 and 1.3
  const auto at = [&](double y) { return ask(box, shift(0, 0, 0), box, shift(1.9, y, 0)); };
  // After a turn of 45 degrees about z, faces point along (1,1,0) and world boxes overlap up to a larger distance.
  const auto turned = [&](double distance) {
    Pose a = Pose::Identity(), b = Pose::Identity();
    a.linear() = b.linear() = Eigen::AngleAxisd(std::atan(1.0), Vector::UnitZ()).toRotationMatrix();
    b.translation() = Vector(1, 1, 0).normalized() * distance;
    return ask(box, a, box, b);
  };
  EXPECT_EQ(at(2.01).stage, Stage::box);
  EXPECT_TRUE(at(2.01).separated);
  EXPECT_EQ(at(2.01).level, -1);
  EXPECT_EQ(turned(2.7).stage, Stage::cage);
  EXPECT_EQ(turned(2.7).level, 1);
  EXPECT_EQ(turned(2.2).level, 0);
  EXPECT_EQ(turned(2.05).stage, Stage::fine);
  EXPECT_TRUE(turned(2.05).separated);
  EXPECT_EQ(turned(1.95).stage, Stage::fine);
  EXPECT_FALSE(turned(1.95).separated);
}

TEST(Separated, AsksCagesOnlyInFrontOfNothingBetter) {
  const std::vector<Body> all = sample_bodies();
  const Body& box = find(all, "box");
  Pose a = Pose::Identity(), b = Pose::Identity();
  a.linear() = b.linear() = Eigen::AngleAxisd(std::atan(1.0), Vector::UnitZ()).toRotationMatrix();
  b.translation() = Vector(1, 1, 0).normalized() * 2.7;  // cages 1.05 and 1.3 would separate
  const auto verdict = [&](const Body& x, const PairOptions& options) {
    return separated(*x.shape, Motion::resting(a), *x.shape, Motion::resting(b), options);
  };
  for (const CageUse use : {CageUse::automatic, CageUse::never}) {
    EXPECT_EQ(verdict(box, {.cages = use}).stage, Stage::fine);
    EXPECT_TRUE(verdict(box, {.cages = use}).separated);
  }
  EXPECT_EQ(verdict(box, {.cages = CageUse::always}).stage, Stage::cage);
  EXPECT_EQ(verdict(box, {.fine = false}).stage, Stage::cage);
  EXPECT_EQ(verdict(Body(without_fine(box.sample)), {}).stage, Stage::cage);
  EXPECT_FALSE(verdict(box, {.cages = CageUse::never, .fine = false}).separated);
}

TEST(Separated, BodyInsideAnother) {
  const std::vector<Body> all = sample_bodies();
  const Body small(scaled(find(all, "star").sample, -4));
  for (const char* host : {"box", "l", "tetrahedron"}) {
    const Pose inside = shift(-0.6, -0.6, host == std::string("tetrahedron") ? 1 : 0.2);
    const Pose centre = host == std::string("tetrahedron") ? shift(0, 0, 0) : inside;
    EXPECT_FALSE(ask(find(all, host), Pose::Identity(), small, centre).separated) << host;
    EXPECT_FALSE(ask(small, centre, find(all, host), Pose::Identity()).separated) << host;
    const Body bare(without_cages(find(all, host).sample)), caged(without_fine(find(all, host).sample));
    EXPECT_FALSE(ask(bare, Pose::Identity(), small, centre).separated) << host;
    EXPECT_FALSE(ask(caged, Pose::Identity(), small, centre).separated) << host;
  }
}

TEST(Separated, BodyInACavity) {
  const std::vector<Body> all = sample_bodies();
  const Body& shell = find(all, "shell");  // inner half 0.8; 0.77 and 0.6 in the cages
  const Body small(scaled(find(all, "star").sample, -2));
  const Verdict verdict = ask(shell, Pose::Identity(), small, shift(0.1, 0, 0));
  EXPECT_TRUE(verdict.separated);
  EXPECT_EQ(verdict.stage, Stage::cage);
  EXPECT_EQ(verdict.level, 1);
  EXPECT_TRUE(ask(Body(without_cages(shell.sample)), Pose::Identity(), small, shift(0.1, 0, 0)).separated);
  EXPECT_FALSE(ask(shell, Pose::Identity(), small, shift(0.9, 0, 0)).separated);
  EXPECT_FALSE(ask(shell, Pose::Identity(), small, shift(0.7, 0, 0)).separated);
}

/// One box about the origin, the other far away.
Body two_parts() {
  Sample sample;
  sample.source = shapes::joined(shapes::box(Vector(-40, 0, 0), Vector(-39, 1, 1)), shapes::cube(0.25));
  sample.hierarchy.fine = sample.source;
  sample.hierarchy.diagonal = bounds(sample.source).diagonal().norm();
  return Body(sample);
}

TEST(Separated, OnePartInsideIsEnough) {
  const std::vector<Body> all = sample_bodies();
  const Body pair = two_parts();
  const Body box(without_cages(find(all, "box").sample));
  EXPECT_FALSE(ask(box, Pose::Identity(), pair, Pose::Identity()).separated);
  EXPECT_FALSE(ask(pair, Pose::Identity(), box, Pose::Identity()).separated);
  EXPECT_TRUE(ask(box, Pose::Identity(), pair, shift(20, 0, 0)).separated);
}

TEST(Separated, UnknownInteriorMayHoldOnePartOfTheGuest) {
  const std::vector<Body> all = sample_bodies();
  const Body pair = two_parts();
  const Body open(without_cages(find(all, "open box").sample));
  EXPECT_FALSE(ask(open, Pose::Identity(), pair, Pose::Identity()).separated);
  EXPECT_FALSE(ask(pair, Pose::Identity(), open, Pose::Identity()).separated);
  EXPECT_TRUE(ask(open, Pose::Identity(), pair, shift(20, 0, 0)).separated);
}

TEST(Separated, InsideOutAndDoubledSolidsAreSolid) {
  const std::vector<Body> all = sample_bodies();
  const Body small(scaled(find(all, "star").sample, -4));
  Sample s = without_cages(find(all, "box").sample);
  s.hierarchy.fine = shapes::flipped(s.hierarchy.fine);
  EXPECT_FALSE(ask(Body(s), Pose::Identity(), small, Pose::Identity()).separated);
  // The winding number in the inner box is 2: it is still solid, though a ray crosses the surface twice.
  s.hierarchy.fine =
      shapes::joined(s.hierarchy.fine, shapes::flipped(shapes::box(Vector::Constant(-0.5), Vector::Constant(0.5))));
  EXPECT_FALSE(ask(Body(s), Pose::Identity(), small, Pose::Identity()).separated);
}

TEST(Separated, UnknownInteriorAnswersMaybeForWhatLiesInTheBox) {
  const std::vector<Body> all = sample_bodies();
  const Body& open = find(all, "open box");
  const Body small(scaled(find(all, "star").sample, -2));
  for (const Body& host : {open, Body(without_cages(open.sample)), Body(without_fine(open.sample))}) {
    EXPECT_FALSE(ask(host, Pose::Identity(), small, Pose::Identity()).separated);
    EXPECT_FALSE(ask(small, Pose::Identity(), host, Pose::Identity()).separated);
  }
  // Without its fine mesh nothing proves that the guest sticks out, though the cages are apart.
  Pose turned = Pose::Identity();
  turned.linear() = Eigen::AngleAxisd(std::atan(1.0), Vector::UnitZ()).toRotationMatrix();
  EXPECT_TRUE(ask(open, turned, small, shift(1.3, 1.3, 0)).separated);
  EXPECT_FALSE(ask(open, turned, Body(without_fine(small.sample)), shift(1.3, 1.3, 0)).separated);
  // The guest sticks out through the opening (the lid was at z = 1) without touching.
  EXPECT_TRUE(ask(Body(without_cages(open.sample)), Pose::Identity(), small, shift(0, 0, 0.9)).separated);
  EXPECT_FALSE(ask(Body(without_cages(open.sample)), Pose::Identity(), small, shift(0, 0.9, 0)).separated);
  // The closed body contains the open one, and its interior is known.
  const Body small_open(scaled(open.sample, -3));
  EXPECT_FALSE(ask(small_open, Pose::Identity(), find(all, "box"), Pose::Identity()).separated);
}

TEST(Separated, UnknownInteriorAnswersMaybeForWhatMovesIntoIt) {
  const std::vector<Body> all = sample_bodies();
  const Body open(without_cages(find(all, "open box").sample));
  const Body small(scaled(find(all, "star").sample, -2));
  const auto drop = [&](double from, double to) {
    return separated(*open.shape, Motion::resting(Pose::Identity()), *small.shape, {shift(0, 0, from), shift(0, 0, to)})
        .separated;
  };
  // The guest passes through the opening without touching: in, out, and through until it still sticks out.
  EXPECT_FALSE(drop(3, 0));
  EXPECT_FALSE(drop(0, 3));
  EXPECT_TRUE(drop(3, 0.9));
  EXPECT_TRUE(drop(3, 1.6));
}

TEST(Separated, ClosedInNameOnlyAnswersLikeAnUnknownInterior) {
  const std::vector<Body> all = sample_bodies();
  Sample s = without_cages(find(all, "open box").sample);
  s.hierarchy.solid = Solid::closed;
  const Body small(scaled(find(all, "star").sample, -2));
  EXPECT_FALSE(ask(Body(s), Pose::Identity(), small, Pose::Identity()).separated);
  EXPECT_TRUE(ask(Body(s), Pose::Identity(), small, shift(1.2, 1.2, 0)).separated);
}

TEST(Separated, MarginIsADistanceThatMustBeExceeded) {
  for (const Body& box : {find(sample_bodies(), "box"), Body(without_cages(find(sample_bodies(), "box").sample))}) {
    Pose turned = Pose::Identity();
    turned.linear() = Eigen::AngleAxisd(0.25, Vector(1, 2, 3).normalized()).toRotationMatrix();
    const Pose b = turned * shift(2.5, 0, 0);
    EXPECT_TRUE(ask(box, turned, box, b, 0.499999999).separated);
    EXPECT_FALSE(ask(box, turned, box, b, 0.5).separated);
    EXPECT_FALSE(ask(box, turned, box, b, 0.500000001).separated);
    EXPECT_FALSE(ask(box, turned, box, b, std::numeric_limits<double>::infinity()).separated);
    EXPECT_FALSE(ask(box, turned, box, b, std::numeric_limits<double>::quiet_NaN()).separated);
    EXPECT_FALSE(ask(box, turned, box, shift(100, 0, 0), -1).separated);
    // The bodies are corner to corner: the distance counts, not the one along an axis.
    EXPECT_TRUE(ask(box, Pose::Identity(), box, shift(2.5, 2.5, 2.5), 0.866).separated);
    EXPECT_FALSE(ask(box, Pose::Identity(), box, shift(2.5, 2.5, 2.5), 0.8661).separated);
    EXPECT_TRUE(ask(box, turned, box, turned * shift(2.5, 2.5, 2.5), 0.866).separated);
    EXPECT_FALSE(ask(box, turned, box, turned * shift(2.5, 2.5, 2.5), 0.8661).separated);
  }
}

TEST(Separated, FineErrorCounts) {
  Sample s = without_cages(sample_shapes(0)[1]);
  ASSERT_EQ(s.name, "box");
  s.hierarchy.fine_error = 0.01;
  const Body box(s);
  Pose turned = Pose::Identity();
  turned.linear() = Eigen::AngleAxisd(0.7, Vector(1, 2, 3).normalized()).toRotationMatrix();
  EXPECT_TRUE(ask(box, turned, box, turned * shift(2.0201, 0, 0)).separated);
  EXPECT_FALSE(ask(box, turned, box, turned * shift(2.0199, 0, 0)).separated);
  EXPECT_FALSE(ask(box, Pose::Identity(), box, shift(2.0199, 0, 0)).separated);
}

TEST(Separated, PosesThatAreNotRigidAnswerMaybe) {
  const Body box = find(sample_bodies(), "box");
  Pose far = shift(100, 0, 0);
  EXPECT_TRUE(ask(box, Pose::Identity(), box, far).separated);
  for (const double bad :
       {1e-8, 0.5, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Pose pose = far;
    pose.linear()(0, 1) += bad;
    EXPECT_FALSE(ask(box, Pose::Identity(), box, pose).separated);
    EXPECT_FALSE(ask(box, pose, box, Pose::Identity()).separated);
  }
  far.translation().x() = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(ask(box, Pose::Identity(), box, far).separated);
  far.translation().x() = 1e200;
  EXPECT_FALSE(ask(box, Pose::Identity(), box, far).separated);
}

TEST(Separated, SaysWhereNothingWasTested) {
  const Body box = find(sample_bodies(), "box");
  const Shape& shape = *box.shape;
  const Motion rest = Motion::resting(Pose::Identity());
  const HalfSpace floor{.offset = -50};
  EXPECT_TRUE(separated(shape, rest, shape, rest).usable);  // "maybe" for a reason
  EXPECT_TRUE(separated(shape, rest, shape, Motion::resting(shift(9))).usable);
  EXPECT_TRUE(separated(shape, rest, floor).usable);
  std::vector<Motion> bad(4, Motion::resting(shift(100)));
  bad[0].end.linear() *= Eigen::DiagonalMatrix<double, 3>(1, -1, 1);
  bad[1].start.linear() = bad[1].start.linear().eval() * (1 + 1e-6);
  bad[2].scale = 0;
  bad[3].scale = -1;
  for (const Motion& motion : bad) {
    for (const Verdict& verdict :
         {separated(shape, rest, shape, motion), separated(shape, motion, shape, rest), separated(shape, motion, floor),
          separated(shape, rest, shape, motion, PairOptions{.cages = CageUse::always})}) {
      EXPECT_FALSE(verdict.separated);
      EXPECT_FALSE(verdict.usable);
    }
  }
  EXPECT_FALSE(separated(shape, rest, shape, rest, -1.0).usable);
  EXPECT_FALSE(separated(shape, rest, floor, std::numeric_limits<double>::quiet_NaN()).usable);
}

TEST(Separated, AMovingPairIsSeparatedDuringTheWholeStep) {
  const Body box = find(sample_bodies(), "box");
  const Motion still = Motion::resting(Pose::Identity());
  const auto sweep = [&](const Pose& from, const Pose& to) {
    return separated(*box.shape, still, *box.shape, {from, to});
  };
  EXPECT_TRUE(sweep(shift(3, -5, 0), shift(3, 5, 0)).separated);
  EXPECT_EQ(sweep(shift(3, -5, 0), shift(3, 5, 0)).stage, Stage::box);
  // The bodies are apart at both ends, but one passes through the other in between.
  EXPECT_FALSE(sweep(shift(1, -5, 0), shift(1, 5, 0)).separated);
  EXPECT_TRUE(sweep(shift(5, -5, 0), shift(-5, -5, 0)).separated);
  // The body passes a corner, where the swept boxes overlap.
  EXPECT_FALSE(sweep(shift(2.5, -1, 0), shift(-1, 2.5, 0)).separated);
  EXPECT_TRUE(sweep(shift(4.5, 0, 0), shift(0, 4.5, 0)).separated);
  EXPECT_NE(sweep(shift(4.5, 0, 0), shift(0, 4.5, 0)).stage, Stage::box);
}

TEST(Separated, OrderOfThePairAndUnitDoNotMatter) {
  const std::vector<Body> all = sample_bodies();
  Pose b = shift(0.3, 0.2, 1.3);
  b.linear() = Eigen::AngleAxisd(1.1, Vector(3, -2, 1).normalized()).toRotationMatrix();
  int apart = 0;
  for (const Body& first : all) {
    for (const Body& second : all) {
      const Verdict expected = ask(first, Pose::Identity(), second, b);
      apart += expected.separated;
      EXPECT_EQ(ask(second, b, first, Pose::Identity()).separated, expected.separated);
      for (const int exponent : {-60, 60}) {
        const Body first_scaled(scaled(first.sample, exponent)), second_scaled(scaled(second.sample, exponent));
        Pose pose = b;
        pose.translation() *= std::ldexp(1.0, exponent);
        EXPECT_EQ(ask(first_scaled, Pose::Identity(), second_scaled, pose).separated, expected.separated)
            << first.sample.name << ", " << second.sample.name << " at 2^" << exponent;
      }
    }
  }
  EXPECT_GT(apart, 10);
}

TEST(Separated, QueriesDoNotAllocate) {
  const std::vector<Body> all = sample_bodies();
  std::vector<Pose> poses;
  for (int i = 0; i < 20; ++i) poses.push_back(shift(0.15 * i, 0.1 * i, 0.05 * i));
  int apart = 0;
  const long before = allocations;
  for (const Body& a : all) {
    for (const Body& b : all) {
      for (const Pose& pose : poses) apart += ask(a, Pose::Identity(), b, pose).separated;
    }
  }
  EXPECT_EQ(allocations, before);
  EXPECT_GT(apart, 0);
}

}  // namespace
}  // namespace encage::test

// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/meshes.h"
#include "oracles/twin_bodies.h"
#include "src/files/hash.h"

#include <encage/contact.h>
#include <encage/world.h>

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cmath>
#include <cstdint>
#include <iostream>
#include <span>
#include <string>
#include <vector>

// All answers are the same on every instruction set and every architecture: scripts/ci-extra compares the hash that
// this prints on x86-64 and on 64-bit ARM. Hence no transcendental functions here, and no random distributions.
namespace encage::test {
namespace {

class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : engine_(seed) {}
  int below(int count) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(count)); }
  /// Multiples of 2^-20 in [-half, half).
  double within(double half) { return half * (below(1 << 21) - (1 << 20)) / (1 << 20); }
  Eigen::Vector3d point(double half) {
    const double x = within(half), y = within(half), z = within(half);
    return {x, y, z};
  }
  /// Unit quaternions: `most` < 1 of the real part turns by less than 180 degrees.
  Eigen::Matrix3d rotation(double most) {
    const double x = within(most), y = within(most), z = within(most), s = 2 / (1 + x * x + y * y + z * z);
    Eigen::Matrix3d r;
    r << 1 - s * (y * y + z * z), s * (x * y - z), s * (x * z + y),  //
        s * (x * y + z), 1 - s * (x * x + z * z), s * (y * z - x),   //
        s * (x * z - y), s * (y * z + x), 1 - s * (x * x + y * y);
    return r;
  }
  Motion motion(double reach) {
    Motion motion;
    motion.start.linear() = rotation(2);
    motion.start.translation() = point(reach);
    motion.end = motion.start;
    if (below(3) == 0) return motion;
    const Eigen::Matrix3d turn = rotation(0.2), &from = motion.start.linear();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        motion.end.linear()(i, j) = turn(i, 0) * from(0, j) + turn(i, 1) * from(1, j) + turn(i, 2) * from(2, j);
      }
    }
    motion.end.translation() += point(0.25);
    return motion;
  }

 private:
  SplitMix engine_;
};

// A ball with dents of up to a half, in a box of a cage.
ShapePtr dented_ball(Numbers& numbers, int levels) {
  CageHierarchy hierarchy;
  hierarchy.fine = shapes::sphere(levels);
  Vertices& vertices = hierarchy.fine.vertices;
  for (std::int64_t v = 0; v < vertices.rows(); ++v) {
    const int depth = 64 - numbers.below(33);
    for (int i = 0; i < 3; ++i) vertices(v, i) = std::nearbyint(vertices(v, i) * 64) * depth / 4096;
  }
  hierarchy.source_volume = 1;
  hierarchy.diagonal = 3.5;
  hierarchy.levels.push_back({shapes::cube(1.0625), {}});
  return make_shape(hierarchy);
}

struct Answers {
  Hasher hasher;
  int separated = 0, candidates = 0, contacts = 0;

  template <class T>
  void add(const T& value) {
    hasher.add(std::as_bytes(std::span(&value, 1)));
  }
  void add(const Verdict& verdict) {
    add(verdict.separated);
    add(verdict.stage);
    add(verdict.level);
  }
};

void ask_pair(Answers& answers, const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
              double margin) {
  const Verdict verdict = separated(a, motion_a, b, motion_b, margin);
  answers.separated += verdict.separated ? 1 : 0;
  answers.add(verdict);
  answers.add(separated(a, motion_a, b, motion_b, {.margin = margin, .cages = CageUse::always, .fine = false}));
  answers.add(separated(a, motion_a, HalfSpace{}, margin));
  for_each_triangle_pair(a, motion_a, b, motion_b, margin, [&](TrianglePair pair) {
    ++answers.candidates;
    answers.add(pair);
    return true;
  });
  const std::optional<Contact> contact = first_contact(a, motion_a, b, motion_b, {.margin = margin});
  answers.add(contact.has_value());
  if (!contact) return;
  ++answers.contacts;
  answers.add(contact->time);
  answers.add(contact->kind);
  answers.add(contact->vertices);
}

void ask_world(Answers& answers, const std::vector<ShapePtr>& shapes, Numbers& numbers) {
  World world;
  std::vector<ShapeId> ids;
  for (const ShapePtr& shape : shapes) ids.push_back(world.add_shape(shape));
  world.add_half_space({});
  for (int i = 0; i < 60; ++i) {
    const Motion motion = numbers.motion(4);
    const BodyId body = world.add_body(ids[numbers.below(static_cast<int>(ids.size()))], motion.start);
    world.set_motion(body, motion);
  }
  const CandidateStatistics statistics =
      world.find_candidates({.pair = {.margin = 0.01}, .triangles = true}, [&](const CandidatePair& pair) {
        answers.add(pair.a);
        answers.add(pair.b);
        answers.add(pair.half_space);
        answers.add(pair.verdict);
        for (const TrianglePair& triangles : pair.triangles) answers.add(triangles);
      });
  answers.add(statistics.separated);
  answers.add(statistics.candidates);
}

Answers all_answers() {
  Numbers numbers(1);
  std::vector<ShapePtr> shapes;
  for (const int levels : {1, 2, 3}) shapes.push_back(dented_ball(numbers, levels));
  Answers answers;
  for (int round = 0; round < 250; ++round) {
    const Shape &a = *shapes[numbers.below(3)], &b = *shapes[numbers.below(3)];
    const Motion motion_a = numbers.motion(1.25), motion_b = numbers.motion(1.25);
    ask_pair(answers, a, motion_a, b, motion_b, numbers.below(2) * 0.015625);
  }
  ask_world(answers, shapes, numbers);
  return answers;
}

TEST(Answers, AreTheSameOnEveryInstructionSet) {
  const Answers expected = all_answers();
  EXPECT_GT(expected.separated, 25);
  EXPECT_GT(expected.candidates, 1000);
  EXPECT_GT(expected.contacts, 25);
  const std::string hash = to_string(expected.hasher.digest());
  std::cout << "answers: " << hash << "\n";
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    EXPECT_EQ(to_string(all_answers().hasher.digest()), hash) << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}

}  // namespace
}  // namespace encage::test

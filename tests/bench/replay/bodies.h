// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/poses.h>
#include <gtest/gtest.h>

#include <deque>
#include <random>
#include <string>
#include <vector>

#include "bench/replay/engine.h"
#include "tests/broadphase/exact_pair.h"
#include "tests/broadphase/sample_shapes.h"

namespace encage::replay::test {

inline encage::test::Sample sample(const std::string& name) {
  for (encage::test::Sample& candidate : encage::test::sample_shapes(0)) {
    if (candidate.name == name) return candidate;
  }
  ADD_FAILURE() << "no sample " << name;
  return {};
}

/// Steps of bodies on a shaken grid: some touch, more nearly do. Some steps lack a body, another one each time.
inline std::vector<PoseStep> crowd(int steps) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<PoseStep> result;
  for (int s = 0; s < steps; ++s) {
    PoseStep step{10 + s, {}};
    for (int i = 0; i < 9; ++i) {
      const Eigen::Quaterniond rotation(unit(random), unit(random), unit(random), unit(random));
      BodyPose body{3 * i, Eigen::Isometry3d(rotation.normalized())};
      body.pose.translation() =
          Eigen::Vector3d(1.8 * (i % 3) + 0.3 * unit(random), 1.8 * (i / 3) + 0.3 * unit(random), 0.5 * unit(random));
      if (s % 4 < 2 || i != s % 9) step.bodies.push_back(body);
    }
    result.push_back(step);
  }
  return result;
}

/// Pairs whose surfaces meet, in exact arithmetic.
inline std::vector<BodyPair> exact_pairs(const encage::test::Sample& sample, const PoseStep& step) {
  std::deque<encage::test::ExactBody> bodies;
  for (const BodyPose& body : step.bodies)
    bodies.emplace_back(sample.hierarchy.origin, sample.hierarchy.fine, body.pose);
  std::vector<BodyPair> pairs;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t j = i + 1; j < bodies.size(); ++j) {
      if (encage::test::surfaces_meet(bodies[i], bodies[j], 0))
        pairs.push_back({step.bodies[i].body, step.bodies[j].body});
    }
  }
  return pairs;
}

/// The engine against exact arithmetic, alone and behind the gate.
template <class MakeEngine>
void expect_exact(const MakeEngine& make_engine) {
  std::size_t touching = 0;
  for (const char* name : {"star", "u", "torus"}) {
    SCOPED_TRACE(name);
    const encage::test::Sample body = sample(name);
    const ShapePtr shape = make_shape(body.hierarchy);
    const CageGate gate(shape, 0);
    const auto engine = make_engine(body, shape);
    for (const PoseStep& step : crowd(8)) {
      const std::vector<BodyPair> expected = exact_pairs(body, step);
      EXPECT_EQ(engine->touching(step, nullptr), expected) << "step " << step.step;
      EXPECT_EQ(engine->touching(step, &gate), expected) << "step " << step.step << ", behind the gate";
      touching += expected.size();
    }
  }
  EXPECT_GT(touching, 30U);
}

}  // namespace encage::replay::test

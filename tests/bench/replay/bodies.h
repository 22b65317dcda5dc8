// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/replay/engine.h"
#include "bench/replay/mesh_shape.h"
#include "oracles/exact_pair.h"
#include "oracles/sample_shapes.h"

#include <encage/poses.h>

#include <gtest/gtest.h>

#include <deque>
#include <random>
#include <string>
#include <vector>

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

/// What engines are made of.
inline ReplayBody body_of(const encage::test::Sample& sample) {
  return {sample.hierarchy.fine, make_shape(sample.hierarchy), static_cast<int>(sample.hierarchy.levels.size()), true};
}

/// The same for a mesh without cages.
inline ReplayBody body_of(const TriangleMesh& mesh) {
  encage::test::Sample bare = encage::test::without_cages(sample("box"));
  bare.hierarchy.fine = mesh;
  return body_of(bare);
}

inline BodyPose body_at(std::int32_t number, double x, double y = 0, double z = 0) {
  return {number, Eigen::Isometry3d(Eigen::Translation3d(x, y, z))};
}

}  // namespace encage::replay::test

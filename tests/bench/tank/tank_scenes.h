// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/tank/strategy.h"
#include "oracles/sample_shapes.h"
#include "tests/bench/tank/swept_meshes.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <string>
#include <utility>

namespace encage::tank::test {

inline TankBody sample_body(const std::string& name) {
  for (const encage::test::Sample& sample : encage::test::sample_shapes(0)) {
    if (sample.name == name) return make_tank_body(sample.hierarchy);
  }
  ADD_FAILURE() << "no sample " << name;
  return {nullptr, BodyMesh({}, Eigen::Vector3d::Zero()), 0};
}

/// Bodies on a shaken grid, close enough that many pairs nearly touch and some do.
inline bench::RecordedStep crowded_step(std::int64_t number, std::uint32_t seed) {
  std::mt19937 random(seed);
  bench::RecordedStep step{number, {}};
  for (int i = 0; i < 12; ++i) {
    Motion motion = random_motion(random, 0.3, 0.2);
    const Eigen::Vector3d cell(1.9 * (i % 2), 1.9 * (i / 2 % 2), 1.7 * (i / 4));
    motion.start.translation() += cell;
    motion.end.translation() += cell;
    step.bodies.push_back({2 * i + 1, motion});
  }
  return step;
}

}  // namespace encage::tank::test

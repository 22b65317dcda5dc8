// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/poses.h>

#include <random>
#include <vector>

namespace encage::covers::test {

/// Steps of bodies of diagonal 1 to 5 on a shaken grid: some touch, more nearly do. From step to step they move by
/// `way` and turn.
inline std::vector<PoseStep> crowd(int steps, double way) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<PoseStep> result;
  for (int s = 0; s < steps; ++s) {
    PoseStep step{s, {}};
    for (int i = 0; i < 8; ++i) {
      const Eigen::Quaterniond rotation(unit(random), unit(random), unit(random), unit(random));
      BodyPose body{i, Eigen::Isometry3d(rotation.normalized())};
      body.pose.translation() = Eigen::Vector3d(1.8 * (i & 1), 1.8 * (i >> 1 & 1), 1.8 * (i >> 2)) +
                                0.5 * Eigen::Vector3d(unit(random), 0, 0);
      if (s % 2 == 1) {  // a step from the one before
        const Eigen::Isometry3d before = result.back().bodies[i].pose;
        const Eigen::AngleAxisd turn(0.3 * unit(random), Eigen::Vector3d::UnitZ());
        body.pose = before * turn;
        body.pose.translation() += way * Eigen::Vector3d(unit(random), unit(random), unit(random));
      }
      step.bodies.push_back(body);
    }
    result.push_back(step);
  }
  return result;
}

}  // namespace encage::covers::test

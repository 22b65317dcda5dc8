// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/sweep.h"

namespace encage::tank {

Sweep make_sweep(const TriangleMesh& mesh, const Eigen::Vector3d& origin, const Motion& motion, double distance) {
  const Eigen::AlignedBox3d box = bounds(mesh);
  const double radius = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).norm();
  const double size = radius + origin.norm() + motion.start.translation().norm() + motion.end.translation().norm();
  const Eigen::Translation3d shift(origin);
  return {&mesh, motion.start * shift, motion.end * shift, distance / 2 + 0x1p-40 * size};
}

}  // namespace encage::tank

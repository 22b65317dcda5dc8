// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/sweep.h"

#include <utility>

namespace encage::tank {

BodyMesh::BodyMesh(TriangleMesh fine, const Eigen::Vector3d& local_origin)
    : mesh(std::move(fine)), origin(local_origin) {
  const Eigen::AlignedBox3d box = bounds(mesh);
  if (!box.isEmpty()) radius = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).norm() * (1 + 0x1p-40);
}

double BodyMesh::slack(const Motion& motion, double distance) const {
  const double size = radius + origin.norm() + motion.start.translation().norm() + motion.end.translation().norm();
  return distance / 2 + 0x1p-40 * size;
}

Sweep make_sweep(const BodyMesh& body, const Motion& motion, double distance) {
  const Eigen::Translation3d shift(body.origin);
  return {&body.mesh, motion.start * shift, motion.end * shift, body.slack(motion, distance)};
}

}  // namespace encage::tank

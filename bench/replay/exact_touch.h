// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/replay/gate.h"

#include <encage/mesh.h>
#include <encage/poses.h>

#include <memory>
#include <vector>

namespace encage::replay {

/// Which bodies touch, in exact arithmetic: every vertex is the exact image of the mesh's under the pose, whose entries
/// are taken as the rational numbers they are. Shares no code with Encage's run time or the engines.
class ExactTouch {
 public:
  /// `mesh` in the body frame, with at least one triangle; `closed`: it bounds a solid.
  ExactTouch(TriangleMesh mesh, bool closed);
  ~ExactTouch();

  /// The surfaces have a point in common, or, of closed meshes, a component of one lies in the other solid.
  bool touch(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const;
  /// All pairs of a step that touch, sorted.
  std::vector<BodyPair> touching(const PoseStep& step) const;

 private:
  struct Data;
  struct Pair;
  std::unique_ptr<Data> data_;
};

}  // namespace encage::replay

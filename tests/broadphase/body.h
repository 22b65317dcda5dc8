// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "tests/broadphase/sample_shapes.h"

#include <encage/broadphase.h>

#include <Eigen/Geometry>
#include <utility>

namespace encage::test {

/// A sample and the run time's shape of it.
struct Body {
  Sample sample;
  ShapePtr shape;

  explicit Body(Sample s) : sample(std::move(s)), shape(make_shape(sample.hierarchy)) {}
  double diagonal() const { return sample.hierarchy.diagonal; }
  const Eigen::Vector3d& origin() const { return sample.hierarchy.origin; }
  Eigen::Vector3d centre(const Eigen::Isometry3d& pose) const { return pose * origin(); }
  bool solid() const { return sample.hierarchy.solid != Solid::surface_only; }
  bool has_fine() const { return sample.hierarchy.fine.triangles.rows() > 0; }
  /// The finest that is stored: the fine mesh, else the first cage.
  const TriangleMesh& mesh() const { return has_fine() ? sample.hierarchy.fine : sample.hierarchy.levels.front().mesh; }
};

}  // namespace encage::test

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Triangles and places that are hard on rounding.

#include "broadphase/separation/triangle_pair.h"
#include "oracles/twin_bodies.h"

#include <Eigen/Core>

namespace encage::twins {

/// Of coordinates up to 1 or, on a lattice, 3: any, slivers, segments, points.
TriangleD random_triangle(test::TwinRandom& random);

/// A corner, a point of an edge or of the face; rounded.
Eigen::Vector3d point_of(test::TwinRandom& random, const TriangleD& triangle);

/// 0 once in three times, else 1e-16 to 1e-2, and along which direction features near their contact are moved by it.
Eigen::Vector3d random_gap(test::TwinRandom& random, const TriangleD& a, const TriangleD& b);

/// The same number, the next ones below and above, or one a little farther.
double nudged(test::TwinRandom& random, double x);

/// Where things of size 1 are put: 1e6 away, or in a unit of 1e-30 to 1e30; usually as they are.
struct Setting {
  double scale = 1;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();

  static Setting any(test::TwinRandom& random);
  Eigen::Vector3d operator()(const Eigen::Vector3d& x) const { return x * scale + offset; }
  void apply(TriangleD& triangle) const {
    for (Eigen::Vector3d& v : triangle) v = (*this)(v);
  }
};

struct TrianglePairSample {
  TriangleD a, b;
  Setting setting;  ///< applied
};
/// Usually near each other.
TrianglePairSample random_triangle_pair(test::TwinRandom& random);

}  // namespace encage::twins

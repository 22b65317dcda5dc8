// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Triangles and positions for which rounding is critical.

#include "broadphase/separation/triangle_pair.h"
#include "oracles/twin_bodies.h"

#include <Eigen/Core>

namespace encage::twins {

/// A triangle with coordinates up to 1 or, on a lattice, up to 3: any, a sliver, a segment or a point.
TriangleD random_triangle(test::TwinRandom& random);

/// A corner, a point of an edge or of the face, rounded.
Eigen::Vector3d point_of(test::TwinRandom& random, const TriangleD& triangle);

/// 0 one time in three, otherwise 1e-16 to 1e-2, in a direction along which it moves features that are nearly in
/// contact.
Eigen::Vector3d random_gap(test::TwinRandom& random, const TriangleD& a, const TriangleD& b);

/// The same number, one of its neighbours, or a number slightly farther away.
double nudged(test::TwinRandom& random, double x);

/// Position and unit of things of size 1: 1e6 away, or in a unit of 1e-30 to 1e30; usually unchanged.
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
  Setting setting;  ///< has been applied
};
/// Returns triangles that are usually near each other.
TrianglePairSample random_triangle_pair(test::TwinRandom& random);

}  // namespace encage::twins

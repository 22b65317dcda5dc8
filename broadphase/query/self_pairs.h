// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/separation/triangle_pair.h"
#include "broadphase/shape/shape.h"

#include <cstdint>

namespace encage {

/// Two triangles of one surface, in coordinates relative to a corner of the first: they are off by less than eps times
/// `size`, the largest norm of a corner.
struct SelfPair {
  std::int32_t a = 0, b = 0;  ///< triangles, a < b
  TriangleD corners_a, corners_b;
  Eigen::Vector3d origin;  ///< that corner, in the local frame
  double size = 0;
  int shared = 0;  ///< number of vertices that they share
  /// Corners of each that are not shared. If there is only one it comes twice, if there is none `others` is 0.
  std::array<std::array<Eigen::Vector3d, 2>, 2> other;
  std::array<int, 2> others = {0, 0};     ///< number of different vertices among these
  std::array<Eigen::Vector3d, 2> common;  ///< the first shared vertices
};

SelfPair self_pair(const Surface& surface, const LeafTriangle& a, const LeafTriangle& b) noexcept;

/// True only if the triangles are proven to have no more in common than the vertices and edges that they share.
bool only_share(const SelfPair& pair) noexcept;

/// True only if they are proven to have more in common.
bool certainly_meet(const SelfPair& pair) noexcept;

/// Called with pairs of triangles whose boxes are near. Returns the distance up to which pairs are to be visited from
/// now on, which never grows; negative to stop.
using VisitSelfPair = double (*)(void* context, const LeafTriangle& a, const LeafTriangle& b);

/// Visits every pair of triangles of a surface, once, except those that are proven farther apart than `reach` >= 0, or
/// than the last visitor's result. The order depends on the surface and the results alone. `steps` loses one for each
/// box that is tested against eight, and a visitor may take more from it; where it is negative the visits stop. Returns
/// false if they stopped.
bool visit_self_pairs(const Surface& surface, double reach, VisitSelfPair visit, void* context,
                      std::int64_t& steps) noexcept;

}  // namespace encage

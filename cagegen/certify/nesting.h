// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/certify/box_tree.h"
#include "cagegen/certify/connectivity.h"
#include "cagegen/certify/exact.h"

#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace encage::proof {

/// A mesh with its connectivity and box tree, for the proofs. Refers to the mesh.
struct Surface {
  const TriangleMesh& mesh;
  Connectivity connectivity;
  BoxTree tree;

  explicit Surface(const TriangleMesh& m) : mesh(m), connectivity(proof::connectivity(m)), tree(m) {}
};

using TrianglePair = std::pair<std::int32_t, std::int32_t>;

/// Two triangles of `mesh` (none degenerate, a closed manifold by its indices) that have more in common than the
/// vertices or the edge that they share; none if it is embedded.
std::optional<TrianglePair> self_intersection(const Surface& surface);

/// The clearance is a lower bound of the distance, and falls short of it by no more than clearance_slack times the
/// distance plus clearance_rounding times the extent of the nearest pair of triangles.
inline constexpr double clearance_slack = 1e-6;
inline constexpr double clearance_rounding = 0x1p-45;

/// How far apart two surfaces are.
struct Contact {
  bool touch = false;
  /// At most the distance of the surfaces; 0 if they touch, or are closer than double can say.
  double clearance = std::numeric_limits<double>::infinity();
  std::int32_t outer = -1;  ///< the triangles at clearance 0
  std::int32_t inner = -1;
};

/// Stops at the first pair at clearance 0. No triangle of `outer` may be degenerate.
Contact contact(const Surface& inner, const Surface& outer);

/// Winding number of a closed surface around a point that is not on it, by exact predicates; triangles of component
/// `skip` are left out.
int winding_number(const Surface& surface, const Point& p, int skip = -1);

/// The first triangle of every component, in the order of the labels.
std::vector<std::int32_t> first_triangles(const Surface& surface);

}  // namespace encage::proof

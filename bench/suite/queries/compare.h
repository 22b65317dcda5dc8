// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>
#include <encage/queries.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace encage::queries {

struct QueryRow {
  std::string name;
  double per_second = 0;     ///< of CPU time, the median of the runs
  std::int64_t checked = 0;  ///< answers compared with exact arithmetic, or with bounds
  std::int64_t wrong = 0;    ///< hits missed, or distances out of bounds
};

/// Incoherent rays that begin around the shape and lead to places in its box; a tenth of those that are checked leads
/// to vertices. `mesh`: the shape's fine mesh in the body frame. Embree takes the same rays, rounded to float.
std::vector<QueryRow> compare_rays(const Shape& shape, const TriangleMesh& mesh, int rays, int checks, int runs,
                                   const std::function<void(double fraction)>& progress);

/// Points: a third anywhere in the box, a third within 1e-6 diagonals of the surface, a third within 5 %.
std::vector<QueryRow> compare_points(const Shape& shape, const TriangleMesh& mesh, int points, int runs,
                                     const std::function<void(double fraction)>& progress);

/// Volumes that begin around the shape and move to places in its box: small and large spheres, capsules and boxes.
/// Checked is that no volume overlaps the shape earlier than its cast says.
std::vector<QueryRow> measure_casts(const Shape& shape, const TriangleMesh& mesh, int casts, int runs,
                                    const std::function<void(double fraction)>& progress);

}  // namespace encage::queries

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/suite/distance/pairs.h"

#include <encage/mesh.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace encage::distances {

/// What one way to answer took for the pairs of a class.
struct DistanceRow {
  std::string name;
  double median_us = 0, mean_us = 0;  ///< over pairs, of which each counts with the median of its runs; CPU time
  double tightness = 0;               ///< median of bound / distance, where that is positive
  std::int64_t wrong = 0;             ///< bounds that are too large, distances that are not in ours
};

struct ClassRows {
  std::string name;
  std::int64_t pairs = 0;
  std::vector<DistanceRow> rows;
};

/// Bounds by every cage level, distances of the fine meshes by Encage and by FCL. `mesh`: the shape's fine mesh in the
/// body frame.
std::vector<ClassRows> compare(const Shape& shape, const TriangleMesh& mesh, const std::vector<PairClass>& classes,
                               int runs, const std::function<void(double fraction)>& progress);

}  // namespace encage::distances

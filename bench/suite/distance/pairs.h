// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/distance.h>
#include <encage/poses.h>
#include <encage/separated.h>

#include <string>
#include <vector>

namespace encage::distances {

/// Two bodies of the shape in one step, and the pair of triangles that was nearest in the step before.
struct DistancePair {
  Motion a, b;
  TrianglePair hint;
  DistanceResult truth;
};

/// Pairs whose distance is a similar part of the body's diagonal.
struct PairClass {
  std::string name;
  std::vector<DistancePair> pairs;
};

/// All pairs of bodies in every `every`-th step, sorted by distance; of each class evenly spread ones, `most` of them.
/// The last class has pairs moved apart by ten diagonals. Throws Error if there are no pairs.
std::vector<PairClass> make_pairs(const Shape& shape, double diagonal, const std::vector<PoseStep>& poses,
                                  std::int64_t every, std::size_t most);

}  // namespace encage::distances

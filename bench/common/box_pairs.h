// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/poses.h>
#include <encage/shape.h>

#include <cstddef>
#include <utility>
#include <vector>

namespace encage::bench {

/// The broad phase of what has none of its own: world boxes, each with each, good for some tens of bodies.
class BoxPairs {
 public:
  using Places = std::vector<std::pair<std::size_t, std::size_t>>;  ///< in the list of bodies; sorted, first < second

  /// Bodies of one shape whose world boxes overlap. Valid until the next call.
  const Places& overlaps(const Shape& shape, const PoseStep& step);
  const Places& overlaps(const Shape& shape, const std::vector<Motion>& motions);

 private:
  const Places& find();

  std::vector<Eigen::AlignedBox3d> boxes_;
  Places places_;
};

}  // namespace encage::bench

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/tank/sweep.h"

#include <encage/separated.h>

#include <embree3/rtcore.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace encage::tank {

/// A tree of axis-aligned boxes over the swept triangles of one step, built by the fastest builder at hand, Embree's
/// rtcBuildBVH, in the calling thread only. Our own nodes and traversal: Embree hands the tree out through callbacks.
class EmbreeTree {
 public:
  /// `low` (Morton codes) builds fastest; `medium` (binned surface-area heuristic) makes better trees.
  explicit EmbreeTree(RTCBuildQuality quality = RTC_BUILD_QUALITY_LOW);

  /// Forgets what was there; keeps the memory. Throws std::bad_alloc.
  void build(const Sweep& sweep);

  /// Appends all pairs of triangles whose boxes overlap, in the order of the traversal.
  static void overlaps(const EmbreeTree& a, const EmbreeTree& b, std::vector<TrianglePair>& pairs);

 private:
  static constexpr int width = 4;      ///< children of a node, at most
  static constexpr int leaf_size = 4;  ///< triangles in a leaf, at most

  struct Box {
    float lower[3], upper[3];
  };
  /// An inner node (>= 0) or, as its complement, a leaf.
  using Ref = std::int32_t;
  struct Node {
    float lower[3][width], upper[3][width];  ///< of the children; inverted where there is none
    Ref child[width];
  };
  struct Leaf {
    Box box;
    std::int32_t first, count;  ///< in primitives_
  };
  struct Callbacks;
  struct ReleaseTree {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCBVH bvh) const { rtcReleaseBVH(bvh); }
  };
  struct TreeTraversal;

  RTCBuildQuality quality_;
  std::unique_ptr<RTCDeviceTy, ReleaseTree> device_;
  std::unique_ptr<RTCBVHTy, ReleaseTree> bvh_;
  std::vector<Box> vertices_;
  std::vector<RTCBuildPrimitive> input_;
  std::vector<RTCBuildPrimitive> primitives_;  ///< leaf after leaf
  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;
  Ref root_ = 0;
};

}  // namespace encage::tank

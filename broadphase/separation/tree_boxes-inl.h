// SPDX-License-Identifier: Apache-2.0
// Boxes of trees and the slabs in them, in float for one distance (box_gate.cpp) or in double for the distance itself
// (box_distance.cpp). Compiled once for every instruction set: include it after <hwy/foreach_target.h>.

#include "src/tree/mesh_tree.h"

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#if defined(ENCAGE_TREE_BOXES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ENCAGE_TREE_BOXES_INL_H
#undef ENCAGE_TREE_BOXES_INL_H
#else
#define ENCAGE_TREE_BOXES_INL_H
#endif

HWY_BEFORE_NAMESPACE();
namespace encage::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

template <class Real>
using NodeLanes = hn::CappedTag<Real, MeshNode::width>;
template <class Real>
using NodeVec = hn::Vec<NodeLanes<Real>>;

/// About 1/|n|^2 of a slab's normal n. Any factor gives a valid bound, this one a tight one.
template <class Real>
constexpr Real normal_weight = Real{1} / (MeshNode::normal_size * MeshNode::normal_size);

/// One box of a tree and the slab in it, in coordinates of the tree's grid.
template <class Real>
struct TreeBox {
  Real centre[3], half[3];
  Real normal[3];
  Real height, thickness;  ///< of the slab's middle along the normal; half the slab's width

  HWY_INLINE TreeBox(const MeshNode& node, std::uint32_t lane) {
    for (int i = 0; i < 3; ++i) {
      set_extent(i, node.lower[i][lane], node.upper[i][lane]);
      normal[i] = static_cast<Real>(node.normal[i][lane]);
    }
    constexpr Real half_unit = Real{0.5} * MeshNode::slab_unit;
    const auto low = static_cast<Real>(node.slab_lower[lane]), high = static_cast<Real>(node.slab_upper[lane]);
    height = half_unit * (low + high);
    thickness = half_unit * (high - low);
  }

  /// Returns the box around all boxes of a node. Its slab has no normal and is unbounded.
  static TreeBox around(const MeshNode& node) {
    TreeBox box(node, 0);
    for (int i = 0; i < 3; ++i) {
      std::int16_t lower = node.lower[i][0], upper = node.upper[i][0];
      for (int lane = 1; lane < MeshNode::width; ++lane) {  // unused lanes have empty boxes
        lower = std::min(lower, node.lower[i][lane]);
        upper = std::max(upper, node.upper[i][lane]);
      }
      box.set_extent(i, lower, upper);
      box.normal[i] = 0;
    }
    box.height = box.thickness = 0;
    return box;
  }

 private:
  HWY_INLINE void set_extent(int i, std::int16_t lower, std::int16_t upper) {
    centre[i] = Real{0.5} * (static_cast<Real>(lower) + static_cast<Real>(upper));
    half[i] = Real{0.5} * (static_cast<Real>(upper) - static_cast<Real>(lower));
  }
};

template <class Int>
HWY_INLINE NodeVec<float> widened(NodeLanes<float> d, const Int* values) {
  return hn::ConvertTo(
      d, hn::PromoteTo(hn::RebindToSigned<NodeLanes<float>>(), hn::LoadU(hn::Rebind<Int, NodeLanes<float>>(), values)));
}
template <class Int>
HWY_INLINE NodeVec<double> widened(NodeLanes<double> d, const Int* values) {
  using Ints = hn::Rebind<std::int32_t, NodeLanes<double>>;
  return hn::PromoteTo(d, hn::PromoteTo(Ints(), hn::LoadU(hn::Rebind<Int, NodeLanes<double>>(), values)));
}

template <class Vec, class Real>
HWY_INLINE Vec dot(const Vec* a, const Real* b) {
  const NodeLanes<Real> d;
  return hn::Add(hn::Add(hn::Mul(a[0], hn::Set(d, b[0])), hn::Mul(a[1], hn::Set(d, b[1]))),
                 hn::Mul(a[2], hn::Set(d, b[2])));
}

/// Boxes of a node side by side, as many as there are lanes.
template <class Real>
struct TreeBoxes {
  using Vec = NodeVec<Real>;

  Vec sum[3], extent[3];  ///< upper + lower, upper - lower
  Vec normal[3];
  Vec slab_lower, slab_upper;

  /// Loads the lanes [first, first + lanes of the machine) and calls bounds(axis, lower, upper) for each axis. Bounds
  /// are needed once only: kept, they would spill registers.
  template <class Bounds>
  HWY_INLINE TreeBoxes(const MeshNode& node, std::size_t first, Bounds&& bounds) {
    const NodeLanes<Real> d;
    for (int i = 0; i < 3; ++i) {
      const Vec lower = widened(d, node.lower[i] + first), upper = widened(d, node.upper[i] + first);
      bounds(i, lower, upper);
      sum[i] = hn::Add(lower, upper);
      extent[i] = hn::Sub(upper, lower);
      normal[i] = widened(d, node.normal[i] + first);
    }
    slab_lower = widened(d, node.slab_lower + first);
    slab_upper = widened(d, node.slab_upper + first);
  }

  /// Twice the half extents along an axis.
  HWY_INLINE Vec reach_along(const Real* axis) const {
    const NodeLanes<Real> d;
    auto reach = hn::Mul(hn::Set(d, std::abs(axis[0])), extent[0]);
    reach = hn::Add(reach, hn::Mul(hn::Set(d, std::abs(axis[1])), extent[1]));
    return hn::Add(reach, hn::Mul(hn::Set(d, std::abs(axis[2])), extent[2]));
  }

  /// Intervals [centre - reach, centre + reach] along a direction, of which half is given. The slab bounds the part of
  /// the direction along its normal, the box bounds the remainder.
  HWY_INLINE void cover(const Real* half_direction, Vec& centre, Vec& reach) const {
    const NodeLanes<Real> d;
    const auto part = hn::Mul(dot(normal, half_direction), hn::Set(d, normal_weight<Real>));
    const auto scaled = hn::Mul(part, hn::Set(d, static_cast<Real>(MeshNode::slab_unit)));
    centre = hn::Mul(scaled, hn::Add(slab_lower, slab_upper));
    reach = hn::Mul(hn::Abs(scaled), hn::Sub(slab_upper, slab_lower));
    for (int i = 0; i < 3; ++i) {
      const auto rest = hn::Sub(hn::Set(d, half_direction[i]), hn::Mul(part, normal[i]));
      centre = hn::Add(centre, hn::Mul(rest, sum[i]));
      reach = hn::Add(reach, hn::Mul(hn::Abs(rest), extent[i]));
    }
  }

  /// Sizes for comparison only: a slab's thickness counts more than the extents of the box that it cuts.
  HWY_INLINE Vec sizes() const {
    const NodeLanes<Real> d;
    const auto thickness = hn::Mul(hn::Sub(slab_upper, slab_lower), hn::Set(d, Real{8}));
    return hn::Add(thickness, hn::Add(hn::Add(extent[0], extent[1]), extent[2]));
  }
};

}  // namespace
}  // namespace encage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

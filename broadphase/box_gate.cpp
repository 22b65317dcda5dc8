// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "broadphase/box_gate.cpp"
#include <hwy/foreach_target.h>  // compiles what follows once for every instruction set

#include "broadphase/box_gate.h"

#include <hwy/highway.h>

#include <cmath>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace encage::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, WideNode::width>;     // boxes of a node
using Axes = hn::CappedTag<float, BoxGate::axis_lanes>;  // axes of a gate
using Coordinates = hn::CappedTag<float, 4>;             // x, y, z

/// A box of one tree: the index of its node times the width of a node, plus its lane.
using BoxIndex = std::int32_t;

struct Box {
  std::array<float, 3> centre, half;

  Box(const WideNode& node, int lane) {
    for (int axis = 0; axis < 3; ++axis) {
      centre[axis] = 0.5F * (node.lower[axis][lane] + node.upper[axis][lane]);
      half[axis] = 0.5F * (node.upper[axis][lane] - node.lower[axis][lane]);
    }
  }
  float size() const { return half[0] * half[0] + half[1] * half[1] + half[2] * half[2]; }
};

/// Bounds of a moving box over the interval, widened by the gap: a resting box beyond them is apart.
template <std::size_t kCount>
struct Bounds {
  alignas(64) std::array<float, kCount> low;
  alignas(64) std::array<float, kCount> high;
};

/// Projections of a box that moves linearly: `direction` and `size` by [end][coordinate], `offset` by [end].
template <int kEnds, class Tag, class Directions, class Offsets, std::size_t kCount>
void sweep(Tag d, const Directions& direction, const Directions& size, const Offsets& offset, float gap, const Box& box,
           Bounds<kCount>& bounds) {
  for (std::size_t k = 0; k < kCount; k += hn::Lanes(d)) {
    auto low = hn::Zero(d), high = low;
    for (int end = 0; end < kEnds; ++end) {
      auto centre = hn::LoadU(d, offset[end].data() + k);
      auto reach = hn::Set(d, gap);
      for (int i = 0; i < 3; ++i) {
        centre = hn::Add(centre, hn::Mul(hn::LoadU(d, direction[end][i].data() + k), hn::Set(d, box.centre[i])));
        reach = hn::Add(reach, hn::Mul(hn::LoadU(d, size[end][i].data() + k), hn::Set(d, box.half[i])));
      }
      low = end == 0 ? hn::Sub(centre, reach) : hn::Min(low, hn::Sub(centre, reach));
      high = end == 0 ? hn::Add(centre, reach) : hn::Max(high, hn::Add(centre, reach));
    }
    hn::Store(low, d, bounds.low.data() + k);
    hn::Store(high, d, bounds.high.data() + k);
  }
}

/// Bits of the used lanes of a node that are not apart along a coordinate.
std::uint32_t lanes_within(const WideNode& node, const Bounds<4>& bounds) {
  const Lanes d;
  const hn::RebindToSigned<Lanes> di;
  std::uint32_t result = 0;
  for (std::size_t first = 0; first < WideNode::width; first += hn::Lanes(d)) {
    auto apart = hn::FirstN(d, 0);
    for (int axis = 0; axis < 3; ++axis) {
      apart = hn::Or(apart, hn::Gt(hn::LoadU(d, node.lower[axis] + first), hn::Set(d, bounds.high[axis])));
      apart = hn::Or(apart, hn::Lt(hn::LoadU(d, node.upper[axis] + first), hn::Set(d, bounds.low[axis])));
    }
    const auto used = hn::RebindMask(d, hn::Gt(hn::LoadU(di, node.count + first), hn::Set(di, WideNode::unused)));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::AndNot(apart, used), bits);
    result |= static_cast<std::uint32_t>(bits[0]) << first;
  }
  return result;
}

/// Whether an axis of the gate shows a resting box beyond the bounds.
bool separated_by_axis(const BoxGate::Side& side, const Box& box, const Bounds<BoxGate::axis_lanes>& bounds) {
  const Axes d;
  for (std::size_t k = 0; k < BoxGate::axis_lanes; k += hn::Lanes(d)) {
    auto centre = hn::Mul(hn::LoadU(d, &side.axis[0][k]), hn::Set(d, box.centre[0]));
    auto reach = hn::Mul(hn::LoadU(d, &side.axis_size[0][k]), hn::Set(d, box.half[0]));
    for (int i = 1; i < 3; ++i) {
      centre = hn::Add(centre, hn::Mul(hn::LoadU(d, &side.axis[i][k]), hn::Set(d, box.centre[i])));
      reach = hn::Add(reach, hn::Mul(hn::LoadU(d, &side.axis_size[i][k]), hn::Set(d, box.half[i])));
    }
    const auto apart = hn::Or(hn::Gt(hn::Sub(centre, reach), hn::Load(d, &bounds.high[k])),
                              hn::Lt(hn::Add(centre, reach), hn::Load(d, &bounds.low[k])));
    if (!hn::AllFalse(d, apart)) return true;
  }
  return false;
}

/// Bits of the lanes of `node`, at rest, that are not proven apart from the moving box.
template <int kEnds>
std::uint32_t near_lanes(const BoxGate::Side& side, const WideNode& node, const Box& moving) {
  Bounds<4> swept;
  sweep<kEnds>(Coordinates(), side.map, side.magnitude, side.offset, side.gap, moving, swept);
  std::uint32_t near = lanes_within(node, swept);
  if (near == 0) return 0;
  Bounds<BoxGate::axis_lanes> projected;
  sweep<kEnds>(Axes(), side.moving, side.moving_size, side.moving_offset, side.gap, moving, projected);
  for (std::uint32_t left = near; left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    if (separated_by_axis(side, Box(node, lane), projected)) near &= ~(1U << lane);
  }
  return near;
}

std::uint32_t used_lanes(const WideNode& node) {
  std::uint32_t used = 0;
  for (int lane = 0; lane < WideNode::width; ++lane) used |= (node.count[lane] != WideNode::unused ? 1U : 0U) << lane;
  return used;
}

class Traversal {
 public:
  Traversal(const WideTreeView& a, const WideTreeView& b, std::span<const BoxGate> gates, VisitLeaves visit,
            void* context)
      : a_(a), b_(b), gates_(gates), visit_(visit), context_(context) {}

  bool run() {
    for (int lane = 0; lane < WideNode::width; ++lane) {
      if (b_.nodes[0].count[lane] != WideNode::unused) open<&BoxGate::a>(a_, 0, b_, lane);
    }
    while (size_ > 0) {
      const Pair pair = stack_[--size_];
      const WideNode& na = a_.nodes[pair.a / WideNode::width];
      const WideNode& nb = b_.nodes[pair.b / WideNode::width];
      const int la = pair.a % WideNode::width, lb = pair.b % WideNode::width;
      if (na.count[la] > 0 && nb.count[lb] > 0) {
        if (!visit_(context_, na.child[la], na.count[la], nb.child[lb], nb.count[lb])) return false;
      } else if (nb.count[lb] > 0 || (na.count[la] == 0 && Box(na, la).size() >= Box(nb, lb).size())) {
        open<&BoxGate::a>(a_, na.child[la], b_, pair.b);
      } else {
        open<&BoxGate::b>(b_, nb.child[lb], a_, pair.a);
      }
    }
    return true;
  }

 private:
  struct Pair {
    BoxIndex a, b;
  };
  static constexpr int stack_size = WideNode::width * (2 * WideTree::max_depth + 8);

  /// Puts the boxes of a node of the tree at rest on the stack, each with the other tree's box.
  template <BoxGate::Side BoxGate::*kSide>
  void open(const WideTreeView& resting, std::int32_t node_index, const WideTreeView& moving, BoxIndex box_index) {
    const WideNode& node = resting.nodes[node_index];
    const Box box(moving.nodes[box_index / WideNode::width], box_index % WideNode::width);
    std::uint32_t near = 0;
    for (const BoxGate& gate : gates_) {
      const BoxGate::Side& side = gate.*kSide;
      near |= !side.works      ? used_lanes(node)
              : gate.ends == 1 ? near_lanes<1>(side, node, box)
                               : near_lanes<2>(side, node, box);
    }
    // The first lane on top.
    while (near != 0) {
      const int lane = 31 - __builtin_clz(near);
      near &= ~(1U << lane);
      const BoxIndex opened = node_index * WideNode::width + lane;
      stack_[size_++] = kSide == &BoxGate::a ? Pair{opened, box_index} : Pair{box_index, opened};
    }
  }

  const WideTreeView& a_;
  const WideTreeView& b_;
  std::span<const BoxGate> gates_;
  VisitLeaves visit_;
  void* context_;
  int size_ = 0;
  std::array<Pair, stack_size> stack_;
};

bool visit_leaf_pairs(const WideTreeView& a, const WideTreeView& b, std::span<const BoxGate> gates, VisitLeaves visit,
                      void* context) {
  return Traversal(a, b, gates, visit, context).run();
}

}  // namespace encage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace encage {
namespace {

using Vector = Eigen::Vector3d;
using Matrix = Eigen::Matrix3d;

/// Upper bound of the spectral norm, tight for what is nearly a rotation.
double norm_bound(const Matrix& m) {
  return std::sqrt(1 + (m.transpose() * m - Matrix::Identity()).norm()) * (1 + 1e-14);
}

BoxGate::Column column(const Vector& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), 0};
}

void set_axis(std::array<BoxGate::PerAxis, 3>& axes, std::array<BoxGate::PerAxis, 3>& sizes, int k, const Vector& n) {
  for (int i = 0; i < 3; ++i) {
    axes[i][k] = static_cast<float>(n[i]);
    sizes[i][k] = std::abs(axes[i][k]);
  }
}

/// Directions that may separate boxes of the frame at rest from the other's: its axes, and cross products; no longer
/// than 1.
std::array<Vector, BoxGate::axis_count> oblique_axes(const Matrix& other) {
  std::array<Vector, BoxGate::axis_count> axes;
  for (int i = 0; i < 3; ++i) {
    axes[i] = other.col(i);
    for (int j = 0; j < 3; ++j) axes[3 + 3 * i + j] = axes[i].cross(Vector::Unit(j));
  }
  for (Vector& n : axes) {
    const double squared = n.squaredNorm();
    // None where nearly parallel edges leave no direction.
    n *= squared > 1e-12 ? (1 - 1e-9) / std::sqrt(squared) : 0;
  }
  return axes;
}

/// `maps` of the body at rest, `others` of the moving one, to the common frame at both ends of the interval.
BoxGate::Side make_side(const std::array<AffineMap, 2>& maps, const std::array<AffineMap, 2>& others, int ends,
                        double radius, double other_radius, double distance) {
  BoxGate::Side side{};
  std::array<AffineMap, 2> relative;
  double stretch = 1, offset = 0;
  for (int end = 0; end < ends; ++end) {
    const Matrix inverse = maps[end].linear.inverse();
    relative[end] = {inverse * others[end].linear, inverse * (others[end].offset - maps[end].offset)};
    stretch = std::max(stretch, norm_bound(relative[end].linear));
    offset = std::max(offset, relative[end].offset.norm());
    for (int k = 0; k < 3; ++k) {
      side.map[end][k] = column(relative[end].linear.col(k));
      for (std::size_t i = 0; i < 4; ++i) side.magnitude[end][k][i] = std::abs(side.map[end][k][i]);
    }
    side.offset[end] = column(relative[end].offset);
  }
  const auto axes = oblique_axes(relative[0].linear);
  for (int k = 0; k < BoxGate::axis_count; ++k) {
    set_axis(side.axis, side.axis_size, k, axes[k]);
    for (int end = 0; end < ends; ++end) {
      set_axis(side.moving[end], side.moving_size[end], k, relative[end].linear.transpose() * axes[k]);
      side.moving_offset[end][k] = static_cast<float>(axes[k].dot(relative[end].offset));
    }
  }

  // With A(t) the map of the body at rest and l(t) the straight line, the moving point p(t) is off by
  // A(t) l(t) - p(t) = t (1 - t) (A1 - A0) (l(0) - l(1)); and A(t) shrinks distances to 1 / |A0^-1| - |A1 - A0| at
  // least.
  double shrink = 1 / norm_bound(maps[0].linear.inverse()), bulge = 0;
  if (ends == 2) {
    const double turn = (maps[1].linear - maps[0].linear).norm();
    const double way = (relative[1].linear - relative[0].linear).norm() * other_radius +
                       (relative[1].offset - relative[0].offset).norm();
    bulge = 0.25 * turn * way * (1 + 1e-9);
    shrink -= turn;
  }
  // 64 units of float roundoff (2^-24) of the sizes, and what underflow may lose.
  const double size = radius + stretch * other_radius + offset;
  const double required = (distance + bulge) / shrink + 0x1p-18 * size + 0x1p-120;
  side.works = shrink > 0.05 && stretch < 1e3 && size < 1e30 && required < 1e30;
  side.gap = std::nextafter(static_cast<float>(side.works ? required : 0), std::numeric_limits<float>::infinity());
  return side;
}

}  // namespace

BoxGate::BoxGate(const PairMotion& motion, double radius_a, double radius_b, double distance)
    : a(make_side(motion.a, motion.b, motion.at_rest ? 1 : 2, radius_a, radius_b, distance)),
      b(make_side(motion.b, motion.a, motion.at_rest ? 1 : 2, radius_b, radius_a, distance)),
      ends(motion.at_rest ? 1 : 2) {}

HWY_EXPORT(visit_leaf_pairs);

bool visit_leaf_pairs(const WideTreeView& a, const WideTreeView& b, std::span<const BoxGate> gates, VisitLeaves visit,
                      void* context) {
  return HWY_DYNAMIC_DISPATCH(visit_leaf_pairs)(a, b, gates, visit, context);
}

}  // namespace encage
#endif

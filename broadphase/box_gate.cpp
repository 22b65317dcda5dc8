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

/// The eight boxes of a node, or as many as a register holds of them.
using Lanes = hn::CappedTag<float, WideNode::width>;
using Register = hn::Vec<Lanes>;
/// The axes of a gate.
using Axes = hn::CappedTag<float, BoxGate::axis_lanes>;

/// A box of one tree, the `lane` of a node: the node's index times the width, plus the lane.
using BoxIndex = std::int32_t;

struct Box {
  std::array<float, 3> centre, half;

  Box(const WideTreeView& tree, BoxIndex index) {
    const WideNode& node = tree.nodes[index / WideNode::width];
    const int lane = index % WideNode::width;
    for (int axis = 0; axis < 3; ++axis) {
      centre[axis] = 0.5F * (node.lower[axis][lane] + node.upper[axis][lane]);
      half[axis] = 0.5F * (node.upper[axis][lane] - node.lower[axis][lane]);
    }
  }
  float size() const { return half[0] * half[0] + half[1] * half[1] + half[2] * half[2]; }
};

/// One box on all axes.
struct Projection {
  alignas(64) std::array<BoxGate::PerAxis, 2> centre;  ///< [end][axis]
  alignas(64) std::array<BoxGate::PerAxis, 2> reach;   ///< [end][axis]; what separation requires, added

  Projection(const BoxGate& gate, const BoxGate::Side& side, const Box& box) {
    const Axes d;
    for (int end = 0; end < gate.ends; ++end) {
      for (std::size_t k = 0; k < BoxGate::axis_lanes; k += hn::Lanes(d)) {
        auto c = hn::Load(d, &side.offset[end][k]);
        auto r = hn::Set(d, gate.gap);
        for (int axis = 0; axis < 3; ++axis) {
          c = hn::Add(c, hn::Mul(hn::Load(d, &side.direction[end][axis][k]), hn::Set(d, box.centre[axis])));
          r = hn::Add(r, hn::Mul(hn::Load(d, &side.size[end][axis][k]), hn::Set(d, box.half[axis])));
        }
        hn::Store(c, d, &centre[end][k]);
        hn::Store(r, d, &reach[end][k]);
      }
    }
  }
};

/// Bits of the lanes of `node`, boxes of `side`, that are not proven apart from the projected box.
std::uint32_t near_lanes(const BoxGate& gate, const BoxGate::Side& side, const WideNode& node,
                         const Projection& other) {
  const Lanes d;
  const Register half = hn::Set(d, 0.5F);
  std::uint32_t result = 0;
  for (std::size_t first = 0; first < WideNode::width; first += hn::Lanes(d)) {
    Register c[3], h[3];
    for (int axis = 0; axis < 3; ++axis) {
      const Register low = hn::LoadU(d, node.lower[axis] + first), high = hn::LoadU(d, node.upper[axis] + first);
      c[axis] = hn::Mul(half, hn::Add(low, high));
      h[axis] = hn::Mul(half, hn::Sub(high, low));
    }
    auto apart = hn::FirstN(d, 0);
    for (int k = 0; k < BoxGate::axis_count; ++k) {
      // The other box beyond the upper side at all ends, or beyond the lower one. Not by minima: NaN must not vanish.
      auto above = hn::FirstN(d, hn::Lanes(d)), below = above;
      for (int end = 0; end < gate.ends; ++end) {
        const auto& u = side.direction[end];
        const auto& s = side.size[end];
        const Register centre = hn::Add(hn::Add(hn::Mul(c[0], hn::Set(d, u[0][k])), hn::Mul(c[1], hn::Set(d, u[1][k]))),
                                        hn::Mul(c[2], hn::Set(d, u[2][k])));
        const Register reach =
            hn::Add(hn::Add(hn::Add(hn::Mul(h[0], hn::Set(d, s[0][k])), hn::Mul(h[1], hn::Set(d, s[1][k]))),
                            hn::Mul(h[2], hn::Set(d, s[2][k]))),
                    hn::Set(d, other.reach[end][k]));
        const Register offset = hn::Sub(hn::Set(d, other.centre[end][k]), centre);
        above = hn::And(above, hn::Gt(offset, reach));
        below = hn::And(below, hn::Gt(hn::Neg(offset), reach));
      }
      apart = hn::Or(apart, hn::Or(above, below));
      if (hn::AllTrue(d, apart)) break;
    }
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Not(apart), bits);
    result |= static_cast<std::uint32_t>(bits[0]) << first;
  }
  std::uint32_t used = 0;
  for (int lane = 0; lane < WideNode::width; ++lane) used |= (node.count[lane] >= 0 ? 1U : 0U) << lane;
  return result & used;
}

class Traversal {
 public:
  Traversal(const WideTreeView& a, const WideTreeView& b, const BoxGate& gate, VisitLeaves visit, void* context)
      : a_(a), b_(b), gate_(gate), visit_(visit), context_(context) {}

  bool run() {
    for (int lane = 0; lane < WideNode::width; ++lane) {
      if (b_.nodes[0].count[lane] >= 0) open_a(0, lane);
    }
    while (size_ > 0) {
      const Pair pair = stack_[--size_];
      const std::int32_t count_a = count(a_, pair.a), count_b = count(b_, pair.b);
      if (count_a > 0 && count_b > 0) {
        if (!visit_(context_, child(a_, pair.a), count_a, child(b_, pair.b), count_b)) return false;
      } else if (count_b > 0 || (count_a == 0 && Box(a_, pair.a).size() >= Box(b_, pair.b).size())) {
        open_a(child(a_, pair.a), pair.b);
      } else {
        open_b(pair.a, child(b_, pair.b));
      }
    }
    return true;
  }

 private:
  struct Pair {
    BoxIndex a, b;
  };
  static constexpr int stack_size = WideNode::width * (2 * WideTree::max_depth + 8);

  static std::int32_t count(const WideTreeView& tree, BoxIndex box) {
    return tree.nodes[box / WideNode::width].count[box % WideNode::width];
  }
  static std::int32_t child(const WideTreeView& tree, BoxIndex box) {
    return tree.nodes[box / WideNode::width].child[box % WideNode::width];
  }

  void open_a(std::int32_t node, BoxIndex b) {
    const Projection projection(gate_, gate_.b, Box(b_, b));
    push(near_lanes(gate_, gate_.a, a_.nodes[node], projection), [&](int lane) {
      return Pair{node * WideNode::width + lane, b};
    });
  }
  void open_b(BoxIndex a, std::int32_t node) {
    const Projection projection(gate_, gate_.a, Box(a_, a));
    push(near_lanes(gate_, gate_.b, b_.nodes[node], projection), [&](int lane) {
      return Pair{a, node * WideNode::width + lane};
    });
  }
  template <class MakePair>
  void push(std::uint32_t lanes, MakePair&& make_pair) {
    for (int lane = WideNode::width - 1; lane >= 0; --lane) {
      if ((lanes >> lane & 1U) != 0) stack_[size_++] = make_pair(lane);
    }
  }

  const WideTreeView& a_;
  const WideTreeView& b_;
  const BoxGate& gate_;
  VisitLeaves visit_;
  void* context_;
  int size_ = 0;
  std::array<Pair, stack_size> stack_;
};

bool visit_leaf_pairs(const WideTreeView& a, const WideTreeView& b, const BoxGate& gate, VisitLeaves visit,
                      void* context) {
  return Traversal(a, b, gate, visit, context).run();
}

}  // namespace encage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace encage {
namespace {

/// Directions in the common frame: the boxes' axes at the start of the interval, and their cross products.
std::array<Eigen::Vector3d, BoxGate::axis_count> axes(const PairMotion& motion) {
  std::array<Eigen::Vector3d, BoxGate::axis_count> all;
  // Normals of the box faces, which a linear map takes to those of its inverse's transpose; motions that
  // shear the boxes much are cut into short intervals, where the columns are near enough.
  for (int i = 0; i < 3; ++i) {
    all[i] = motion.a[0].linear.col(i);
    all[3 + i] = motion.b[0].linear.col(i);
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) all[6 + 3 * i + j] = all[i].cross(all[3 + j]);
  }
  for (Eigen::Vector3d& n : all) {
    const double squared = n.squaredNorm();
    // Unit length, or shorter where nearly parallel axes leave no direction: the gap is then asked of less.
    n *= squared > 1e-12 ? (1 - 1e-9) / std::sqrt(squared) : 0;
  }
  return all;
}

void set_side(BoxGate::Side& side, const std::array<AffineMap, 2>& maps, const std::array<AffineMap, 2>& other,
              const std::array<Eigen::Vector3d, BoxGate::axis_count>& directions, int ends) {
  side = {};
  for (int end = 0; end < ends; ++end) {
    const Eigen::Vector3d offset = maps[end].offset - other[end].offset;
    for (int k = 0; k < BoxGate::axis_count; ++k) {
      const Eigen::Vector3d u = maps[end].linear.transpose() * directions[k];
      for (int axis = 0; axis < 3; ++axis) {
        side.direction[end][axis][k] = static_cast<float>(u[axis]);
        side.size[end][axis][k] = std::abs(side.direction[end][axis][k]);
      }
      side.offset[end][k] = static_cast<float>(directions[k].dot(offset));
    }
  }
}

}  // namespace

BoxGate::BoxGate(const PairMotion& motion, double radius_a, double radius_b, double distance)
    : ends(motion.at_rest ? 1 : 2) {
  const auto directions = axes(motion);
  set_side(a, motion.a, motion.b, directions, ends);
  set_side(b, motion.b, motion.a, directions, ends);
  double offset = 0;
  for (int end = 0; end < ends; ++end) offset = std::max(offset, (motion.b[end].offset - motion.a[end].offset).norm());
  // 32 units of float roundoff (2^-24) of the sizes, and what underflow may lose.
  const double required = distance + 0x1p-19 * (radius_a + radius_b + offset) + 0x1p-120;
  constexpr float infinity = std::numeric_limits<float>::infinity();
  // Sums of larger coordinates could overflow to infinity, which would separate from everything.
  const bool fits = radius_a + radius_b < 0x1p125;
  gap = fits ? std::nextafter(static_cast<float>(required), infinity) : infinity;
}

HWY_EXPORT(visit_leaf_pairs);

bool visit_leaf_pairs(const WideTreeView& a, const WideTreeView& b, const BoxGate& gate, VisitLeaves visit,
                      void* context) {
  return HWY_DYNAMIC_DISPATCH(visit_leaf_pairs)(a, b, gate, visit, context);
}

}  // namespace encage
#endif

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
/// Axes of a gate that are tried together: those of the faces and two more, then the rest.
constexpr int group_size = 8;
using Axes = hn::CappedTag<float, group_size>;

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

/// One box on a group of axes.
struct Projection {
  using Group = std::array<float, group_size>;
  alignas(32) std::array<Group, 2> centre;  ///< [end][axis]
  alignas(32) std::array<Group, 2> reach;   ///< [end][axis]; what separation requires, added

  Projection(const BoxGate& gate, const BoxGate::Side& side, int ends, int first, const Box& box) {
    const Axes d;
    for (int end = 0; end < ends; ++end) {
      for (std::size_t k = 0; k < group_size; k += hn::Lanes(d)) {
        const std::size_t axis_index = static_cast<std::size_t>(first) + k;
        auto c = hn::Load(d, &side.offset[end][axis_index]);
        auto r = hn::Set(d, gate.gap);
        for (int axis = 0; axis < 3; ++axis) {
          c = hn::Add(c, hn::Mul(hn::Load(d, &side.direction[end][axis][axis_index]), hn::Set(d, box.centre[axis])));
          r = hn::Add(r, hn::Mul(hn::Load(d, &side.size[end][axis][axis_index]), hn::Set(d, box.half[axis])));
        }
        hn::Store(c, d, &centre[end][k]);
        hn::Store(r, d, &reach[end][k]);
      }
    }
  }
};

/// The boxes of a node, as many as a register holds, against one box of the other tree.
class LaneTest {
 public:
  LaneTest(const WideNode& node, std::size_t first) {
    const Lanes d;
    const Register half = hn::Set(d, 0.5F);
    for (int axis = 0; axis < 3; ++axis) {
      const Register low = hn::LoadU(d, node.lower[axis] + first), high = hn::LoadU(d, node.upper[axis] + first);
      centre_[axis] = hn::Mul(half, hn::Add(low, high));
      half_[axis] = hn::Mul(half, hn::Sub(high, low));
    }
  }

  /// Lanes that some axis of the group proves apart.
  template <int kEnds>
  auto apart(const BoxGate::Side& side, int own, const Projection& other, int first, int count) const {
    const Lanes d;
    auto result = hn::FirstN(d, 0);
    for (int k = 0; k < count; ++k) {
      // The other box beyond the upper side at all ends, or beyond the lower one. Not by minima: NaN must not vanish.
      auto above = hn::FirstN(d, hn::Lanes(d)), below = above;
      for (int end = 0; end < kEnds; ++end) {
        // At the start of a step a box projects to its own axes as it is.
        const int axis = first + k - own;
        const bool trivial = end == 0 && axis >= 0 && axis < 3;
        const Register centre = trivial ? centre_[axis] : dot(centre_, side.direction[end], first + k);
        const Register reach =
            hn::Add(trivial ? half_[axis] : dot(half_, side.size[end], first + k), hn::Set(d, other.reach[end][k]));
        const Register offset = hn::Sub(hn::Set(d, other.centre[end][k]), centre);
        above = hn::And(above, hn::Gt(offset, reach));
        below = hn::And(below, hn::Gt(hn::Neg(offset), reach));
      }
      result = hn::Or(result, hn::Or(above, below));
      if (hn::AllTrue(d, result)) break;
    }
    return result;
  }

 private:
  static Register dot(const Register (&x)[3], const std::array<BoxGate::PerAxis, 3>& direction, int k) {
    const Lanes d;
    return hn::Add(hn::Add(hn::Mul(x[0], hn::Set(d, direction[0][k])), hn::Mul(x[1], hn::Set(d, direction[1][k]))),
                   hn::Mul(x[2], hn::Set(d, direction[2][k])));
  }

  Register centre_[3], half_[3];
};

/// Bits of the lanes of `node`, boxes of `side`, that are not proven apart from `box`, one of `other`.
template <int kEnds>
std::uint32_t near_lanes(const BoxGate& gate, const BoxGate::Side& side, const WideNode& node,
                         const BoxGate::Side& other, const Box& box) {
  const Lanes d;
  const hn::RebindToSigned<Lanes> di;
  // The second group of axes is worth its work only where the first one leaves lanes.
  const Projection faces(gate, other, kEnds, 0, box);
  std::uint32_t result = 0;
  for (std::size_t first = 0; first < WideNode::width; first += hn::Lanes(d)) {
    const auto used = hn::RebindMask(d, hn::Gt(hn::LoadU(di, node.count + first), hn::Set(di, WideNode::unused)));
    const LaneTest test(node, first);
    auto left = hn::AndNot(test.apart<kEnds>(side, side.own, faces, 0, group_size), used);
    if (hn::AllFalse(d, left)) continue;
    const Projection crosses(gate, other, kEnds, group_size, box);
    left = hn::AndNot(test.apart<kEnds>(side, side.own, crosses, group_size, BoxGate::axis_count - group_size), left);
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, left, bits);
    result |= static_cast<std::uint32_t>(bits[0]) << first;
  }
  return result;
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
    push(near(gate_.a, a_.nodes[node], gate_.b, Box(b_, b)), [&](int lane) {
      return Pair{node * WideNode::width + lane, b};
    });
  }
  void open_b(BoxIndex a, std::int32_t node) {
    push(near(gate_.b, b_.nodes[node], gate_.a, Box(a_, a)), [&](int lane) {
      return Pair{a, node * WideNode::width + lane};
    });
  }
  std::uint32_t near(const BoxGate::Side& side, const WideNode& node, const BoxGate::Side& other,
                     const Box& box) const {
    return gate_.ends == 1 ? near_lanes<1>(gate_, side, node, other, box)
                           : near_lanes<2>(gate_, side, node, other, box);
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
constexpr int no_own_axes = BoxGate::axis_lanes;

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

/// `first`: of the three axes that are the side's own.
void set_side(BoxGate::Side& side, int first, const std::array<AffineMap, 2>& maps,
              const std::array<AffineMap, 2>& other, const std::array<Eigen::Vector3d, BoxGate::axis_count>& directions,
              int ends) {
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
  // Exactly, if the body is rigid at the start of the interval: not where a step was cut.
  bool rigid = true;
  for (int i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      rigid = rigid && std::abs(side.direction[0][axis][first + i] - (axis == i ? 1.0F : 0.0F)) <= 0x1p-23F;
    }
  }
  side.own = rigid ? first : no_own_axes;
}

}  // namespace

BoxGate::BoxGate(const PairMotion& motion, double radius_a, double radius_b, double distance)
    : ends(motion.at_rest ? 1 : 2) {
  const auto directions = axes(motion);
  set_side(a, 0, motion.a, motion.b, directions, ends);
  set_side(b, 3, motion.b, motion.a, directions, ends);
  double offset = 0;
  for (int end = 0; end < ends; ++end) offset = std::max(offset, (motion.b[end].offset - motion.a[end].offset).norm());
  // 64 units of float roundoff (2^-24) of the sizes, and what underflow may lose.
  const double required = distance + 0x1p-18 * (radius_a + radius_b + offset) + 0x1p-120;
  gap = std::nextafter(static_cast<float>(required), std::numeric_limits<float>::infinity());
}

HWY_EXPORT(visit_leaf_pairs);

bool visit_leaf_pairs(const WideTreeView& a, const WideTreeView& b, const BoxGate& gate, VisitLeaves visit,
                      void* context) {
  return HWY_DYNAMIC_DISPATCH(visit_leaf_pairs)(a, b, gate, visit, context);
}

}  // namespace encage
#endif

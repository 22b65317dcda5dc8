// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "broadphase/box_gate.cpp"
#include <hwy/foreach_target.h>  // compiles what follows once for every instruction set

#include "broadphase/box_gate.h"

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace encage::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, WideNode::width>;     // boxes of a node
using Axes = hn::CappedTag<float, BoxGate::axis_lanes>;  // axes of a gate
using Coordinates = hn::CappedTag<float, 4>;             // x, y, z

/// Boxes of a node as numbers.
struct Places {
  alignas(64) float lower[3][WideNode::width];
  alignas(64) float upper[3][WideNode::width];

  HWY_INLINE explicit Places(const WideNode& node) {
    const Lanes d;
    const hn::RebindToSigned<Lanes> di;
    const hn::Rebind<std::int16_t, Lanes> d16;
    for (int axis = 0; axis < 3; ++axis) {
      for (std::size_t k = 0; k < WideNode::width; k += hn::Lanes(d)) {
        hn::Store(hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(d16, node.lower[axis] + k))), d, lower[axis] + k);
        hn::Store(hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(d16, node.upper[axis] + k))), d, upper[axis] + k);
      }
    }
  }
  Places() = default;
};

/// A box of a tree, in places of its grid, with what is below it.
struct Box {
  std::array<float, 3> centre, half;
  float size;  ///< only to compare with the other tree's
  std::uint32_t link;

  Box(const WideTreeView& tree, const Places& places, std::uint32_t below, int lane) : size(0), link(below) {
    for (int axis = 0; axis < 3; ++axis) {
      centre[axis] = 0.5F * (places.lower[axis][lane] + places.upper[axis][lane]);
      half[axis] = 0.5F * (places.upper[axis][lane] - places.lower[axis][lane]);
      const float extent = half[axis] * tree.grid.step[axis];
      size += extent * extent;
    }
  }
  Box() = default;
  int count() const { return WideNode::count_of(link); }
  std::int32_t child() const { return WideNode::child_of(link); }
};

/// Bounds of a moving box over the interval, widened by the gap: a resting box beyond them is apart.
template <std::size_t kCount>
struct Bounds {
  alignas(64) std::array<float, kCount> low;
  alignas(64) std::array<float, kCount> high;
};

/// Projections of a box that moves linearly: `direction` and `size` by [end][coordinate], `offset` by [end].
template <int kEnds, class Tag, class Directions, class Offsets, class Gap, std::size_t kCount>
HWY_INLINE void sweep(Tag d, const Directions& direction, const Directions& size, const Offsets& offset, const Gap& gap,
                      const Box& box, Bounds<kCount>& bounds) {
  for (std::size_t k = 0; k < kCount; k += hn::Lanes(d)) {
    auto low = hn::Zero(d), high = low;
    for (int end = 0; end < kEnds; ++end) {
      auto centre = hn::LoadU(d, offset[end].data() + k);
      auto reach = hn::LoadU(d, gap.data() + k);
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

/// Bits of the lanes that are not apart along a coordinate.
HWY_INLINE std::uint32_t lanes_within(const Places& places, const Bounds<4>& bounds) {
  const Lanes d;
  std::uint32_t result = 0;
  for (std::size_t first = 0; first < WideNode::width; first += hn::Lanes(d)) {
    auto apart = hn::FirstN(d, 0);
    for (int axis = 0; axis < 3; ++axis) {
      apart = hn::Or(apart, hn::Gt(hn::Load(d, places.lower[axis] + first), hn::Set(d, bounds.high[axis])));
      apart = hn::Or(apart, hn::Lt(hn::Load(d, places.upper[axis] + first), hn::Set(d, bounds.low[axis])));
    }
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Not(apart), bits);
    result |= static_cast<std::uint32_t>(bits[0]) << first;
  }
  return result;
}

/// Whether an axis of the gate shows a resting box beyond the bounds.
HWY_INLINE bool separated_by_axis(const BoxGate::Side& side, const Box& box,
                                  const Bounds<BoxGate::axis_lanes>& bounds) {
  const Axes d;
  bool any = false;
  for (std::size_t k = 0; k < BoxGate::axis_lanes; k += hn::Lanes(d)) {
    auto centre = hn::Mul(hn::LoadU(d, &side.axis[0][k]), hn::Set(d, box.centre[0]));
    auto reach = hn::Mul(hn::LoadU(d, &side.axis_size[0][k]), hn::Set(d, box.half[0]));
    for (int i = 1; i < 3; ++i) {
      centre = hn::Add(centre, hn::Mul(hn::LoadU(d, &side.axis[i][k]), hn::Set(d, box.centre[i])));
      reach = hn::Add(reach, hn::Mul(hn::LoadU(d, &side.axis_size[i][k]), hn::Set(d, box.half[i])));
    }
    const auto apart = hn::Or(hn::Gt(hn::Sub(centre, reach), hn::Load(d, &bounds.high[k])),
                              hn::Lt(hn::Add(centre, reach), hn::Load(d, &bounds.low[k])));
    any = any || !hn::AllFalse(d, apart);
  }
  return any;
}

/// Depth first, but several pairs at a time where there are several: their tests do not wait for each other.
class Traversal {
 public:
  Traversal(const WideTreeView& a, const WideTreeView& b, const BoxGate& gate, VisitLeaves visit, void* context)
      : a_(a), b_(b), gate_(gate), visit_(visit), context_(context) {}

  bool run() {
    const WideNode& root = b_.nodes[0];
    const Places places(root);
    for (int lane = 0; lane < WideNode::width; ++lane) {
      if (root.count(lane) == WideNode::unused) continue;
      tasks_[0].set(Box(b_, places, root.link[lane], lane), a_.nodes[0], true);
      open(1);
    }
    while (size_ > 0) {
      const int taken = size_ > crowded ? 1 : std::min(size_, batch);
      int opened = 0;
      for (int i = 0; i < taken; ++i) {
        const Pair& pair = stack_[--size_];
        const int count_a = pair.a.count(), count_b = pair.b.count();
        if (count_a > 0 && count_b > 0) {
          if (!visit_(context_, pair.a.child(), count_a, pair.b.child(), count_b)) return false;
          continue;
        }
        const bool open_a = count_b > 0 || (count_a == 0 && pair.a.size >= pair.b.size);
        tasks_[opened++].set(open_a ? pair.b : pair.a, open_a ? a_.nodes[pair.a.child()] : b_.nodes[pair.b.child()],
                             open_a);
      }
      open(opened);
    }
    return true;
  }

 private:
  struct Pair {
    Box a, b;
  };
  /// A node whose boxes are tested, at rest, against a moving box of the other tree.
  struct Task {
    Places places;
    Box moving;
    const WideNode* node;
    bool opens_a;

    HWY_INLINE void set(const Box& box, const WideNode& opened, bool of_a) {
      places = Places(opened);
      moving = box;
      node = &opened;
      opens_a = of_a;
    }
  };
  static constexpr int batch = 8;
  static constexpr int crowded = 256;  // from here on one at a time, which bounds the stack
  static constexpr int stack_size = crowded + WideNode::width * (batch + 2 * WideTree::max_depth + 8);

  /// Puts on the stack what the first `count` tasks do not prove apart.
  void open(int count) {
    std::array<std::uint32_t, batch> near{};
    if (gate_.ends == 1) {
      find_near<1>(count, near);
    } else {
      find_near<2>(count, near);
    }
    for (int i = count - 1; i >= 0; --i) {
      const Task& task = tasks_[i];
      // The first lane on top.
      for (std::uint32_t left = near[i]; left != 0;) {
        const int lane = 31 - __builtin_clz(left);
        left &= ~(1U << lane);
        const WideTreeView& tree = task.opens_a ? a_ : b_;
        const Box box(tree, task.places, task.node->link[lane], lane);
        prefetch(tree, box);
        stack_[size_++] = task.opens_a ? Pair{box, task.moving} : Pair{task.moving, box};
      }
    }
  }

  /// What is below a box will be wanted soon.
  static void prefetch(const WideTreeView& tree, const Box& box) {
    if (box.count() > 0) {
      hwy::Prefetch(&tree.leaves[box.child()]);
    } else {
      hwy::Prefetch(&tree.nodes[box.child()]);
      hwy::Prefetch(tree.nodes[box.child()].link);
    }
  }

  /// Bits of the lanes of the tasks' nodes that the gate does not prove apart.
  template <int kEnds>
  void find_near(int count, std::array<std::uint32_t, batch>& near) const {
    std::array<std::uint32_t, batch> within;
    for (int i = 0; i < count; ++i) {
      const Task& task = tasks_[i];
      const BoxGate::Side& side = task.opens_a ? gate_.a : gate_.b;
      Bounds<4> swept;
      sweep<kEnds>(Coordinates(), side.map, side.magnitude, side.offset, side.place_gap, task.moving, swept);
      within[i] = side.works ? lanes_within(task.places, swept) : (1U << WideNode::width) - 1;
    }
    for (int i = 0; i < count; ++i) {
      if (within[i] == 0) continue;
      const Task& task = tasks_[i];
      const BoxGate::Side& side = task.opens_a ? gate_.a : gate_.b;
      Bounds<BoxGate::axis_lanes> projected;
      sweep<kEnds>(Axes(), side.moving, side.moving_size, side.moving_offset, side.gap, task.moving, projected);
      for (std::uint32_t left = within[i]; left != 0; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        const bool used = task.node->count(lane) != WideNode::unused;
        const Box box(task.opens_a ? a_ : b_, task.places, task.node->link[lane], lane);
        const bool apart = side.works && separated_by_axis(side, box, projected);
        near[i] |= static_cast<std::uint32_t>(used && !apart) << lane;
      }
    }
  }

  const WideTreeView& a_;
  const WideTreeView& b_;
  const BoxGate& gate_;
  VisitLeaves visit_;
  void* context_;
  int size_ = 0;
  std::array<Task, batch> tasks_;
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

using Vector = Eigen::Vector3d;
using Matrix = Eigen::Matrix3d;

/// Upper bound of the spectral norm, tight for what is nearly a rotation.
double norm_bound(const Matrix& m) {
  return std::sqrt(1 + (m.transpose() * m - Matrix::Identity()).norm()) * (1 + 1e-14);
}

Vector as_vector(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

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
BoxGate::Side make_side(const std::array<AffineMap, 2>& maps, const GateBody& body,
                        const std::array<AffineMap, 2>& others, const GateBody& other, int ends, double distance) {
  BoxGate::Side side{};
  // Local coordinates are middle + step * stored place.
  const Vector step = as_vector(body.grid.step), middle = as_vector(body.grid.middle);
  const Vector other_step = as_vector(other.grid.step), other_middle = as_vector(other.grid.middle);
  std::array<AffineMap, 2> relative;
  double stretch = 1, offset = 0;
  bool finite = true;  // NaN would not survive the maxima
  for (int end = 0; end < ends; ++end) {
    const Matrix inverse = maps[end].linear.inverse();
    relative[end] = {inverse * others[end].linear, inverse * (others[end].offset - maps[end].offset)};
    finite = finite && relative[end].linear.allFinite() && relative[end].offset.allFinite();
    stretch = std::max(stretch, norm_bound(relative[end].linear));
    offset = std::max(offset, relative[end].offset.norm());
    for (int k = 0; k < 3; ++k) {
      side.map[end][k] = column((relative[end].linear.col(k) * other_step[k]).cwiseQuotient(step));
      for (std::size_t i = 0; i < 4; ++i) side.magnitude[end][k][i] = std::abs(side.map[end][k][i]);
    }
    side.offset[end] = column((relative[end](other_middle) - middle).cwiseQuotient(step));
  }
  const auto axes = oblique_axes(relative[0].linear);
  for (int k = 0; k < BoxGate::axis_count; ++k) {
    set_axis(side.axis, side.axis_size, k, axes[k].cwiseProduct(step));
    for (int end = 0; end < ends; ++end) {
      const Vector seen = relative[end].linear.transpose() * axes[k];
      set_axis(side.moving[end], side.moving_size[end], k, seen.cwiseProduct(other_step));
      side.moving_offset[end][k] = static_cast<float>(axes[k].dot(relative[end](other_middle) - middle));
    }
  }

  // With A(t) the map of the body at rest and l(t) the straight line, the moving point p(t) is off by
  // A(t) l(t) - p(t) = t (1 - t) (A1 - A0) (l(0) - l(1)); and A(t) shrinks distances to 1 / |A0^-1| - |A1 - A0| at
  // least.
  double shrink = 1 / norm_bound(maps[0].linear.inverse()), bulge = 0;
  if (ends == 2) {
    const double turn = (maps[1].linear - maps[0].linear).norm();
    const double way = (relative[1].linear - relative[0].linear).norm() * other.radius +
                       (relative[1].offset - relative[0].offset).norm();
    bulge = 0.25 * turn * way * (1 + 1e-9);
    shrink -= turn;
  }
  // 128 units of float roundoff (2^-24) of the sizes, and what underflow may lose.
  const double size = body.radius + middle.norm() + stretch * (other.radius + other_middle.norm()) + offset;
  const double gap = (distance + bulge) / shrink + 0x1p-17 * size + 0x1p-120;
  // Sums of places must stay finite as well: infinity has lost what would be subtracted from it.
  const double least_step = std::min(1.0, step.minCoeff());
  side.works = finite && shrink > 0.05 && stretch < 1e3 && size < 1e30 * least_step && gap < 1e30 * least_step;
  if (!side.works) return side;
  side.gap.fill(std::nextafter(static_cast<float>(gap), std::numeric_limits<float>::infinity()));
  side.place_gap = column(Vector::Constant(gap * (1 + 0x1p-22)).cwiseQuotient(step));
  return side;
}

}  // namespace

BoxGate::BoxGate(const PairMotion& motion, const GateBody& body_a, const GateBody& body_b, double distance)
    : a(make_side(motion.a, body_a, motion.b, body_b, motion.at_rest ? 1 : 2, distance)),
      b(make_side(motion.b, body_b, motion.a, body_a, motion.at_rest ? 1 : 2, distance)),
      ends(motion.at_rest ? 1 : 2) {}

HWY_EXPORT(visit_leaf_pairs);

bool visit_leaf_pairs(const WideTreeView& a, const WideTreeView& b, const BoxGate& gate, VisitLeaves visit,
                      void* context) {
  return HWY_DYNAMIC_DISPATCH(visit_leaf_pairs)(a, b, gate, visit, context);
}

}  // namespace encage
#endif

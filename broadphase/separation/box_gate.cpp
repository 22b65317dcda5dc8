// SPDX-License-Identifier: Apache-2.0
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "broadphase/separation/box_gate.cpp"
#include <hwy/foreach_target.h>  // compiles the following once for every instruction set

#include "broadphase/separation/box_gate.h"
#include "broadphase/separation/tree_boxes-inl.h"

#include <hwy/highway.h>
// clang-format on

#include <algorithm>
#include <cmath>
#include <limits>

#ifndef ENCAGE_BOX_GATE_PACKING  // only once, not for each instruction set
#define ENCAGE_BOX_GATE_PACKING
namespace encage {
namespace {

/// For every set of lanes: their number, and their indices in order, followed by zeros.
struct PackingTable {
  std::array<std::uint8_t, 256> counts = {};
  std::array<std::array<std::int32_t, 8>, 256> indices = {};
};

constexpr PackingTable packing = [] {
  PackingTable table;
  for (unsigned bits = 0; bits < 256; ++bits) {
    for (std::int32_t lane = 0; lane < 8; ++lane) {
      if ((bits >> lane & 1U) != 0) table.indices[bits][table.counts[bits]++] = lane;
    }
  }
  return table;
}();

}  // namespace
}  // namespace encage
#endif

HWY_BEFORE_NAMESPACE();
namespace encage::HWY_NAMESPACE {

namespace {

using Lanes = NodeLanes<float>;
using Axes = hn::CappedTag<float, BoxGate::Side::lanes>;
using Numbers = hn::RebindToUnsigned<Lanes>;
using Vec = hn::Vec<Lanes>;
using Box = TreeBox<float>;
using Boxes = TreeBoxes<float>;

/// The intervals that a moving box covers on the axes, widened by the gap: a resting box beyond them is apart.
struct Swept {
  alignas(32) float low[BoxGate::Side::lanes];
  alignas(32) float high[BoxGate::Side::lanes];
};

template <int kEnds>
HWY_INLINE void sweep(const BoxGate::Side& side, const Box& box, Swept& swept) {
  const Axes d;
  for (std::size_t k = 0; k < BoxGate::Side::lanes; k += hn::Lanes(d)) {
    auto low = hn::Zero(d), high = low;
    for (int end = 0; end < kEnds; ++end) {
      auto centre = hn::LoadU(d, side.moving_offset[end].data() + k);
      auto reach = hn::LoadU(d, side.gap.data() + k);
      for (int i = 0; i < 3; ++i) {
        centre = hn::Add(centre, hn::Mul(hn::LoadU(d, side.moving[end][i].data() + k), hn::Set(d, box.centre[i])));
        reach = hn::Add(reach, hn::Mul(hn::LoadU(d, side.moving_size[end][i].data() + k), hn::Set(d, box.half[i])));
      }
      low = end == 0 ? hn::Sub(centre, reach) : hn::Min(low, hn::Sub(centre, reach));
      high = end == 0 ? hn::Add(centre, reach) : hn::Max(high, hn::Add(centre, reach));
    }
    hn::StoreU(low, d, swept.low + k);
    hn::StoreU(high, d, swept.high + k);
  }
}

/// The interval that the moving box covers along the normal of its slab.
struct SweptSlab {
  float half_normal[3];  ///< in the resting frame, halved
  float low, high;
};

template <int kEnds>
HWY_INLINE SweptSlab sweep_slab(const BoxGate::Side& side, const Box& box) {
  SweptSlab swept;
  std::array<float, 3> normal;
  const auto& [u, v, w] = side.map[0];
  for (int i = 0; i < 3; ++i) {
    normal[i] = side.normal_scale * (u[i] * box.normal[0] + v[i] * box.normal[1] + w[i] * box.normal[2]);
    swept.half_normal[i] = 0.5F * normal[i];
  }
  for (int end = 0; end < kEnds; ++end) {
    float centre = box.height, reach = box.thickness + side.moving_slab_gap;
    for (int i = 0; i < 3; ++i) {
      centre += normal[i] * side.offset[end][i];
      if (kEnds == 1) continue;  // valid because both maps are nearly rigid
      // Seen from the moving box, the axis is its slab's normal plus a remainder, which the box bounds.
      const BoxGate::Column& axis = side.map[end][i];
      const float rest = axis[0] * normal[0] + axis[1] * normal[1] + axis[2] * normal[2] - box.normal[i];
      centre += rest * box.centre[i];
      reach += std::abs(rest) * box.half[i];
    }
    swept.low = end == 0 ? centre - reach : std::min(swept.low, centre - reach);
    swept.high = end == 0 ? centre + reach : std::max(swept.high, centre + reach);
  }
  return swept;
}

/// The interval that the moving box covers along an axis no longer than 1, widened by the gap.
struct SweptAxis {
  float half_direction[3];  ///< in the resting frame, halved
  float low, high;
};

/// Takes the direction from a point at rest to the middle of the moving box's way: where boxes are small beside the
/// gap, it tells apart what their own axes do not.
template <int kEnds>
HWY_INLINE SweptAxis sweep_towards(const BoxGate::Side& side, const Box& box, const float* from, const Swept& swept) {
  SweptAxis axis;
  float direction[3], squared = 0;
  for (int i = 0; i < 3; ++i) {
    direction[i] = 0.5F * (swept.low[i] + swept.high[i]) - from[i];
    squared += direction[i] * direction[i];
  }
  const float scale = squared > 1e-20F ? (1 - 0x1p-20F) / std::sqrt(squared) : 0;
  for (int i = 0; i < 3; ++i) {
    direction[i] *= scale;
    axis.half_direction[i] = 0.5F * direction[i];
  }
  for (int end = 0; end < kEnds; ++end) {
    float centre = 0, reach = side.gap[0];
    for (int i = 0; i < 3; ++i) {
      const BoxGate::Column& column = side.map[end][i];
      const float seen = column[0] * direction[0] + column[1] * direction[1] + column[2] * direction[2];
      centre += direction[i] * side.offset[end][i];
      centre += seen * box.centre[i];
      reach += std::abs(seen) * box.half[i];
    }
    axis.low = end == 0 ? centre - reach : std::min(axis.low, centre - reach);
    axis.high = end == 0 ? centre + reach : std::max(axis.high, centre + reach);
  }
  return axis;
}

/// Lanes whose interval [centre - reach, centre + reach] lies beyond [low, high].
HWY_INLINE hn::Mask<Lanes> beyond(Vec centre, Vec reach, Vec low, Vec high) {
  return hn::Or(hn::Gt(hn::Sub(centre, reach), high), hn::Lt(hn::Add(centre, reach), low));
}

/// Lanes whose boxes lie beyond the moving slab on one side.
HWY_INLINE hn::Mask<Lanes> beyond_slab(const Boxes& boxes, const SweptSlab& slab) {
  const Lanes d;
  Vec centre, reach;
  boxes.cover(slab.half_normal, centre, reach);
  return beyond(centre, reach, hn::Set(d, slab.low), hn::Set(d, slab.high));
}

/// Moves the lanes of a mask to the front, in order. (For Highway's Compress, g++ copies the table onto the stack at
/// each use on AVX2.)
class Packing {
 public:
  HWY_INLINE explicit Packing(hn::Mask<Numbers> mask) {
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(Numbers(), mask, bits);
    count_ = packing.counts[bits[0]];
    indices_ = hn::SetTableIndices(Numbers(), packing.indices[bits[0]].data());
  }
  HWY_INLINE hn::Vec<Numbers> operator()(hn::Vec<Numbers> v) const { return hn::TableLookupLanes(v, indices_); }
  HWY_INLINE Vec operator()(Vec v) const { return hn::BitCast(Lanes(), (*this)(hn::BitCast(Numbers(), v))); }
  std::size_t count() const { return count_; }

 private:
  std::size_t count_;
  decltype(hn::SetTableIndices(Numbers(), static_cast<const std::int32_t*>(nullptr))) indices_;
};

/// Tests a moving box against the boxes of a node at rest.
template <int kEnds>
class LaneTest {
 public:
  HWY_INLINE LaneTest(const BoxGate::Side& side, const Box& moving)
      : side_(side), slab_(sweep_slab<kEnds>(side, moving)) {
    sweep<kEnds>(side, moving, swept_);
  }

  /// Boxes whose bounds along an axis of the node prove them apart.
  HWY_INLINE hn::Mask<Lanes> apart_along(int axis, Vec lower, Vec upper) const {
    const Lanes d;
    return hn::Or(hn::Gt(lower, hn::Set(d, swept_.high[axis])), hn::Lt(upper, hn::Set(d, swept_.low[axis])));
  }

  /// Boxes that the other axes, or `result`, prove apart.
  HWY_INLINE hn::Mask<Lanes> apart(const Boxes& boxes, hn::Mask<Lanes> result) const {
    const Lanes d;
    for (int axis = 0; axis < 3; ++axis) {
      const float* const n = side_.oblique[axis].data();
      result = hn::Or(result, beyond(dot(boxes.sum, n), boxes.reach_along(n), hn::Set(d, swept_.low[4 + axis]),
                                     hn::Set(d, swept_.high[4 + axis])));
    }
    return hn::Or(result, beyond_slab(boxes, slab_));
  }

  /// Boxes that the direction from `point` to the moving box proves apart.
  HWY_INLINE hn::Mask<Lanes> apart_towards(const Boxes& boxes, const Box& moving, const float* point) const {
    const Lanes d;
    const SweptAxis axis = sweep_towards<kEnds>(side_, moving, point, swept_);
    return beyond(dot(boxes.sum, axis.half_direction), boxes.reach_along(axis.half_direction), hn::Set(d, axis.low),
                  hn::Set(d, axis.high));
  }

 private:
  const BoxGate::Side& side_;
  SweptSlab slab_;
  Swept swept_;
};

/// Depth first. Of a pair of boxes the larger one is opened.
template <int kEnds>
class LeafPairTraversal {
 public:
  LeafPairTraversal(const MeshTreeView& a, const MeshTreeView& b, const BoxGate& gate, std::int64_t& steps)
      : trees_{&a, &b}, sides_{&gate.a, &gate.b}, steps_(steps) {}

  bool run(VisitLeaves visit, void* context) {
    // The traversal starts with all of b against the boxes of a's root, and opens b's root next.
    open(0, 0, 0, {0, 0, std::numeric_limits<float>::infinity()}, Box::around(trees_[1]->nodes[0]));
    while (size_ > 0) {
      if (steps_ < 0) return false;
      // Several tests run together, because they do not wait for each other's results.
      const std::size_t taken = std::min(size_, size_ > crowded ? std::size_t{1} : batch);
      std::array<Task, batch> tasks;
      std::size_t count = 0;
      steps_ -= static_cast<std::int64_t>(taken);
      for (std::size_t i = 0; i < taken; ++i) {
        --size_;
        const std::uint32_t link_a = stack_[0].link[size_], link_b = stack_[1].link[size_];
        const int count_a = MeshNode::count_of(link_a), count_b = MeshNode::count_of(link_b);
        if (count_a > 0 && count_b > 0) {
          if (!visit(context, MeshNode::child_of(link_a), count_a, MeshNode::child_of(link_b), count_b)) return false;
          continue;
        }
        // The choice uses no branch, because it is unpredictable.
        const bool larger_a = stack_[0].size[size_] >= stack_[1].size[size_];
        const std::size_t opened = 1 - static_cast<std::size_t>((count_b > 0) | ((count_a == 0) & larger_a));
        const Column& other = stack_[1 - opened];
        tasks[count++] = {opened,
                          MeshNode::child_of(stack_[opened].link[size_]),
                          stack_[opened].slot[size_],
                          {other.link[size_], other.slot[size_], other.size[size_]}};
      }
      while (count > 0) {
        --count;
        const auto& [opened, node, slot, other] = tasks[count];
        open(opened, node, slot, other,
             Box(trees_[1 - opened]->nodes[other.slot / MeshNode::width], other.slot % MeshNode::width));
      }
    }
    return true;
  }

 private:
  /// A box of a tree.
  struct Ref {
    std::uint32_t link;
    std::uint32_t slot;  ///< node * width + lane
    float size;
  };
  /// A node to open, and the box that is tested against the boxes in it.
  struct Task {
    std::size_t opened;
    std::int32_t node;
    std::uint32_t slot;  ///< of the box around the node
    Ref other;
  };
  static constexpr std::size_t batch = 4;
  static constexpr std::size_t crowded = 256;  // beyond this size tests run one at a time, which bounds the stack
  // Stores write up to one vector beyond the top.
  static constexpr std::size_t stack_size = crowded + MeshNode::width * (batch + 2 * MeshTree::max_depth + 9);
  /// One tree's boxes of all pairs on the stack.
  struct Column {
    std::array<std::uint32_t, stack_size> link, slot;
    std::array<float, stack_size> size;
  };

  /// Tests the boxes of a node of tree `resting` against a box of the other tree, and pushes those that are not proven
  /// apart.
  HWY_INLINE void open(std::size_t resting, std::int32_t index, std::uint32_t own_slot, Ref other, const Box& moving) {
    const Lanes d;
    const Numbers du;
    const BoxGate::Side& side = *sides_[resting];
    const MeshNode& node = trees_[resting]->nodes[index];
    const LaneTest<kEnds> test(side, moving);
    const auto step = hn::Set(d, side.step);
    Column &rests = stack_[resting], &moves = stack_[1 - resting];
    for (std::size_t first = 0; first < MeshNode::width; first += hn::Lanes(d)) {
      auto apart = hn::FirstN(d, 0);
      const Boxes boxes(node, first, [&](int axis, Vec lower, Vec upper) HWY_ATTR {
        apart = hn::Or(apart, test.apart_along(axis, lower, upper));
      });
      apart = test.apart(boxes, apart);
      if (side.far) {
        const Box own(trees_[resting]->nodes[own_slot / MeshNode::width], own_slot % MeshNode::width);
        apart = hn::Or(apart, test.apart_towards(boxes, moving, own.centre));
      }
      const auto link = hn::LoadU(du, node.link + first);
      const auto used = hn::Lt(link, hn::Set(du, MeshNode::unused_link));
      const auto near = side.works ? hn::AndNot(hn::RebindMask(du, apart), used) : used;
      const auto slot =
          hn::Iota(du, static_cast<std::uint32_t>(index) * MeshNode::width + static_cast<std::uint32_t>(first));
      const Packing pack(near);
      hn::StoreU(pack(link), du, rests.link.data() + size_);
      hn::StoreU(pack(slot), du, rests.slot.data() + size_);
      hn::StoreU(pack(hn::Mul(boxes.sizes(), step)), d, rests.size.data() + size_);
      hn::StoreU(hn::Set(du, other.link), du, moves.link.data() + size_);
      hn::StoreU(hn::Set(du, other.slot), du, moves.slot.data() + size_);
      hn::StoreU(hn::Set(d, other.size), d, moves.size.data() + size_);
      size_ += pack.count();
    }
  }

  std::array<const MeshTreeView*, 2> trees_;   // a, b
  std::array<const BoxGate::Side*, 2> sides_;  // indexed by the tree at rest
  std::int64_t& steps_;
  std::size_t size_ = 0;
  std::array<Column, 2> stack_;
};

}  // namespace

bool visit_leaf_pairs(const MeshTreeView& a, const MeshTreeView& b, const BoxGate& gate, VisitLeaves visit,
                      void* context, std::int64_t& steps) {
  return gate.ends == 1 ? LeafPairTraversal<1>(a, b, gate, steps).run(visit, context)
                        : LeafPairTraversal<2>(a, b, gate, steps).run(visit, context);
}

}  // namespace encage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace encage {
namespace {

using Vector = Eigen::Vector3d;
using Matrix = Eigen::Matrix3d;

/// Upper bound of the spectral norm, tight for maps that are nearly rotations.
double norm_bound(const Matrix& m) {
  return std::sqrt(1 + (m.transpose() * m - Matrix::Identity()).norm()) * (1 + 1e-14);
}

/// Bounds the length of a rounded normal.
constexpr double longest_normal = MeshNode::normal_size + 1;

Vector as_vector(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

BoxGate::Column column(const Vector& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

void set_column(std::array<BoxGate::Side::PerAxis, 3>& axes, std::array<BoxGate::Side::PerAxis, 3>& sizes, int k,
                const Vector& n) {
  for (int i = 0; i < 3; ++i) {
    axes[i][k] = static_cast<float>(n[i]);
    sizes[i][k] = std::abs(axes[i][k]);
  }
}

/// Takes the maps to the common frame at both ends of the interval: `maps` of the body at rest, `others` of the moving
/// one.
BoxGate::Side make_side(const std::array<AffineMap, 2>& maps, const GateBody& body,
                        const std::array<AffineMap, 2>& others, const GateBody& other, int ends, double distance,
                        bool directions) {
  BoxGate::Side side{};
  // Local coordinates are middle + step * grid coordinate.
  const double step = body.scale * static_cast<double>(body.grid.step);
  const double ratio = other.scale * static_cast<double>(other.grid.step) / step;
  const double radius = body.scale * body.radius, other_radius = other.scale * other.radius;
  const Vector middle = body.scale * as_vector(body.grid.middle);
  const Vector other_middle = other.scale * as_vector(other.grid.middle);
  std::array<AffineMap, 2> relative;
  double stretch = 1, offset = 0, shrink = 1;
  bool finite = true;  // a flag, because maxima lose NaN
  for (int end = 0; end < ends; ++end) {
    const bool identity = maps[end].linear == Matrix::Identity();
    const Matrix inverse = identity ? Matrix(Matrix::Identity()) : Matrix(maps[end].linear.inverse());
    if (end == 0 && !identity) shrink = 1 / norm_bound(inverse);
    relative[end] = {inverse * others[end].linear, inverse * (others[end].offset - maps[end].offset)};
    finite = finite && relative[end].linear.allFinite() && relative[end].offset.allFinite();
    stretch = std::max(stretch, norm_bound(relative[end].linear));
    offset = std::max(offset, relative[end].offset.norm());
  }
  // The other body's axes at the start. Their lengths are below 1 in spite of rounding.
  const Matrix axes = relative[0].linear * ((1 - 1e-6) / stretch);
  for (int end = 0; end < ends; ++end) {
    const Vector origin = (relative[end](other_middle) - middle) / step;
    side.offset[end] = column(origin);
    for (int k = 0; k < 3; ++k) {
      side.map[end][k] = column(relative[end].linear.col(k) * ratio);
      set_column(side.moving[end], side.moving_size[end], k, relative[end].linear.row(k).transpose() * ratio);
      side.moving_offset[end][k] = static_cast<float>(origin[k]);
      set_column(side.moving[end], side.moving_size[end], 4 + k,
                 relative[end].linear.transpose() * axes.col(k) * ratio);
      side.moving_offset[end][4 + k] = static_cast<float>(axes.col(k).dot(origin));
    }
  }

  // With A(t) the map of the body at rest and l(t) the straight line, the moving point p(t) is off by A(t) l(t) - p(t)
  // = t (1 - t) (A1 - A0) (l(0) - l(1)); and A(t) shrinks distances to no less than 1 / |A0^-1| - |A1 - A0|.
  double bulge = 0;
  if (ends == 2) {
    const double turn = (maps[1].linear - maps[0].linear).norm();
    const double way = (relative[1].linear - relative[0].linear).norm() * other_radius +
                       (relative[1].offset - relative[0].offset).norm();
    bulge = 0.25 * turn * way * (1 + 1e-9);
    shrink -= turn;
  }
  // 128 units of float roundoff (2^-24) of the sizes, and the loss by underflow.
  const double size = radius + middle.norm() + stretch * (other_radius + other_middle.norm()) + offset;
  const double gap = (distance + bulge) / shrink + 0x1p-17 * size + 0x1p-120;
  // Sums of grid coordinates must stay finite as well, because a difference of infinities proves nothing.
  const bool rigid = ends == 2 || stretch < 1 + 1e-8;  // sweep_slab() relies on it for bodies at rest
  side.works = finite && rigid && shrink > 0.05 && stretch < 1e3 && ratio > 1e-10 && ratio < 1e10 &&
               size < 1e28 * std::min(1.0, step) && gap < 1e28 * std::min(1.0, step);
  if (!side.works) return side;
  const double grid_gap = gap / step * (1 + 0x1p-22);
  side.gap.fill(std::nextafter(static_cast<float>(grid_gap), std::numeric_limits<float>::infinity()));
  side.far = directions && grid_gap > 256;
  side.step = static_cast<float>(step);
  side.normal_scale = static_cast<float>(1 / (ratio * ratio));
  side.moving_slab_gap = static_cast<float>(grid_gap * longest_normal * stretch / ratio * (1 + 0x1p-20));
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) side.oblique[k][i] = static_cast<float>(0.5 * axes(i, k));
  }
  return side;
}

}  // namespace

BoxGate::BoxGate(const PairMotion& motion, const GateBody& body_a, const GateBody& body_b, double distance,
                 bool directions)
    : a(make_side(motion.a, body_a, motion.b, body_b, motion.at_rest ? 1 : 2, distance, directions)),
      b(make_side(motion.b, body_b, motion.a, body_a, motion.at_rest ? 1 : 2, distance, directions)),
      ends(motion.at_rest ? 1 : 2) {}

HWY_EXPORT(visit_leaf_pairs);

bool visit_leaf_pairs(const MeshTreeView& a, const MeshTreeView& b, const BoxGate& gate, VisitLeaves visit,
                      void* context, std::int64_t* steps) {
  std::int64_t unlimited = std::numeric_limits<std::int64_t>::max();
  return HWY_DYNAMIC_DISPATCH(visit_leaf_pairs)(a, b, gate, visit, context, steps == nullptr ? unlimited : *steps);
}

}  // namespace encage
#endif

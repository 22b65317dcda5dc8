// SPDX-License-Identifier: Apache-2.0
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "broadphase/distance/box_distance.cpp"
#include <hwy/foreach_target.h>  // compiles the following once for every instruction set

#include "broadphase/distance/box_distance.h"
#include "broadphase/separation/tree_boxes-inl.h"

#include <hwy/highway.h>
// clang-format on

#include <cmath>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace encage::HWY_NAMESPACE {

namespace {

using Lanes = NodeLanes<double>;
using Vec = hn::Vec<Lanes>;
using Box = TreeBox<double>;
using Boxes = TreeBoxes<double>;
using Vec3 = std::array<double, 3>;

HWY_INLINE double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
HWY_INLINE double dot(const Vec3& a, const Vec3& b) { return dot(a.data(), b.data()); }

/// An axis in the opened body's frame, and the interval on it that a box of the other body covers.
struct Axis {
  Vec3 direction;
  double low, high;
  double scale;  ///< 1 / length, or 0
};

/// The intervals that a box of the other tree covers on all axes.
struct Covered {
  std::array<double, BoxDistance::Side::axes> low, high;
  Axis slab;    ///< along the normal of the box's slab
  Axis middle;  ///< towards `target`, in grid coordinates of the opened tree

  Covered(const BoxDistance::Side& side, const Box& box, const double* target) {
    for (int k = 0; k < BoxDistance::Side::axes; ++k) {
      double centre = side.other_offset[k], reach = 0;
      for (int i = 0; i < 3; ++i) {
        centre += side.other[i][k] * box.centre[i];
        reach += side.other_size[i][k] * box.half[i];
      }
      low[k] = centre - reach;
      high[k] = centre + reach;
    }
    for (int i = 0; i < 3; ++i) {
      slab.direction[i] =
          side.turned[0][i] * box.normal[0] + side.turned[1][i] * box.normal[1] + side.turned[2][i] * box.normal[2];
      middle.direction[i] = target[i] - 0.5 * (low[i] + high[i]);
    }
    cover(slab, dot(slab.direction, side.offset) + side.ratio * box.height, side.ratio * box.thickness);
    // Seen from the other body, the axis is the sum of a part along its slab's normal, which the slab bounds, and a
    // remainder, which the box bounds.
    const Vec3 seen = {dot(side.turned[0], middle.direction), dot(side.turned[1], middle.direction),
                       dot(side.turned[2], middle.direction)};
    const double part = dot(box.normal, seen.data()) * normal_weight<double>;
    double centre = part * box.height, reach = std::abs(part) * box.thickness;
    for (int i = 0; i < 3; ++i) {
      const double rest = seen[i] - part * box.normal[i];
      centre += rest * box.centre[i];
      reach += std::abs(rest) * box.half[i];
    }
    cover(middle, dot(middle.direction, side.offset) + side.ratio * centre, side.ratio * reach);
  }

 private:
  static void cover(Axis& axis, double centre, double reach) {
    axis.low = centre - reach;
    axis.high = centre + reach;
    const double squared = dot(axis.direction, axis.direction);
    axis.scale = squared > 0 ? 1 / std::sqrt(squared) : 0;
  }
};

/// Signed gap between [lower, upper] and [low, high].
HWY_INLINE Vec gap_between(Vec lower, Vec upper, double low, double high) {
  const Lanes d;
  return hn::Max(hn::Sub(lower, hn::Set(d, high)), hn::Sub(hn::Set(d, low), upper));
}

/// Signed gap along any axis.
HWY_INLINE Vec gap_along(const Boxes& boxes, const Axis& axis) {
  const Lanes d;
  const Vec3 half = {0.5 * axis.direction[0], 0.5 * axis.direction[1], 0.5 * axis.direction[2]};
  Vec centre, reach;
  boxes.cover(half.data(), centre, reach);
  return hn::Mul(gap_between(hn::Sub(centre, reach), hn::Add(centre, reach), axis.low, axis.high),
                 hn::Set(d, axis.scale));
}

/// Returns lower bounds of distances, in grid steps, where they are positive. Elsewhere the values only measure how
/// much boxes overlap.
HWY_INLINE Vec distances(const BoxDistance::Side& side, const MeshNode& node, std::size_t first, const Covered& box,
                         Vec& sizes) {
  const Lanes d;
  auto widest = hn::Set(d, -std::numeric_limits<double>::infinity());
  auto squared = hn::Zero(d), squared_other = squared;
  const auto add = [&](Vec gap, Vec& sum) HWY_ATTR {
    widest = hn::Max(widest, gap);
    const auto positive = hn::Max(gap, hn::Zero(d));
    sum = hn::Add(sum, hn::Mul(positive, positive));
  };
  const Boxes boxes(node, first, [&](int k, Vec lower, Vec upper) HWY_ATTR {
    add(gap_between(lower, upper, box.low[k], box.high[k]), squared);
  });
  sizes = boxes.sizes();
  for (int k = 0; k < 3; ++k) {
    const std::array<double, 3>& axis = side.turned[k];
    const auto centre = dot(boxes.sum, axis.data()), reach = boxes.reach_along(axis.data());
    const auto half = hn::Set(d, 0.5);
    add(gap_between(hn::Mul(half, hn::Sub(centre, reach)), hn::Mul(half, hn::Add(centre, reach)), box.low[3 + k],
                    box.high[3 + k]),
        squared_other);
  }
  widest = hn::Max(widest, hn::Max(gap_along(boxes, box.slab), gap_along(boxes, box.middle)));
  squared = hn::Max(squared, squared_other);
  return hn::IfThenElse(hn::Gt(squared, hn::Zero(d)), hn::Max(widest, hn::Sqrt(squared)), widest);
}

/// Depth first, near boxes before far ones. Of a pair of boxes the larger one is opened.
class NearLeafTraversal {
 public:
  NearLeafTraversal(const MeshTreeView& a, const MeshTreeView& b, const BoxDistance& bounds, double limit,
                    std::int64_t& steps)
      : trees_{&a, &b}, sides_{&bounds.a, &bounds.b}, limit_(limit), steps_(steps) {}

  double run(VisitNearLeaves visit, void* context) {
    // The traversal starts with all of b against the boxes of a's root, and opens b's root next.
    constexpr Ref root_a{0, 0, 0}, root_b{0, 0, std::numeric_limits<float>::infinity()};
    open(0, {{root_a, root_b}, 0},
         Covered(*sides_[0], Box::around(trees_[1]->nodes[0]), Box::around(trees_[0]->nodes[0]).centre));
    while (size_ > 0) {
      if (steps_ < 0) return least_bound();
      const Entry entry = stack_[--size_];
      if (!(entry.bound < limit_)) continue;
      --steps_;
      const auto& [a, b] = entry.refs;
      const int count_a = MeshNode::count_of(a.link), count_b = MeshNode::count_of(b.link);
      if (count_a > 0 && count_b > 0) {
        limit_ = visit(context, MeshNode::child_of(a.link), count_a, MeshNode::child_of(b.link), count_b);
        continue;
      }
      const bool opens_b = count_a > 0 || (count_b == 0 && b.size > a.size);
      const std::size_t opened = opens_b ? 1 : 0;
      open(opened, entry, Covered(*sides_[opened], box(1 - opened, entry), box(opened, entry).centre));
    }
    return std::numeric_limits<double>::infinity();
  }

 private:
  /// A box of a tree.
  struct Ref {
    std::uint32_t link, slot;  ///< slot: node * width + lane
    float size;                ///< TreeBoxes::sizes(), in world units
  };
  struct Entry {
    std::array<Ref, 2> refs;
    double bound;
  };
  static constexpr std::size_t stack_size = MeshNode::width * (2 * MeshTree::max_depth + 4);

  /// Returns the least bound on the stack that is below the limit, or infinity.
  double least_bound() const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < size_; ++i) least = stack_[i].bound < least ? stack_[i].bound : least;
    return least < limit_ ? least : std::numeric_limits<double>::infinity();
  }

  Box box(std::size_t tree, const Entry& entry) const {
    const std::uint32_t slot = entry.refs[tree].slot;
    return {trees_[tree]->nodes[slot / MeshNode::width], slot % MeshNode::width};
  }

  /// Tests the boxes of a node of tree `opened` against a box of the other tree.
  void open(std::size_t opened, const Entry& entry, const Covered& box) {
    const Lanes d;
    const std::int32_t index = MeshNode::child_of(entry.refs[opened].link);
    const MeshNode& node = trees_[opened]->nodes[index];
    const BoxDistance::Side& side = *sides_[opened];
    alignas(64) std::array<double, MeshNode::width> bound, size;
    for (std::size_t first = 0; first < MeshNode::width; first += hn::Lanes(d)) {
      Vec sizes;
      const auto steps = hn::Sub(distances(side, node, first, box, sizes), hn::Set(d, side.error));
      hn::StoreU(hn::Sub(hn::Mul(steps, hn::Set(d, side.unit)), hn::Set(d, side.world_error)), d, bound.data() + first);
      hn::StoreU(hn::Mul(sizes, hn::Set(d, side.unit)), d, size.data() + first);
    }
    const std::size_t bottom = size_;
    for (std::uint32_t lane = 0; lane < MeshNode::width && node.link[lane] < MeshNode::unused_link; ++lane) {
      const double found = side.works ? bound[lane] : 0;
      if (!(found < limit_)) continue;
      Entry next = entry;
      next.refs[opened] = {node.link[lane], static_cast<std::uint32_t>(index) * MeshNode::width + lane,
                           static_cast<float>(size[lane])};
      next.bound = found;
      std::size_t at = size_++;
      for (; at > bottom && stack_[at - 1].bound < found; --at) stack_[at] = stack_[at - 1];
      stack_[at] = next;
    }
  }

  std::array<const MeshTreeView*, 2> trees_;       // a, b
  std::array<const BoxDistance::Side*, 2> sides_;  // indexed by the opened tree
  double limit_;
  std::int64_t& steps_;
  std::size_t size_ = 0;
  std::array<Entry, stack_size> stack_;
};

}  // namespace

double visit_near_leaves(const MeshTreeView& a, const MeshTreeView& b, const BoxDistance& bounds, double limit,
                         VisitNearLeaves visit, void* context, std::int64_t& steps) {
  return NearLeafTraversal(a, b, bounds, limit, steps).run(visit, context);
}

}  // namespace encage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace encage {
namespace {

using Vector = Eigen::Vector3d;
using Matrix = Eigen::Matrix3d;

/// The mean factor by which a map stretches lengths, and a bound of the relative deviation of squared factors from its
/// square.
struct Stretch {
  double factor, departure;

  explicit Stretch(const Matrix& m) {
    const Matrix squares = m.transpose() * m;
    const double mean = squares.trace() / 3;
    factor = std::sqrt(mean);
    departure = (squares / mean - Matrix::Identity()).norm() * (1 + 1e-14) + 1e-14;
  }
};

Vector as_vector(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

/// Returns the rounding error of TreeGrid::at(), which computes in float, at the size of the body.
double rounding(const GateBody& body) {
  return 0x1p-24 * body.scale * (4 * 32768 * static_cast<double>(body.grid.step) + as_vector(body.grid.middle).norm());
}

BoxDistance::Side make_side(const AffineMap& map, const GateBody& body, const AffineMap& other_map,
                            const GateBody& other, double error) {
  BoxDistance::Side side{};
  // Local coordinates are middle + step * grid coordinate.
  const double step = body.scale * static_cast<double>(body.grid.step);
  const double other_step = other.scale * static_cast<double>(other.grid.step);
  const Vector middle = body.scale * as_vector(body.grid.middle);
  const Vector other_middle = other.scale * as_vector(other.grid.middle);
  const Matrix inverse = map.linear.inverse();
  const AffineMap relative = {inverse * other_map.linear, inverse * (other_map.offset - map.offset)};
  const Stretch own(map.linear), both(relative.linear);
  const Matrix turned = relative.linear / both.factor;
  side.ratio = both.factor * other_step / step;
  const Vector offset = (relative(other_middle) - middle) / step;
  for (int k = 0; k < 3; ++k) {
    const Vector axis = turned.col(k).normalized();
    const Vector in_other = turned.transpose() * axis * side.ratio;
    for (int i = 0; i < 3; ++i) {
      side.turned[k][i] = axis[i];
      side.other[i][k] = turned(k, i) * side.ratio;
      side.other[i][3 + k] = in_other[i];
    }
    side.offset[k] = side.other_offset[k] = offset[k];
    side.other_offset[3 + k] = axis.dot(offset);
  }
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < BoxDistance::Side::axes; ++k) side.other_size[i][k] = std::abs(side.other[i][k]);
  }
  const double other_size = both.factor * (other.scale * other.radius + other_middle.norm());
  const double size = body.scale * body.radius + middle.norm() + other_size + relative.offset.norm();
  side.error =
      (0x1p-44 * size + 4 * both.departure * other_size + rounding(body) + 2 * both.factor * rounding(other)) / step;
  side.unit = step * own.factor * (1 - own.departure - 3 * both.departure - 0x1p-44);
  side.world_error = error;
  // Squares of grid coordinates must stay finite and above the range of underflow.
  side.works = size / step < 1e100 && side.ratio > 1e-100 && side.ratio < 1e100 && side.unit > 0 && side.unit < 1e100 &&
               own.departure < 0.1 && both.departure < 0.1;
  return side;
}

}  // namespace

BoxDistance::BoxDistance(const AffineMap& map_a, const GateBody& body_a, const AffineMap& map_b, const GateBody& body_b,
                         double error)
    : a(make_side(map_a, body_a, map_b, body_b, error)), b(make_side(map_b, body_b, map_a, body_a, error)) {}

HWY_EXPORT(visit_near_leaves);

double visit_near_leaves(const MeshTreeView& a, const MeshTreeView& b, const BoxDistance& bounds, double limit,
                         VisitNearLeaves visit, void* context, std::int64_t* steps) {
  std::int64_t unlimited = std::numeric_limits<std::int64_t>::max();
  return HWY_DYNAMIC_DISPATCH(visit_near_leaves)(a, b, bounds, limit, visit, context,
                                                 steps == nullptr ? unlimited : *steps);
}

}  // namespace encage
#endif

// SPDX-License-Identifier: Apache-2.0
#include "broadphase/adapters/bullet/box_overlap.h"

#include <encage/fine_lease.h>

#include <array>
#include <limits>

namespace encage::bullet {
namespace {

using Vector = Eigen::Vector3f;
using Lanes = Eigen::Array<float, MeshNode::width, 1>;

struct TriangleBox {
  Vector centre, half;
};

/// Maps the frame of the other body to this one's. Magnitudes are enlarged as Bullet enlarges them.
struct Frame {
  Eigen::Matrix3f rotation, magnitude;
  Vector offset;

  explicit Frame(const Eigen::Isometry3d& map)
      : rotation(map.linear().cast<float>()),
        magnitude(rotation.cwiseAbs().array() + 2e-6F),
        offset(map.translation().cast<float>()) {}
};

/// The boxes of one of the two trees, in its body's frame.
class Side {
 public:
  explicit Side(const BoxedMesh& mesh)
      : fine_(mesh.shape.fine),
        scale_(static_cast<float>(mesh.scale)),
        growth_(static_cast<float>(mesh.growth)),
        origin_((mesh.scale * mesh.shape.frame.origin).cast<float>()) {}

  struct NodeBoxes {
    std::array<Lanes, 3> centre, half;
    TriangleBox box(int lane) const {
      return {{centre[0][lane], centre[1][lane], centre[2][lane]}, {half[0][lane], half[1][lane], half[2][lane]}};
    }
  };

  const MeshNode& node(std::int32_t index) const { return fine_.tree.nodes[static_cast<std::size_t>(index)]; }

  NodeBoxes boxes(const MeshNode& node) const {
    NodeBoxes result;
    for (int k = 0; k < 3; ++k) {
      Lanes low, high;
      for (int lane = 0; lane < MeshNode::width; ++lane) {
        low[lane] = fine_.tree.lower(node, k, lane);
        high[lane] = fine_.tree.upper(node, k, lane);
      }
      const auto i = static_cast<std::size_t>(k);
      result.centre[i] = 0.5F * scale_ * (low + high) + origin_[k];
      result.half[i] = 0.5F * scale_ * (high - low) + growth_;
    }
    return result;
  }

  TriangleBox root() const {
    const NodeBoxes all = boxes(node(0));
    Vector low, high;
    for (int k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(k);
      low[k] = (all.centre[i] - all.half[i]).minCoeff();
      high[k] = (all.centre[i] + all.half[i]).maxCoeff();
    }
    return {0.5F * (low + high), 0.5F * (high - low)};
  }

  TriangleBox box(std::int32_t leaf) const {
    Vector low, high;
    low.setConstant(std::numeric_limits<float>::infinity());
    high = -low;
    for (const std::int32_t v : fine_.tree.leaves[static_cast<std::size_t>(leaf)].vertices) {
      const Vector vertex = Eigen::Map<const Vector>(fine_.mesh.vertices[static_cast<std::size_t>(v)].data());
      low = low.cwiseMin(vertex);
      high = high.cwiseMax(vertex);
    }
    const Vector centre = 0.5F * scale_ * (low + high) + origin_;
    return {centre, (0.5F * scale_ * (high - low)).array() + growth_};
  }

 private:
  const Surface& fine_;
  float scale_, growth_;
  Vector origin_;
};

/// Returns the lanes whose boxes may overlap `other`, which lies in the other frame.
Eigen::Array<bool, MeshNode::width, 1> overlap(const Side::NodeBoxes& boxes, const Frame& frame,
                                               const TriangleBox& other, float slack) {
  const Vector centre = frame.rotation * other.centre + frame.offset;
  const Vector reach = (frame.magnitude * other.half).array() + slack;
  std::array<Lanes, 3> apart;
  Eigen::Array<bool, MeshNode::width, 1> result;
  result.setConstant(true);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    apart[k] = centre[i] - boxes.centre[k];
    result = result && apart[k].abs() <= boxes.half[k] + reach[i];
  }
  for (Eigen::Index j = 0; j < 3; ++j) {
    const Lanes along =
        apart[0] * frame.rotation(0, j) + apart[1] * frame.rotation(1, j) + apart[2] * frame.rotation(2, j);
    const Lanes width = boxes.half[0] * frame.magnitude(0, j) + boxes.half[1] * frame.magnitude(1, j) +
                        boxes.half[2] * frame.magnitude(2, j);
    result = result && along.abs() <= width + (other.half[j] + slack);
  }
  return result;
}

bool overlap(const TriangleBox& box, const Frame& frame, const TriangleBox& other, float slack) {
  const Vector apart = frame.rotation * other.centre + frame.offset - box.centre;
  const Vector own = frame.magnitude * other.half + box.half,
               across = frame.magnitude.transpose() * box.half + other.half;
  return ((apart.cwiseAbs() - own).array() <= slack).all() &&
         (((frame.rotation.transpose() * apart).cwiseAbs() - across).array() <= slack).all();
}

/// A box of either tree: that of a node, if count is MeshNode::inner, or of the triangles of a leaf.
struct BoxRef {
  std::int32_t index;
  int count;
  TriangleBox box;
};

class Traversal {
 public:
  Traversal(const BoxedMesh& a, const BoxedMesh& b, const Eigen::Isometry3d& b_to_a, float slack)
      : a_(a), b_(b), b_to_a_(b_to_a), a_to_b_(b_to_a.inverse()), slack_(slack) {}

  bool finds_overlap() {
    push({0, MeshNode::inner, a_.root()}, {0, MeshNode::inner, b_.root()});
    while (size_ > 0) {
      const Entry entry = stack_[--size_];
      const bool leaf_a = entry.a.count != MeshNode::inner, leaf_b = entry.b.count != MeshNode::inner;
      if (leaf_a && leaf_b) {
        if (leaves_overlap(entry.a, entry.b)) return true;
      } else if (leaf_b || (!leaf_a && entry.a.box.half.sum() >= entry.b.box.half.sum())) {
        expand(a_, b_to_a_, entry.a, entry.b, [&](const BoxRef& child) { push(child, entry.b); });
      } else {
        expand(b_, a_to_b_, entry.b, entry.a, [&](const BoxRef& child) { push(entry.a, child); });
      }
    }
    return false;
  }

 private:
  struct Entry {
    BoxRef a, b;
  };

  void push(const BoxRef& a, const BoxRef& b) { stack_[size_++] = {a, b}; }

  template <class Push>
  void expand(const Side& side, const Frame& frame, const BoxRef& ref, const BoxRef& other, Push&& push) const {
    const MeshNode& node = side.node(ref.index);
    const Side::NodeBoxes boxes = side.boxes(node);
    const auto near = overlap(boxes, frame, other.box, slack_);
    for (int lane = 0; lane < MeshNode::width && node.count(lane) != MeshNode::unused; ++lane) {
      if (near[lane]) push({node.child(lane), node.count(lane), boxes.box(lane)});
    }
  }

  bool leaves_overlap(const BoxRef& a, const BoxRef& b) const {
    for (std::int32_t i = a.index; i < a.index + a.count; ++i) {
      const TriangleBox box = a_.box(i);
      if (!overlap(box, b_to_a_, b.box, slack_)) continue;
      for (std::int32_t j = b.index; j < b.index + b.count; ++j) {
        if (overlap(box, b_to_a_, b_.box(j), slack_)) return true;
      }
    }
    return false;
  }

  Side a_, b_;
  Frame b_to_a_, a_to_b_;
  float slack_;
  std::array<Entry, MeshNode::width * 2 * (MeshTree::max_depth + 2)> stack_;
  std::size_t size_ = 0;
};

}  // namespace

bool boxes_may_overlap(const BoxedMesh& a, const BoxedMesh& b, const Eigen::Isometry3d& b_to_a, double slack) noexcept {
  FineLease lease_a, lease_b;
  if (!a.shape.has_fine() || !b.shape.has_fine() || !lease_a.take(a.shape) || !lease_b.take(b.shape)) return true;
  // Everything is computed in float. Its rounding is that of numbers up to the sum of all sizes.
  const double size = a.scale * a.shape.frame.reach() + a.growth + b.scale * b.shape.frame.reach() + b.growth +
                      b_to_a.translation().norm();
  const double all = slack + 64 * 0x1p-24 * size;
  if (!(size <= 1e30 && size >= 1e-30)) return true;
  return Traversal(a, b, b_to_a, static_cast<float>(all * (1 + 1e-6))).finds_overlap();
}

}  // namespace encage::bullet

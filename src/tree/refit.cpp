// SPDX-License-Identifier: Apache-2.0
#include "src/tree/refit.h"

#include "src/tree/slab.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

namespace encage {
namespace {

/// Lanes of more triangles get the slab of boxes below them: their corners would be visited at every level.
constexpr std::int32_t most_exact = 256;

class Refitter {
 public:
  Refitter(MeshTree& tree, const MeshView& mesh) : tree_(tree), mesh_(mesh), below_(tree.nodes.size()) {
    tree_.grid = make_grid(mesh.vertices);
    positions_.reserve(mesh.vertices.size());
    for (const auto& v : mesh.vertices) {
      positions_.emplace_back(tree_.grid.coordinate(0, static_cast<double>(v[0])),
                              tree_.grid.coordinate(1, static_cast<double>(v[1])),
                              tree_.grid.coordinate(2, static_cast<double>(v[2])));
    }
  }

  void run() {
    // Children come after their parents.
    for (std::size_t n = tree_.nodes.size(); n-- > 0;) {
      MeshNode& node = tree_.nodes[n];
      Range& all = below_[n];
      for (int lane = 0; lane < MeshNode::width && node.count(lane) != MeshNode::unused; ++lane) {
        const Range range = range_of(node, lane);
        for (int axis = 0; axis < 3; ++axis) {
          node.lower[axis][lane] = tree_.grid.below(axis, range.lower[axis]);
          node.upper[axis][lane] = tree_.grid.above(axis, range.upper[axis]);
        }
        fit_slab(node, lane, range);
        all.add(range);
      }
    }
  }

 private:
  /// The triangles below a lane or a node.
  struct Range {
    std::int32_t begin = std::numeric_limits<std::int32_t>::max(), end = 0, count = 0;
    Eigen::Array3f lower = Eigen::Array3f::Constant(std::numeric_limits<float>::infinity());
    Eigen::Array3f upper = -lower;
    Eigen::Vector3d area = Eigen::Vector3d::Zero();  ///< sum of their vectors of twice the area

    void add(const Range& other) {
      begin = std::min(begin, other.begin);
      end = std::max(end, other.end);
      count += other.count;
      lower = lower.min(other.lower);
      upper = upper.max(other.upper);
      area += other.area;
    }
    /// True if no triangle of another lane is between them. So it is in trees that were built here.
    bool contiguous() const { return end - begin == count; }
  };

  const Eigen::Vector3d& position(std::int32_t v) const { return positions_[static_cast<std::size_t>(v)]; }

  Range range_of(const MeshNode& node, int lane) const {
    if (node.count(lane) == MeshNode::inner) return below_[static_cast<std::size_t>(node.child(lane))];
    Range range;
    range.begin = node.child(lane);
    range.count = node.count(lane);
    range.end = range.begin + range.count;
    for (std::int32_t i = range.begin; i < range.end; ++i) {
      const std::array<std::int32_t, 3>& t = tree_.leaves[static_cast<std::size_t>(i)].vertices;
      for (const std::int32_t v : t) {
        const auto p = Eigen::Map<const Eigen::Array3f>(mesh_.vertices[static_cast<std::size_t>(v)].data());
        range.lower = range.lower.min(p);
        range.upper = range.upper.max(p);
      }
      range.area += (position(t[1]) - position(t[0])).cross(position(t[2]) - position(t[0]));
    }
    return range;
  }

  void fit_slab(MeshNode& node, int lane, const Range& range) {
    SlabBounds bounds;
    bounds.add_normal(std::array{node.normal[0][lane], node.normal[1][lane], node.normal[2][lane]});
    bounds.add_normal(range.area);
    if (range.contiguous() && range.count <= most_exact) {
      // Corner by corner, so that a loop has no other in it.
      for (std::size_t k = 0; k < 3; ++k) {
        bounds.add(range.count, [&](std::int32_t i) -> const Eigen::Vector3d& {
          return position(
              tree_.leaves[static_cast<std::size_t>(range.begin) + static_cast<std::size_t>(i)].vertices[k]);
        });
      }
    } else {
      add_boxes(node, lane, bounds);
    }
    const Slab slab = bounds.thinnest();
    for (int axis = 0; axis < 3; ++axis) node.normal[axis][lane] = slab.normal[static_cast<std::size_t>(axis)];
    node.slab_lower[lane] = slab.lower;
    node.slab_upper[lane] = slab.upper;
  }

  /// Adds the boxes that are two levels below a lane, or what is there.
  void add_boxes(const MeshNode& node, int lane, SlabBounds& bounds) const {
    const auto add = [&](const MeshNode& of, int i) {
      bounds.add_box({1.0 * of.lower[0][i], 1.0 * of.lower[1][i], 1.0 * of.lower[2][i]},
                     {1.0 * of.upper[0][i], 1.0 * of.upper[1][i], 1.0 * of.upper[2][i]});
    };
    if (node.count(lane) != MeshNode::inner) return add(node, lane);
    const MeshNode& child = tree_.nodes[static_cast<std::size_t>(node.child(lane))];
    for (int i = 0; i < MeshNode::width && child.count(i) != MeshNode::unused; ++i) {
      if (child.count(i) != MeshNode::inner) {
        add(child, i);
        continue;
      }
      const MeshNode& grandchild = tree_.nodes[static_cast<std::size_t>(child.child(i))];
      for (int j = 0; j < MeshNode::width && grandchild.count(j) != MeshNode::unused; ++j) add(grandchild, j);
    }
  }

  MeshTree& tree_;
  const MeshView& mesh_;
  std::vector<Range> below_;
  std::vector<Eigen::Vector3d> positions_;  // of vertices, in grid coordinates
};

}  // namespace

void refit_tree(MeshTree& tree, const MeshView& mesh) { Refitter(tree, mesh).run(); }

}  // namespace encage

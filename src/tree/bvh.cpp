// SPDX-License-Identifier: Apache-2.0
#include "src/tree/bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace encage {
namespace {

using Box = Eigen::AlignedBox3d;
using Index = std::int32_t;

constexpr int bin_count = 32;
// Above this depth the builder follows the heuristic. From here on it halves, which needs at most 31 further levels for
// 2^31 triangles.
constexpr int heuristic_depth = Bvh::max_depth - 32;

double half_area(const Box& box) {
  if (box.isEmpty()) return 0;
  const Eigen::Vector3d d = box.sizes();
  return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
}

float round_down(double x) {
  const float f = static_cast<float>(x);
  return static_cast<double>(f) > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

float round_up(double x) { return -round_down(-x); }

struct Split {
  int axis = -1;  ///< -1 if no split was found
  int bin = 0;    ///< triangles of bins up to this one go left
  double cost = std::numeric_limits<double>::infinity();
};

class BvhBuilder {
 public:
  explicit BvhBuilder(const TriangleMesh& mesh) : boxes_(static_cast<std::size_t>(mesh.triangles.rows())) {
    for (std::size_t t = 0; t < boxes_.size(); ++t) {
      for (int k = 0; k < 3; ++k) boxes_[t].extend(mesh.corner(static_cast<std::int64_t>(t), k));
    }
    bvh_.order.resize(boxes_.size());
    std::iota(bvh_.order.begin(), bvh_.order.end(), 0);
  }

  Bvh build() {
    if (boxes_.empty()) return {};
    struct Task {
      Index node, begin, end;
      int depth;
    };
    std::vector<Task> tasks{{0, 0, static_cast<Index>(boxes_.size()), 0}};
    bvh_.nodes.reserve(boxes_.size());
    bvh_.nodes.resize(1);
    while (!tasks.empty()) {
      const Task task = tasks.back();
      tasks.pop_back();
      set_box(task.node, task.begin, task.end);
      if (task.end - task.begin <= Bvh::leaf_size) {
        bvh_.nodes[task.node].first = task.begin;
        bvh_.nodes[task.node].count = task.end - task.begin;
        continue;
      }
      const Index middle = partition(task.begin, task.end, task.depth);
      const Index child = static_cast<Index>(bvh_.nodes.size());
      bvh_.nodes[task.node].first = child;
      bvh_.nodes[task.node].count = 0;
      bvh_.nodes.resize(bvh_.nodes.size() + 2);
      tasks.push_back({child + 1, middle, task.end, task.depth + 1});
      tasks.push_back({child, task.begin, middle, task.depth + 1});
    }
    return std::move(bvh_);
  }

 private:
  // Returns twice the centre, since only the order matters.
  double centre(Index triangle, int axis) const { return boxes_[triangle].min()[axis] + boxes_[triangle].max()[axis]; }

  void set_box(Index node, Index begin, Index end) {
    Box box;
    for (Index i = begin; i < end; ++i) box.extend(boxes_[bvh_.order[i]]);
    for (int axis = 0; axis < 3; ++axis) {
      bvh_.nodes[node].lower[axis] = round_down(box.min()[axis]);
      bvh_.nodes[node].upper[axis] = round_up(box.max()[axis]);
    }
  }

  Index partition(Index begin, Index end, int depth) {
    Box centres;
    for (Index i = begin; i < end; ++i) {
      const Index t = bvh_.order[i];
      centres.extend(Eigen::Vector3d(centre(t, 0), centre(t, 1), centre(t, 2)));
    }
    if (depth < heuristic_depth) {
      Split best;
      for (int axis = 0; axis < 3; ++axis) try_axis(begin, end, centres, axis, best);
      if (best.axis >= 0) {
        const auto middle = std::stable_partition(bvh_.order.begin() + begin, bvh_.order.begin() + end,
                                                  [&](Index t) { return bin(t, best.axis, centres) <= best.bin; });
        return static_cast<Index>(middle - bvh_.order.begin());
      }
    }
    return halve(begin, end, centres);
  }

  int bin(Index triangle, int axis, const Box& centres) const {
    const double low = centres.min()[axis];
    const double x = (centre(triangle, axis) - low) / (centres.max()[axis] - low) * bin_count;
    return std::clamp(static_cast<int>(x), 0, bin_count - 1);
  }

  void try_axis(Index begin, Index end, const Box& centres, int axis, Split& best) const {
    const double extent = centres.max()[axis] - centres.min()[axis];
    if (!(extent > 0)) return;
    std::array<Box, bin_count> box;
    std::array<Index, bin_count> count{};
    for (Index i = begin; i < end; ++i) {
      const int b = bin(bvh_.order[i], axis, centres);
      box[b].extend(boxes_[bvh_.order[i]]);
      ++count[b];
    }
    std::array<double, bin_count> right_cost{};
    Box right;
    Index right_count = 0;
    for (int b = bin_count - 1; b > 0; --b) {
      right.extend(box[b]);
      right_count += count[b];
      right_cost[b - 1] = half_area(right) * right_count;
    }
    Box left;
    Index left_count = 0;
    for (int b = 0; b + 1 < bin_count; ++b) {
      left.extend(box[b]);
      left_count += count[b];
      if (left_count == 0 || left_count == end - begin) continue;
      const double cost = half_area(left) * left_count + right_cost[b];
      if (cost < best.cost) best = {axis, b, cost};
    }
  }

  Index halve(Index begin, Index end, const Box& centres) {
    int axis = 0;
    centres.sizes().maxCoeff(&axis);
    const Index middle = begin + (end - begin) / 2;
    std::nth_element(bvh_.order.begin() + begin, bvh_.order.begin() + middle, bvh_.order.begin() + end,
                     [&](Index s, Index t) {
                       const double cs = centre(s, axis), ct = centre(t, axis);
                       return cs != ct ? cs < ct : s < t;
                     });
    // nth_element leaves each half in an unspecified order.
    std::sort(bvh_.order.begin() + begin, bvh_.order.begin() + middle);
    std::sort(bvh_.order.begin() + middle, bvh_.order.begin() + end);
    return middle;
  }

  std::vector<Box> boxes_;
  Bvh bvh_;
};

}  // namespace

Bvh build_bvh(const TriangleMesh& mesh) { return BvhBuilder(mesh).build(); }

}  // namespace encage

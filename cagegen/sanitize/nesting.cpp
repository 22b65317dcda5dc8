// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/sanitize/nesting.h"

#include "cagegen/sanitize/predicates.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace encage::io {
namespace {

using Part = std::vector<std::int32_t>;

Eigen::Vector2d along_x(const Eigen::Vector3d& p) { return {p[1], p[2]}; }

/// Orientation of (a, b, q) in the yz plane with q moved by (e, e^2), e infinitely small (Edelsbrunner and Muecke
/// 1990): a ray never meets an edge. 0 if a equals b.
int side(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& q) {
  const int sign = orientation(along_x(a), along_x(b), along_x(q));
  if (sign != 0) return sign;
  if (a[2] != b[2]) return b[2] < a[2] ? 1 : -1;
  if (a[1] != b[1]) return b[1] > a[1] ? 1 : -1;
  return 0;
}

/// Tells whether points are inside a closed part, by the parity of the triangles on the ray towards +x, which are found
/// in a grid over the yz plane.
class InsideTest {
 public:
  InsideTest(const TriangleMesh& mesh, const Part& part, const Eigen::AlignedBox3d& box)
      : mesh_(mesh), part_(part), low_(box.min().tail<2>()) {
    const double cells = std::sqrt(static_cast<double>(part.size()));
    size_ = std::clamp(static_cast<int>(cells), 1, 1024);
    const Eigen::Vector2d extent = box.sizes().tail<2>();
    for (int k = 0; k < 2; ++k) scale_[k] = extent[k] > 0 ? size_ / extent[k] : 0;
    first_.assign(static_cast<std::size_t>(size_) * size_ + 1, 0);
    for_each_cell([&](std::size_t cell, std::int32_t) { ++first_[cell + 1]; });
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    entries_.resize(static_cast<std::size_t>(first_.back()));
    std::vector<std::int64_t> next(first_.begin(), first_.end() - 1);
    for_each_cell([&](std::size_t cell, std::int32_t t) { entries_[next[cell]++] = t; });
  }

  /// No value if the point is on the surface.
  std::optional<bool> contains(const Eigen::Vector3d& q) const {
    const std::size_t cell = static_cast<std::size_t>(column(q[1], 0)) * size_ + column(q[2], 1);
    bool inside = false;
    for (std::int64_t i = first_[cell]; i < first_[cell + 1]; ++i) {
      const Eigen::Vector3d a = mesh_.corner(entries_[i], 0), b = mesh_.corner(entries_[i], 1),
                            c = mesh_.corner(entries_[i], 2);
      const int turn = side(a, b, q);
      if (turn == 0 || side(b, c, q) != turn || side(c, a, q) != turn) continue;
      const int above = orientation(a, b, c, q);
      if (above == 0) return {};
      if (above == -turn) inside = !inside;
    }
    return inside;
  }

 private:
  int column(double x, int axis) const {
    return std::clamp(static_cast<int>((x - low_[axis]) * scale_[axis]), 0, size_ - 1);  // monotone in x
  }

  template <typename Visit>
  void for_each_cell(const Visit& visit) const {
    for (const std::int32_t t : part_) {
      int from[2], to[2];
      for (int axis = 0; axis < 2; ++axis) {
        const double x[3] = {mesh_.corner(t, 0)[axis + 1], mesh_.corner(t, 1)[axis + 1], mesh_.corner(t, 2)[axis + 1]};
        from[axis] = column(*std::min_element(x, x + 3), axis);
        to[axis] = column(*std::max_element(x, x + 3), axis);
      }
      for (int i = from[0]; i <= to[0]; ++i) {
        for (int j = from[1]; j <= to[1]; ++j) visit(static_cast<std::size_t>(i) * size_ + j, t);
      }
    }
  }

  const TriangleMesh& mesh_;
  const Part& part_;
  Eigen::Vector2d low_;
  Eigen::Vector2d scale_;
  int size_ = 1;
  std::vector<std::int64_t> first_;
  std::vector<std::int32_t> entries_;
};

bool is_inside(const TriangleMesh& mesh, const Part& part, const InsideTest& test) {
  constexpr std::size_t samples = 8;
  bool found = false;
  for (std::size_t i = 0; i < samples; ++i) {
    const std::optional<bool> inside = test.contains(mesh.corner(part[i * part.size() / samples], 0));
    if (inside == false) return false;
    found |= inside.has_value();
  }
  return found;
}

/// Pairs (outer, inner) whose boxes are nested, found by a sweep along x.
std::vector<std::pair<std::int32_t, std::int32_t>> nested_boxes(const std::vector<Eigen::AlignedBox3d>& boxes) {
  std::vector<std::int32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    const Eigen::AlignedBox3d &p = boxes[a], &q = boxes[b];
    return p.min().x() != q.min().x() ? p.min().x() < q.min().x() : p.max().x() > q.max().x();
  });
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
  std::vector<std::int32_t> active;
  for (const std::int32_t inner : order) {
    std::erase_if(active, [&](std::int32_t outer) { return boxes[outer].max().x() < boxes[inner].min().x(); });
    for (const std::int32_t outer : active) {
      if (boxes[outer].contains(boxes[inner])) pairs.emplace_back(outer, inner);
    }
    active.push_back(inner);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace

std::vector<std::vector<std::int32_t>> containers(const TriangleMesh& mesh, const std::vector<Part>& parts) {
  std::vector<Eigen::AlignedBox3d> boxes(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    for (const std::int32_t t : parts[p]) {
      for (int k = 0; k < 3; ++k) boxes[p].extend(mesh.corner(t, k));
    }
  }
  std::vector<std::vector<std::int32_t>> result(parts.size());
  std::optional<InsideTest> test;
  std::int32_t tested = -1;
  for (const auto& [outer, inner] : nested_boxes(boxes)) {
    if (tested != outer) test.emplace(mesh, parts[outer], boxes[outer]);
    tested = outer;
    if (is_inside(mesh, parts[inner], *test)) result[inner].push_back(outer);
  }
  return result;
}

double part_volume(const TriangleMesh& mesh, const std::vector<std::int32_t>& part) {
  const Eigen::Vector3d reference = mesh.corner(part[0], 0);
  double sum = 0;
  for (const std::int32_t t : part) {
    const Eigen::Vector3d a = mesh.corner(t, 0) - reference;
    const Eigen::Vector3d b = mesh.corner(t, 1) - reference;
    const Eigen::Vector3d c = mesh.corner(t, 2) - reference;
    sum += a.dot(b.cross(c));
  }
  return sum / 6;
}

}  // namespace encage::io

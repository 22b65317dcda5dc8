// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/sanitize/ear_clip.h"

#include "cagegen/sanitize/predicates.h"

#include <algorithm>
#include <cmath>

namespace encage::io {
namespace {

using Point = Eigen::Vector2d;

/// The chain seen along the coordinate axis that its (Newell) normal follows most, turned so that it runs
/// counter-clockwise.
std::vector<Point> project(const Vertices& vertices, std::span<const std::int32_t> chain) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  const Eigen::Vector3d origin = vertices.row(chain[0]).transpose();
  for (std::size_t i = 0; i < chain.size(); ++i) {
    const Eigen::Vector3d a = vertices.row(chain[i]).transpose() - origin;
    const Eigen::Vector3d b = vertices.row(chain[(i + 1) % chain.size()]).transpose() - origin;
    normal += a.cross(b);
  }
  int axis = 2;
  for (const int k : {1, 0}) {
    if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
  }
  int u = (axis + 1) % 3, v = (axis + 2) % 3;
  if (normal[axis] < 0) std::swap(u, v);
  std::vector<Point> points;
  points.reserve(chain.size());
  for (const std::int32_t vertex : chain) points.emplace_back(vertices(vertex, u), vertices(vertex, v));
  return points;
}

class Clipper {
 public:
  explicit Clipper(std::vector<Point> points) : points_(std::move(points)), count_(points_.size()) {
    for (std::size_t i = 0; i < count_; ++i) {
      next_.push_back(static_cast<std::int32_t>((i + 1) % count_));
      previous_.push_back(static_cast<std::int32_t>((i + count_ - 1) % count_));
    }
  }

  /// Calls emit(a, b, c) with positions in the chain.
  template <typename Emit>
  void run(const Emit& emit) {
    std::int32_t at = next_[0];
    std::size_t tried = 0;
    while (count_ > 3) {
      // After a whole round without an ear the chain is not simple: cut anywhere.
      const bool cut = tried >= 2 * count_ || is_ear(at, tried < count_);
      if (!cut) {
        at = next_[at];
        ++tried;
        continue;
      }
      emit(previous_[at], at, next_[at]);
      next_[previous_[at]] = next_[at];
      previous_[next_[at]] = previous_[at];
      at = next_[at];
      --count_;
      tried = 0;
    }
    // Begin at the smallest position, as the fan of a convex polygon does.
    std::int32_t first = at;
    for (const std::int32_t other : {next_[at], previous_[at]}) first = std::min(first, other);
    emit(first, next_[first], previous_[first]);
  }

 private:
  /// +1 for a turn to the left.
  int turn(std::int32_t a, std::int32_t b, std::int32_t c) const {
    return orientation(points_[a], points_[b], points_[c]);
  }

  /// Strictly convex and, if `clear`, without another vertex of the chain in or on it.
  bool is_ear(std::int32_t at, bool clear) const {
    const std::int32_t a = previous_[at], c = next_[at];
    if (turn(a, at, c) <= 0) return false;
    if (!clear) return true;
    const auto [left, right] = std::minmax({points_[a].x(), points_[at].x(), points_[c].x()});
    const auto [bottom, top] = std::minmax({points_[a].y(), points_[at].y(), points_[c].y()});
    for (std::int32_t v = next_[c]; v != a; v = next_[v]) {
      const double x = points_[v].x(), y = points_[v].y();
      if (x < left || x > right || y < bottom || y > top) continue;
      // Chains with bridges pass positions twice; a vertex at a corner does not block.
      if (points_[v] == points_[a] || points_[v] == points_[at] || points_[v] == points_[c]) continue;
      if (turn(a, at, v) >= 0 && turn(at, c, v) >= 0 && turn(c, a, v) >= 0) {
        return false;
      }
    }
    return true;
  }

  std::vector<Point> points_;
  std::size_t count_;
  std::vector<std::int32_t> next_, previous_;
};

}  // namespace

void clip_ears(const Vertices& vertices, std::span<const std::int32_t> chain,
               std::vector<std::array<std::int32_t, 3>>& triangles) {
  if (chain.size() == 3) {
    triangles.push_back({chain[0], chain[1], chain[2]});
    return;
  }
  Clipper(project(vertices, chain)).run([&](std::int32_t a, std::int32_t b, std::int32_t c) {
    triangles.push_back({chain[a], chain[b], chain[c]});
  });
}

}  // namespace encage::io

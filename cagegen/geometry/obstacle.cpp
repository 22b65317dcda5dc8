// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/geometry/obstacle.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace encage::makers {

namespace {

// Rounding in BoxFilter, relative to the largest coordinate: six products and their sums in float, each off by at most
// 2^-24 of a partial sum below 2 sqrt(3).
constexpr double filter_slack = 1.5e-6;

// From this distance from the edge on, in lifts, triangles are lifted in full.
constexpr double full_lift = 20;

/// A triangle cut by four half-spaces: each adds one corner at most, but for rounding.
class Polygon {
 public:
  explicit Polygon(const Corners& c) : count_(3) { std::copy(c.begin(), c.end(), corner_[0].begin()); }

  std::span<const Point> corners() const { return {corner_[side_].data(), static_cast<std::size_t>(count_)}; }

  /// Keeps the part where value(x) <= 0, for an affine function.
  template <class Affine>
  void cut(const Affine& value) {
    const auto& from = corner_[side_];
    auto& to = corner_[1 - side_];
    int kept = 0;
    for (int i = 0; i < count_ && kept + 2 <= lane_capacity; ++i) {
      const Point& p = from[i];
      const Point& q = from[i + 1 < count_ ? i + 1 : 0];
      const double fp = value(p);
      const double fq = value(q);
      if (fp <= 0) to[kept++] = p;
      if ((fp < 0 && fq > 0) || (fp > 0 && fq < 0)) to[kept++] = p + fp / (fp - fq) * (q - p);
    }
    side_ = 1 - side_;
    count_ = kept;
  }

 private:
  static constexpr int lane_capacity = 12;
  std::array<Point, lane_capacity> corner_[2];
  int side_ = 0;
  int count_;
};

}  // namespace

BoxFilter::BoxFilter(const Eigen::AlignedBox3d& box, double magnitude) : slack_(filter_slack * magnitude) {
  for (int axis = 0; axis < 3; ++axis) {
    low_[axis] = static_cast<float>(box.min()[axis] - slack_);
    high_[axis] = static_cast<float>(box.max()[axis] + slack_);
  }
}

void BoxFilter::below(const Point& normal, double offset) { set_below(count_++, normal, offset); }

void BoxFilter::set_below(int index, const Point& normal, double offset) {
  Plane& plane = planes_[index];
  for (int axis = 0; axis < 3; ++axis) {
    plane.normal[axis] = static_cast<float>(normal[axis] / 2);
    plane.reach[axis] = std::abs(plane.normal[axis]);
  }
  plane.offset = static_cast<float>(offset + slack_ * std::max(1.0, normal.norm()));
}

Float4 BoxFilter::Plane::least(const Float4 (&sum)[3], const Float4 (&size)[3]) const {
  Float4 value = Float4::broadcast(normal[0]) * sum[0] - Float4::broadcast(reach[0]) * size[0];
  for (int axis = 1; axis < 3; ++axis) {
    value = value + Float4::broadcast(normal[axis]) * sum[axis];
    value = value - Float4::broadcast(reach[axis]) * size[axis];
  }
  return value;
}

Mask4 BoxFilter::operator()(const Float4 (&low)[3], const Float4 (&high)[3]) const {
  Mask4 accepted = (low[0] <= Float4::broadcast(high_[0])) & (Float4::broadcast(low_[0]) <= high[0]);
  for (int axis = 1; axis < 3; ++axis) {
    accepted = accepted & (low[axis] <= Float4::broadcast(high_[axis]));
    accepted = accepted & (Float4::broadcast(low_[axis]) <= high[axis]);
  }
  if (!accepted.any()) return accepted;
  const Float4 sum[3] = {low[0] + high[0], low[1] + high[1], low[2] + high[2]};
  const Float4 size[3] = {high[0] - low[0], high[1] - low[1], high[2] - low[2]};
  for (int i = 0; i < count_; ++i) {
    accepted = accepted & (planes_[i].least(sum, size) <= Float4::broadcast(planes_[i].offset));
  }
  return accepted;
}

Float4 BoxFilter::depth(const Float4 (&low)[3], const Float4 (&high)[3]) const {
  const Float4 sum[3] = {low[0] + high[0], low[1] + high[1], low[2] + high[2]};
  const Float4 size[3] = {high[0] - low[0], high[1] - low[1], high[2] - low[2]};
  return Float4::broadcast(planes_[0].offset) - planes_[0].least(sum, size);
}

Prism::Prism(const Corners& corners) : corner(corners) {
  const Point cross = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  const double length = cross.norm();
  valid = length > 0;
  if (!valid) return;
  normal = cross / length;
  for (int k = 0; k < 3; ++k) side[k] = (corner[(k + 1) % 3] - corner[k]).cross(normal).normalized();
}

Obstacle::Obstacle(const TriangleMesh& mesh) {
  std::vector<Eigen::AlignedBox3d> boxes(static_cast<std::size_t>(mesh.triangles.rows()));
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    for (int k = 0; k < 3; ++k) boxes[t].extend(mesh.corner(static_cast<std::int64_t>(t), k));
  }
  tree_.build(boxes);
  for (const std::int32_t t : tree_.renumber()) {
    triangle_.push_back({mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)});
  }
  std::vector<std::int32_t> label;
  triangle_components(mesh, label);
  for (std::size_t t = 0; t < label.size(); ++t) {
    if (label[t] == static_cast<int>(representative_vertex_.size())) {
      representative_vertex_.push_back(mesh.triangles(static_cast<std::int64_t>(t), 0));
    }
  }
  set_vertices(mesh.vertices);
  boxes.assign(representative_.size(), {});
  for (std::size_t c = 0; c < boxes.size(); ++c) boxes[c].extend(representative_[c]);
  representative_tree_.build(boxes);
}

void Obstacle::set_vertices(const Vertices& vertices) {
  const auto vertex = [&](std::int32_t v) -> Point { return vertices.row(v).transpose(); };
  corners_.resize(triangle_.size());
  magnitude_ = 0;
  for (std::size_t t = 0; t < corners_.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      corners_[t][k] = vertex(triangle_[t][k]);
      magnitude_ = std::max(magnitude_, corners_[t][k].cwiseAbs().maxCoeff());
    }
  }
  representative_.clear();
  for (const std::int32_t v : representative_vertex_) representative_.push_back(vertex(v));
}

void Obstacle::move(const Vertices& vertices) {
  set_vertices(vertices);
  std::vector<Eigen::AlignedBox3d> boxes(corners_.size());
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    for (const Point& p : corners_[t]) boxes[t].extend(p);
  }
  tree_.refit(boxes);
  boxes.assign(representative_.size(), {});
  for (std::size_t c = 0; c < boxes.size(); ++c) boxes[c].extend(representative_[c]);
  representative_tree_.refit(boxes);
}

std::uint64_t& Obstacle::work() {
  thread_local std::uint64_t count = 0;
  return count;
}

BoxFilter Obstacle::near(const Prism& prism, double clearance, double magnitude) const {
  Eigen::AlignedBox3d box;
  magnitude = std::max(magnitude, magnitude_);
  for (const Point& p : prism.corner) {
    box.extend(p);
    magnitude = std::max(magnitude, p.cwiseAbs().maxCoeff());
  }
  box.min().array() -= clearance;
  box.max().array() += clearance;
  BoxFilter filter(box, magnitude);
  if (!prism.valid) return filter;
  // Over all corners: rounding may tilt the planes of slivers by any angle.
  const auto below = [&](const Point& normal) {
    filter.below(normal, clearance + std::max({normal.dot(prism.corner[0]), normal.dot(prism.corner[1]),
                                               normal.dot(prism.corner[2])}));
  };
  below(-prism.normal);
  below(prism.normal);
  for (const Point& side : prism.side) below(side);
  return filter;
}

void Obstacle::hits(const Prism& prism, double clearance, std::size_t limit, std::vector<std::int32_t>& found) const {
  const BoxFilter filter = near(prism, clearance);
  if (found.size() >= limit) return;
  tree_.traverse(filter, [&](std::int32_t t) {
    ++work();
    if (!separated(prism.corner, corners(t), clearance)) found.push_back(t);
    return found.size() >= limit;
  });
}

void Obstacle::highest_hits(const Prism& prism, double clearance, std::size_t limit,
                            std::vector<std::int32_t>& found) const {
  const BoxFilter filter = near(prism, clearance);
  const auto height = [&](const Float4(&low)[3], const Float4(&high)[3]) { return filter.depth(low, high); };
  if (found.size() >= limit) return;
  tree_.traverse_ranked(filter, height, [&](std::int32_t t) {
    ++work();
    if (!separated(prism.corner, corners(t), clearance)) found.push_back(t);
    return found.size() >= limit;
  });
}

bool Obstacle::hit(const Prism& prism, double clearance) const {
  bool touched = false;
  tree_.traverse(near(prism, clearance), [&](std::int32_t t) {
    ++work();
    touched = !separated(prism.corner, corners(t), clearance);
    return touched;
  });
  return touched;
}

double Obstacle::steepest(const Prism& prism, const Corners& t, double lift, double ceiling, double slope) {
  const Point inward = -prism.side[1];
  // Everything relative to the edge's start, where height and distance are 0.
  const Corners x{t[0] - prism.corner[1], t[1] - prism.corner[1], t[2] - prism.corner[1]};
  const Point down = inward * slope - prism.normal;
  // In the order in which they reject most: under the present plane, beside the prism, above the ceiling.
  const std::array<Point, 5> normal{down, prism.side[0], prism.side[1], prism.side[2], prism.normal};
  const std::array<double, 5> offset{lift, 0, 0, prism.side[2].dot(prism.corner[2] - prism.corner[1]), ceiling};
  std::array<bool, 5> cuts;
  for (int i = 0; i < 5; ++i) {
    const double f0 = normal[i].dot(x[0]);
    const double f1 = normal[i].dot(x[1]);
    const double f2 = normal[i].dot(x[2]);
    if (std::min({f0, f1, f2}) > offset[i]) return slope;
    cuts[i] = i > 0 && std::max({f0, f1, f2}) > offset[i];
  }
  Polygon polygon(x);
  for (int i = 1; i < 5; ++i) {
    if (cuts[i]) polygon.cut([&](const Point& p) { return normal[i].dot(p) - offset[i]; });
  }
  // Turning lifts nothing next to the edge, which stays where it is: ask for less there.
  const double depth = inward.dot(prism.corner[0] - prism.corner[1]);
  const double full = std::min(full_lift * lift, depth / 4);
  for (const Point& p : polygon.corners()) {
    const double distance = inward.dot(p);
    const double height = prism.normal.dot(p);
    if (distance > 1e-9 * depth) slope = std::max(slope, height / distance + lift / std::max(distance, full));
  }
  return slope;
}

double Obstacle::steepest(const Prism& prism, double lift, double ceiling, double slope) const {
  const Point inward = -prism.side[1];
  const Point& start = prism.corner[1];
  Eigen::AlignedBox3d box;
  for (const Point& p : prism.corner) {
    box.extend(p);
    box.extend(p + ceiling * prism.normal);
    box.extend(p - lift * prism.normal);
  }
  BoxFilter filter(box, magnitude_);
  const auto raise = [&](double to) {
    const Point normal = inward * to - prism.normal;
    filter.set_below(0, normal, normal.dot(start) + lift);
  };
  filter.below(prism.normal, 0);
  raise(slope);
  filter.below(prism.normal, prism.normal.dot(start) + ceiling);
  for (int k = 0; k < 3; ++k) filter.below(prism.side[k], prism.side[k].dot(prism.corner[k]));
  const auto depth = [&](const Float4(&low)[3], const Float4(&high)[3]) { return filter.depth(low, high); };
  // The deepest triangles first: they raise the plane most, and those under it are then skipped.
  tree_.traverse_ranked(filter, depth, [&](std::int32_t t) {
    ++work();
    const double found = steepest(prism, corners(t), lift, ceiling, slope);
    if (found > slope) {
      slope = found;
      raise(slope);
    }
  });
  return slope;
}

double Obstacle::highest(const Prism& prism, double ceiling, double height) const {
  Eigen::AlignedBox3d box;
  for (const Point& p : prism.corner) {
    box.extend(p);
    box.extend(p + ceiling * prism.normal);
  }
  BoxFilter filter(box, magnitude_);
  const double level = prism.normal.dot(prism.corner[0]);
  filter.below(-prism.normal, -(level + height));
  for (int k = 0; k < 3; ++k) filter.below(prism.side[k], prism.side[k].dot(prism.corner[k]));
  const auto depth = [&](const Float4(&low)[3], const Float4(&high)[3]) { return filter.depth(low, high); };
  tree_.traverse_ranked(filter, depth, [&](std::int32_t t) {
    ++work();
    for (const Point& p : corners_[t]) {
      const double h = prism.height(p);
      if (h <= height || h > ceiling) continue;
      bool over = true;
      for (int k = 0; k < 3; ++k) over = over && prism.side[k].dot(p - prism.corner[k]) <= 0;
      if (!over) continue;
      height = h;
      filter.set_below(0, -prism.normal, -(level + height));
    }
  });
  return height;
}

void Obstacle::representatives(const Eigen::AlignedBox3d& box, std::vector<Point>& found) const {
  representative_tree_.traverse(BoxFilter(box, magnitude_),
                                [&](std::int32_t component) { found.push_back(representative_[component]); });
}

}  // namespace encage::makers

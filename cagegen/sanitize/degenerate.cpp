// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/sanitize/degenerate.h"

#include "cagegen/sanitize/edge_table.h"
#include "cagegen/sanitize/predicates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

namespace encage::io {
namespace {

using Triangle = std::array<std::int32_t, 3>;
using Segment = std::pair<std::int32_t, std::int32_t>;  ///< first <= second; a point if equal

bool is_collinear(const TriangleMesh& mesh, std::int64_t t) {
  return collinear(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
}

/// Triangles with three vertices on a line; those that repeat a vertex are not listed.
std::vector<std::int32_t> collinear_triangles(const TriangleMesh& mesh) {
  std::vector<std::int32_t> result;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    if (!repeats_a_vertex(mesh.triangles, t) && is_collinear(mesh, t)) result.push_back(static_cast<std::int32_t>(t));
  }
  return result;
}

/// The side between the two outer ones of three distinct vertices on a line.
int longest_side(const TriangleMesh& mesh, std::int64_t t) {
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d a = mesh.corner(t, k), b = mesh.corner(t, (k + 2) % 3), c = mesh.corner(t, (k + 1) % 3);
    if (strictly_between(a, b, c)) return k;
  }
  return 0;
}

/// The segment or point that a degenerate triangle is.
Segment segment_of(const TriangleMesh& mesh, std::int64_t t) {
  const auto row = mesh.triangles.row(t);
  if (repeats_a_vertex(mesh.triangles, t)) return {row.minCoeff(), row.maxCoeff()};
  const int k = longest_side(mesh, t);
  return std::minmax(row(k), row((k + 1) % 3));
}

/// Edges of a closed surface around few degenerate triangles, kept up to date by flips.
class Flipper {
 public:
  Flipper(TriangleMesh& mesh, const EdgeTable& edges)
      : mesh_(mesh), edges_(edges), twin_(twins(edges, mesh.triangles.rows())) {}

  /// Replaces the collinear triangle t and its neighbour across the longest side by two valid triangles that cover the
  /// same points. False if that is not possible.
  bool flip(std::int32_t t) {
    Triangles& triangles = mesh_.triangles;
    const Side ca = 3 * t + longest_side(mesh_, t);  // runs from c to a, b lies between them
    const Side ac = twin_[ca];
    if (ac < 0 || tail(triangles, ac) != head(triangles, ca)) return false;
    const std::int32_t n = triangle_of(ac);
    const Side ab = following(ca), bc = following(ab), cd = following(ac), da = following(cd);
    const std::int32_t a = tail(triangles, ab), b = tail(triangles, bc), c = tail(triangles, ca);
    const std::int32_t d = tail(triangles, da);
    if (n == t || d == b || is_collinear(mesh_, n) || has_edge(b, d)) return false;
    const Side outer[4] = {twin_[ab], twin_[bc], twin_[cd], twin_[da]};
    triangles.row(t) << a, b, d;
    triangles.row(n) << b, c, d;
    const Side sides[4] = {3 * t, 3 * n, 3 * n + 1, 3 * t + 2};
    for (int i = 0; i < 4; ++i) connect(sides[i], outer[i]);
    connect(3 * t + 1, 3 * n + 2);
    added_.insert(std::minmax(b, d));
    return true;
  }

 private:
  static Side following(Side s) { return s % 3 == 2 ? s - 2 : s + 1; }
  void connect(Side s, Side other) {
    twin_[s] = other;
    if (other >= 0) twin_[other] = s;
  }
  /// Says yes for edges that flips have removed: that only costs a flip.
  bool has_edge(std::int32_t a, std::int32_t b) const {
    return !edges_.sides(a, b).empty() || added_.contains(std::minmax(a, b));
  }

  TriangleMesh& mesh_;
  const EdgeTable& edges_;
  std::vector<Side> twin_;
  std::set<Segment> added_;
};

/// Adds vertices beside segments and triangles through them.
class ThinTriangles {
 public:
  ThinTriangles(TriangleMesh& mesh, double thickness) : mesh_(mesh), thickness_(thickness) {
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) points_.push_back(mesh.vertices.row(v).transpose());
  }

  /// For a triangle of a closed surface: with the same border.
  void replace(std::int32_t t) {
    const Triangle corners = {mesh_.triangles(t, 0), mesh_.triangles(t, 1), mesh_.triangles(t, 2)};
    const Segment segment = segment_of(mesh_, t);
    const std::int32_t p = vertex_beside(segment.first, segment.second);
    for (int k = 0; k < 3; ++k) added_.push_back({corners[k], corners[(k + 1) % 3], p});
  }

  /// For a segment or point on its own: closed, with two sides and no volume.
  void cover(const Segment& segment) {
    const auto [a, b] = segment;
    const std::int32_t p = vertex_beside(a, b);
    const std::int32_t q = a != b ? b : vertex_beside(a, p);
    added_.push_back({a, q, p});
    added_.push_back({q, a, p});
  }

  /// Writes the mesh anew, without the triangles in `drop` (sorted).
  void finish(const std::vector<std::int32_t>& drop) {
    const Eigen::Index kept = mesh_.triangles.rows() - static_cast<Eigen::Index>(drop.size());
    Triangles triangles(kept + static_cast<Eigen::Index>(added_.size()), 3);
    Eigen::Index row = 0;
    std::size_t next = 0;
    for (Eigen::Index t = 0; t < mesh_.triangles.rows(); ++t) {
      if (next < drop.size() && drop[next] == t) {
        ++next;
      } else {
        triangles.row(row++) = mesh_.triangles.row(t);
      }
    }
    for (const Triangle& t : added_) triangles.row(row++) << t[0], t[1], t[2];
    mesh_.triangles = std::move(triangles);
    const Eigen::Index old = mesh_.vertices.rows();
    mesh_.vertices.conservativeResize(static_cast<Eigen::Index>(points_.size()), 3);
    for (Eigen::Index v = old; v < mesh_.vertices.rows(); ++v) mesh_.vertices.row(v) = points_[v].transpose();
  }

 private:
  /// Off the line through a and b, next to its middle.
  std::int32_t vertex_beside(std::int32_t a, std::int32_t b) {
    const Eigen::Vector3d p = points_[a], q = points_[b];
    Eigen::Vector3d along = q - p;
    const double length = along.cwiseAbs().maxCoeff();
    along = length > 0 ? Eigen::Vector3d(along / length) : Eigen::Vector3d::UnitX();
    int axis = 0;
    along.cwiseAbs().minCoeff(&axis);
    const Eigen::Vector3d across = along.cross(Eigen::Vector3d::Unit(axis)).normalized();
    Eigen::Vector3d beside;
    double distance = thickness_;
    do {
      beside = p + (q - p) / 2 + distance * across;
      distance *= 2;  // until rounding does not bring it back onto the line
    } while (a == b ? beside == p : collinear(p, q, beside));
    points_.push_back(beside);
    return static_cast<std::int32_t>(points_.size()) - 1;
  }

  TriangleMesh& mesh_;
  double thickness_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<Triangle> added_;
};

/// Segments and points of triangles that repeat a vertex, each once, less those that an edge or a corner of the others
/// covers.
std::vector<Segment> uncovered_segments(const TriangleMesh& mesh, const EdgeTable& edges,
                                        const std::vector<std::int32_t>& repeating) {
  std::vector<Segment> segments;
  for (const std::int32_t t : repeating) segments.push_back(segment_of(mesh, t));
  std::sort(segments.begin(), segments.end());
  segments.erase(std::unique(segments.begin(), segments.end()), segments.end());

  std::vector<char> covered(static_cast<std::size_t>(mesh.vertices.rows()), 0);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    if (repeats_a_vertex(mesh.triangles, t)) continue;
    for (int k = 0; k < 3; ++k) covered[mesh.triangles(t, k)] = 1;
  }
  for (const auto& [a, b] : segments) {
    if (a != b) covered[a] = covered[b] = 2;  // as an end of another segment
  }
  std::erase_if(segments, [&](const Segment& s) {
    return s.first == s.second ? covered[s.first] != 0 : !edges.sides(s.first, s.second).empty();
  });
  return segments;
}

}  // namespace

void mark_dangling(TriangleMesh& mesh) {
  std::vector<std::int32_t> queue = collinear_triangles(mesh);
  if (queue.empty()) return;
  const EdgeTable edges(mesh.triangles, mesh.vertices.rows());
  std::vector<char> waiting(static_cast<std::size_t>(mesh.triangles.rows()), 0);
  std::vector<char> marked(waiting.size(), 0);
  for (const std::int32_t t : queue) waiting[t] = 1;
  const auto left = [&](std::span<const Side> sides) {
    return std::count_if(sides.begin(), sides.end(), [&](Side s) { return !marked[triangle_of(s)]; });
  };
  const Triangles original = mesh.triangles;
  for (std::size_t i = 0; i < queue.size(); ++i) {
    const std::int32_t t = queue[i];
    waiting[t] = 0;
    if (marked[t]) continue;
    for (int k = 0; k < 3 && !marked[t]; ++k) {
      marked[t] = left(edges.sides(original(t, k), original(t, (k + 1) % 3))) == 1;
    }
    if (!marked[t]) continue;
    const Segment segment = segment_of(mesh, t);
    mesh.triangles.row(t) << segment.first, segment.second, segment.second;
    // Its degenerate neighbours may hang in the air now.
    for (int k = 0; k < 3; ++k) {
      for (const Side s : edges.sides(original(t, k), original(t, (k + 1) % 3))) {
        const std::int32_t other = triangle_of(s);
        if (waiting[other] || marked[other] || !is_collinear(mesh, other)) continue;
        waiting[other] = 1;
        queue.push_back(other);
      }
    }
  }
}

std::int64_t replace_degenerate(TriangleMesh& mesh, double thickness) {
  std::vector<std::int32_t> repeating;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    if (repeats_a_vertex(mesh.triangles, t)) repeating.push_back(static_cast<std::int32_t>(t));
  }
  std::vector<std::int32_t> collinear = collinear_triangles(mesh);
  const std::int64_t count = static_cast<std::int64_t>(repeating.size() + collinear.size());
  if (count == 0) return 0;

  const EdgeTable edges(mesh.triangles, mesh.vertices.rows());
  const std::vector<Segment> segments = uncovered_segments(mesh, edges, repeating);
  Flipper flipper(mesh, edges);
  // A flip may give the next one its valid neighbour.
  for (std::size_t before = collinear.size() + 1; collinear.size() < before;) {
    before = collinear.size();
    std::erase_if(collinear, [&](std::int32_t t) { return flipper.flip(t); });
  }
  ThinTriangles thin(mesh, thickness);
  for (const std::int32_t t : collinear) thin.replace(t);
  for (const Segment& segment : segments) thin.cover(segment);
  std::vector<std::int32_t> drop(repeating);
  drop.insert(drop.end(), collinear.begin(), collinear.end());
  std::sort(drop.begin(), drop.end());
  thin.finish(drop);
  return count;
}

}  // namespace encage::io

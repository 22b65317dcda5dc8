// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/broadphase/exact_sweep.h"

#include "tests/broadphase/exact_pair.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace encage::test {
namespace {

using Box = Eigen::AlignedBox3d;

/// points[0] and points[1] ... by the numbers of their vertices: those of a first for edges,
/// the vertex first for faces.
struct FeaturePair {
  enum Kind : std::uint8_t { vertex_face, face_vertex, edge_edge } kind;
  std::array<std::int32_t, 4> vertices;
  auto operator<=>(const FeaturePair&) const = default;
};

std::vector<Box> swept_boxes(const MovingMesh& mesh) {
  std::vector<Box> boxes(mesh.triangles.rows());
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (const std::int32_t v : mesh.triangles.row(t)) {
      boxes[t].extend(mesh.start.row(v).transpose());
      boxes[t].extend(mesh.end.row(v).transpose());
    }
  }
  return boxes;
}

bool farther(const Box& a, const Box& b, double distance) {
  const Eigen::Array3d size = a.min().array().abs() + a.max().array().abs() + b.min().array().abs();
  const Eigen::Array3d reach = distance > 0 ? (distance + 1e-14 * (size + distance)).eval() : Eigen::Array3d::Zero();
  return ((a.max().array() + reach < b.min().array()) || (b.max().array() + reach < a.min().array())).any();
}

std::array<std::int32_t, 2> edge(const Triangles& triangles, std::int64_t t, int k) {
  const std::int32_t v = triangles(t, k), w = triangles(t, (k + 1) % 3);
  return {std::min(v, w), std::max(v, w)};
}

Corners corners_at_start(const MovingMesh& mesh, std::int64_t t) {
  Corners corners;
  for (int k = 0; k < 3; ++k) corners[k] = mesh.start.row(mesh.triangles(t, k)).transpose();
  return corners;
}

/// Pairs of triangles whose swept boxes are at most `distance` apart.
std::vector<std::array<std::int64_t, 2>> close_triangles(const MovingMesh& a, const MovingMesh& b, double distance) {
  const std::vector<Box> boxes_a = swept_boxes(a), boxes_b = swept_boxes(b);
  std::vector<std::array<std::int64_t, 2>> pairs;
  for (std::int64_t i = 0; i < a.triangles.rows(); ++i) {
    for (std::int64_t j = 0; j < b.triangles.rows(); ++j) {
      if (!farther(boxes_a[i], boxes_b[j], distance)) pairs.push_back({i, j});
    }
  }
  return pairs;
}

std::vector<FeaturePair> features(const MovingMesh& a, const MovingMesh& b,
                                  const std::vector<std::array<std::int64_t, 2>>& pairs) {
  std::vector<FeaturePair> all;
  for (const auto& [i, j] : pairs) {
    const auto p = a.triangles.row(i), q = b.triangles.row(j);
    for (int k = 0; k < 3; ++k) {
      all.push_back({FeaturePair::vertex_face, {p[k], q[0], q[1], q[2]}});
      all.push_back({FeaturePair::face_vertex, {q[k], p[0], p[1], p[2]}});
      for (int l = 0; l < 3; ++l) {
        const auto [a0, a1] = edge(a.triangles, i, k);
        const auto [b0, b1] = edge(b.triangles, j, l);
        all.push_back({FeaturePair::edge_edge, {a0, a1, b0, b1}});
      }
    }
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

MovingPoints points_of(const FeaturePair& pair, const MovingMesh& a, const MovingMesh& b) {
  MovingPoints points;
  for (int i = 0; i < 4; ++i) {
    const bool first = pair.kind == FeaturePair::edge_edge ? i < 2 : (pair.kind == FeaturePair::vertex_face) == (i < 1);
    const MovingMesh& mesh = first ? a : b;
    points.start[i] = mesh.start.row(pair.vertices[i]).transpose();
    points.end[i] = mesh.end.row(pair.vertices[i]).transpose();
  }
  return points;
}

Features kind_of(const FeaturePair& pair) {
  return pair.kind == FeaturePair::edge_edge ? Features::edge_edge : Features::vertex_face;
}

bool meet_at_start(const MovingMesh& a, const MovingMesh& b, const std::vector<std::array<std::int64_t, 2>>& pairs) {
  return std::any_of(pairs.begin(), pairs.end(), [&](const auto& pair) {
    return triangles_meet(corners_at_start(a, pair[0]), corners_at_start(b, pair[1]), 0);
  });
}

}  // namespace

MovingMesh moving_mesh(const Eigen::Vector3d& origin, const TriangleMesh& mesh, const Motion& motion) {
  const auto placed = [&](const Eigen::Isometry3d& pose) {
    Vertices vertices = mesh.vertices;
    for (std::int64_t v = 0; v < vertices.rows(); ++v) {
      vertices.row(v) = (pose * (origin + mesh.vertex(static_cast<std::int32_t>(v)))).transpose();
    }
    return vertices;
  };
  return {placed(motion.start), placed(motion.end), mesh.triangles};
}

std::optional<TimeBounds> exact_first_contact(const MovingMesh& a, const MovingMesh& b) {
  const auto pairs = close_triangles(a, b, 0);
  if (meet_at_start(a, b, pairs)) return TimeBounds{0, 0};
  std::optional<TimeBounds> first;
  for (const FeaturePair& pair : features(a, b, pairs)) {
    const auto time = exact_first_contact(kind_of(pair), points_of(pair, a, b));
    if (!time) continue;
    if (!first) first = time;
    first = TimeBounds{std::min(first->low, time->low), std::min(first->high, time->high)};
  }
  return first;
}

std::optional<double> first_within(const MovingMesh& a, const MovingMesh& b, double distance, double arc,
                                   double resolution) {
  const auto pairs = close_triangles(a, b, distance + arc);
  if (meet_at_start(a, b, pairs)) return 0.0;
  std::optional<double> first;
  for (const FeaturePair& pair : features(a, b, pairs)) {
    const auto time = first_within(kind_of(pair), points_of(pair, a, b), distance, arc, resolution);
    if (time && (!first || *time < *first)) first = time;
  }
  return first;
}

}  // namespace encage::test

// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/exact_sweep.h"

#include "oracles/exact_pair.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace encage::test {
namespace {

using Box = Eigen::AlignedBox3d;

/// points[0] and points[1] ..., given by the numbers of their vertices: a's come first for edges, the vertex comes
/// first for faces.
struct FeaturePair {
  enum Kind : std::uint8_t { vertex_face, face_vertex, edge_edge } kind;
  std::array<std::int32_t, 4> vertices;
  auto operator<=>(const FeaturePair&) const = default;
};

constexpr int spans = 32;  // spans of a step; a power of two

/// Boxes of a triangle at the ends of the spans.
using BoxTrack = std::array<Box, spans + 1>;

std::vector<BoxTrack> box_tracks(const MovingMesh& mesh) {
  std::vector<BoxTrack> tracks(mesh.triangles.rows());
  for (int i = 0; i <= spans; ++i) {
    const double t = static_cast<double>(i) / spans;
    for (std::int64_t f = 0; f < mesh.triangles.rows(); ++f) {
      for (const std::int32_t v : mesh.triangles.row(f)) {
        tracks[f][i].extend(((1 - t) * mesh.start.row(v) + t * mesh.end.row(v)).transpose());
      }
    }
  }
  return tracks;
}

/// `rounded` means that the boxes' bounds are off by some units in the last place.
bool farther(const Box& a, const Box& b, double distance, bool rounded) {
  const Eigen::Array3d size = a.min().array().abs() + a.max().array().abs() + b.min().array().abs();
  const Eigen::Array3d reach =
      distance > 0 || rounded ? (distance + 1e-14 * (size + distance)).eval() : Eigen::Array3d::Zero();
  return ((a.max().array() + reach < b.min().array()) || (b.max().array() + reach < a.min().array())).any();
}

/// At times between two ends, boxes lie in the box of both ends, since vertices move linearly.
bool farther(const BoxTrack& a, const BoxTrack& b, double distance, int from, int to) {
  const bool rounded = from > 0 || to < spans;
  if (farther(a[from].merged(a[to]), b[from].merged(b[to]), distance, rounded)) return true;
  if (to - from == 1) return false;
  const int middle = (from + to) / 2;
  return farther(a, b, distance, from, middle) && farther(a, b, distance, middle, to);
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

/// True if triangles meet at the start, or if `question` is true for some features that come close.
template <class Question>
bool any_features(const MovingMesh& a, const MovingMesh& b, double distance, Question&& question) {
  const auto pairs = close_triangles(a, b, distance);
  if (meet_at_start(a, b, pairs)) return true;
  const std::vector<FeaturePair> all = features(a, b, pairs);
  return std::any_of(all.begin(), all.end(), question);
}

}  // namespace

std::vector<std::array<std::int64_t, 2>> close_triangles(const MovingMesh& a, const MovingMesh& b, double distance) {
  const std::vector<BoxTrack> boxes_a = box_tracks(a), boxes_b = box_tracks(b);
  std::vector<std::array<std::int64_t, 2>> pairs;
  for (std::int64_t i = 0; i < a.triangles.rows(); ++i) {
    for (std::int64_t j = 0; j < b.triangles.rows(); ++j) {
      if (!farther(boxes_a[i], boxes_b[j], distance, 0, spans)) pairs.push_back({i, j});
    }
  }
  return pairs;
}

MovingMesh moving_mesh(const Eigen::Vector3d& origin, const TriangleMesh& mesh, const Motion& motion) {
  const auto placed = [&](const Eigen::Isometry3d& pose) {
    Vertices vertices = mesh.vertices;
    for (std::int64_t v = 0; v < vertices.rows(); ++v) {
      vertices.row(v) = (pose * (motion.scale * (origin + mesh.vertex(static_cast<std::int32_t>(v))))).transpose();
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

bool exact_contact(const MovingMesh& a, const MovingMesh& b) {
  return any_features(a, b, 0, [&](const FeaturePair& pair) {
    return exact_first_contact(kind_of(pair), points_of(pair, a, b)).has_value();
  });
}

bool come_within(const MovingMesh& a, const MovingMesh& b, double distance, double resolution) {
  return any_features(a, b, distance, [&](const FeaturePair& pair) {
    return first_within(kind_of(pair), points_of(pair, a, b), distance, 0, resolution).has_value();
  });
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

// SPDX-License-Identifier: Apache-2.0
#include "broadphase/contact/surface_features.h"

#include "broadphase/separation/triangle_pair.h"
#include "src/tree/visit.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

Vector vertex(const MeshView& mesh, std::uint32_t v) {
  return Eigen::Map<const Eigen::Vector3f>(mesh.vertices[v].data()).cast<double>();
}

TriangleD corners(const MeshView& mesh, std::int32_t triangle) {
  const auto& t = mesh.triangles[static_cast<std::size_t>(triangle)];
  return {vertex(mesh, t[0]), vertex(mesh, t[1]), vertex(mesh, t[2])};
}

double angle(const Vector& a, const Vector& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

std::vector<std::int32_t> find_twins(const MeshView& mesh) {
  struct Entry {
    std::uint64_t edge;  // lower vertex, higher vertex
    std::int32_t side;
    bool operator<(const Entry& other) const { return edge != other.edge ? edge < other.edge : side < other.side; }
  };
  std::vector<Entry> entries;
  entries.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t u = mesh.triangles[t][k], v = mesh.triangles[t][(k + 1) % 3];
      entries.push_back({std::min(u, v) << 32 | std::max(u, v), static_cast<std::int32_t>(3 * t + k)});
    }
  }
  std::sort(entries.begin(), entries.end());
  std::vector<std::int32_t> twin(entries.size(), -1);
  for (std::size_t i = 0; i < entries.size();) {
    std::size_t end = i + 1;
    while (end < entries.size() && entries[end].edge == entries[i].edge) ++end;
    if (end - i == 2) {
      twin[static_cast<std::size_t>(entries[i].side)] = entries[i + 1].side;
      twin[static_cast<std::size_t>(entries[i + 1].side)] = entries[i].side;
    }
    i = end;
  }
  return twin;
}

/// The squared distance from p to the boxes of a node, in grid steps.
void box_distances(const MeshNode& node, const Vector& p, std::array<double, MeshNode::width>& squared) {
  squared.fill(0);
  for (int axis = 0; axis < 3; ++axis) {
    for (int lane = 0; lane < MeshNode::width; ++lane) {
      const double beside = std::max({node.lower[axis][lane] - p[axis], p[axis] - node.upper[axis][lane], 0.0});
      squared[static_cast<std::size_t>(lane)] += beside * beside;
    }
  }
}

/// The nearest point of a triangle (Ericson 2005, section 5.1.5), and the feature that it lies on.
SurfacePoint nearest_in_triangle(const Vector& p, const TriangleD& t) {
  using Kind = SurfacePoint::Kind;
  SurfacePoint best;
  const Vector n = (t[1] - t[0]).cross(t[2] - t[0]);
  double side[3];
  for (int k = 0; k < 3; ++k) side[k] = n.cross(t[(k + 1) % 3] - t[k]).dot(p - t[k]);
  const double squared = n.squaredNorm();
  if (squared > 0 && side[0] > 0 && side[1] > 0 && side[2] > 0) {
    best.point = p - (n.dot(p - t[0]) / squared) * n;
    best.distance = (p - best.point).norm();
    return best;
  }
  best.distance = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vector &a = t[k], along = t[(k + 1) % 3] - a;
    const double length = along.squaredNorm();
    const double s = length > 0 ? std::clamp(along.dot(p - a) / length, 0.0, 1.0) : 0;
    const Vector q = s >= 1 ? t[(k + 1) % 3] : Vector(a + s * along);
    const double distance = (p - q).norm();
    if (distance >= best.distance) continue;
    best.point = q;
    best.distance = distance;
    best.kind = s <= 0 || s >= 1 ? Kind::vertex : Kind::edge;
    best.corner = s >= 1 ? (k + 1) % 3 : k;
  }
  return best;
}

}  // namespace

SurfaceFeatures make_surface_features(const MeshView& mesh) {
  SurfaceFeatures features;
  features.twin = find_twins(mesh);
  std::vector<Vector> sums(mesh.vertices.size(), Vector::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const TriangleD c = corners(mesh, static_cast<std::int32_t>(t));
    const Vector n = unit_normal(c);
    for (std::size_t k = 0; k < 3; ++k) {
      sums[mesh.triangles[t][k]] += angle(c[(k + 1) % 3] - c[k], c[(k + 2) % 3] - c[k]) * n;
    }
  }
  features.vertex_normal.reserve(sums.size());
  for (const Vector& sum : sums) features.vertex_normal.push_back(sum.stableNormalized().cast<float>());
  return features;
}

bool nearest_point(const MeshArraysView& surface, const Vector& p, double reach, SurfacePoint& nearest) {
  const MeshTreeView& tree = surface.tree;
  const double step = static_cast<double>(tree.grid.step);
  Vector at;
  for (int axis = 0; axis < 3; ++axis) at[axis] = tree.grid.coordinate(axis, p[axis]);
  struct Entry {
    std::int32_t node;
    double squared;
  };
  std::array<Entry, traversal_stack_size> stack;
  int size = 0;
  stack[static_cast<std::size_t>(size++)] = {0, 0};
  nearest.distance = reach;
  nearest.triangle = -1;
  // Grid coordinates of the point and of the boxes round by a few units.
  const double slack = 1e-12 * (at.norm() + MeshNode::slab_unit * MeshNode::slab_unit);
  const auto out_of_reach = [&](double squared) {
    const double limit = nearest.distance / step + slack;
    return squared > limit * limit;
  };
  while (size > 0) {
    const Entry entry = stack[static_cast<std::size_t>(--size)];
    if (out_of_reach(entry.squared)) continue;
    const MeshNode& node = tree.nodes[static_cast<std::size_t>(entry.node)];
    std::array<double, MeshNode::width> squared;
    box_distances(node, at, squared);
    const int first = size;
    for (int lane = 0; lane < MeshNode::width; ++lane) {
      const int count = node.count(lane);
      const double lane_squared = squared[static_cast<std::size_t>(lane)];
      if (count == MeshNode::unused) break;
      if (out_of_reach(lane_squared)) continue;
      if (count == MeshNode::inner) {
        stack[static_cast<std::size_t>(size++)] = {node.child(lane), lane_squared};
        continue;
      }
      for (int i = 0; i < count; ++i) {
        const LeafTriangle& leaf = tree.leaves[static_cast<std::size_t>(node.child(lane) + i)];
        SurfacePoint found = nearest_in_triangle(p, corners(surface.mesh, leaf.triangle));
        found.triangle = leaf.triangle;
        const bool better = found.distance < nearest.distance ||
                            (found.distance == nearest.distance && nearest.triangle > leaf.triangle);
        if (better) nearest = found;
      }
    }
    // The nearest one last, to be opened first.
    std::sort(stack.begin() + first, stack.begin() + size,
              [](const Entry& x, const Entry& y) { return x.squared > y.squared; });
  }
  return nearest.triangle >= 0;
}

Vector feature_normal(const MeshArraysView& surface, const SurfaceFeatures& features, const SurfacePoint& point) {
  const MeshView& mesh = surface.mesh;
  switch (point.kind) {
    case SurfacePoint::Kind::vertex: {
      const std::uint32_t v =
          mesh.triangles[static_cast<std::size_t>(point.triangle)][static_cast<std::size_t>(point.corner)];
      return features.vertex_normal[v].cast<double>();
    }
    case SurfacePoint::Kind::edge: {
      const std::int32_t twin = features.twin[static_cast<std::size_t>(3 * point.triangle + point.corner)];
      const Vector own = unit_normal(corners(mesh, point.triangle));
      return twin < 0 ? own : Vector((own + unit_normal(corners(mesh, twin / 3))).stableNormalized());
    }
    case SurfacePoint::Kind::face: break;
  }
  return unit_normal(corners(mesh, point.triangle));
}

}  // namespace encage

// SPDX-License-Identifier: Apache-2.0
#include "broadphase/contact/nearest_point.h"

#include "src/tree/visit.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
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

}  // namespace

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

bool nearest_point(const MeshArraysView& surface, const Vector& p, double reach, SurfacePoint& nearest,
                   const NormalFilter& filter) {
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
      for (const LeafTriangle& leaf :
           tree.leaves.subspan(static_cast<std::size_t>(node.child(lane)), static_cast<std::size_t>(count))) {
        const TriangleD triangle = corners(surface.mesh, leaf.triangle);
        SurfacePoint found = nearest_in_triangle(p, triangle);
        found.triangle = leaf.triangle;
        const bool better = found.distance < nearest.distance ||
                            (found.distance == nearest.distance && nearest.triangle > leaf.triangle);
        if (better && (filter.most >= 1 || unit_normal(triangle).dot(filter.axis) < filter.most)) nearest = found;
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
      const std::int32_t twin = features.twin_of(3 * point.triangle + point.corner);
      const auto normal = [&](std::int32_t t) {
        return features.face_normal[static_cast<std::size_t>(t)].cast<double>();
      };
      if (twin < 0) break;
      return (normal(point.triangle) + normal(twin / 3)).normalized();
    }
    case SurfacePoint::Kind::face: break;
  }
  return features.face_normal[static_cast<std::size_t>(point.triangle)].cast<double>();
}

}  // namespace encage

// SPDX-License-Identifier: Apache-2.0
#include "broadphase/contact/contact_body.h"

#include "broadphase/separation/containment.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

/// Sine of the angle between the triangles of an edge below which the edge counts as flat: normals are rounded to
/// float.
constexpr double flat_edge = 1e-6;

}  // namespace

void ContactBody::place(const MovingPart& moving, const AffineMap& to_common, std::int32_t number) {
  surface = &moving.shape->fine;
  mesh = surface->surroundings;
  shape = moving.shape->number;
  features = &moving.shape->features();
  scale = moving.motion.scale;
  rotation = to_common.linear;
  map = {scale * rotation, to_common.offset};
  inverse.linear = map.linear.inverse();
  inverse.offset = -(inverse.linear * map.offset);
  solid = interior(*moving.shape) == Interior::enclosed;
  round = surface->mesh.triangles.size() == 1 && unit_normal(triangle(0)).isZero();
  first_vertex = moving.first_vertex;
  first_triangle = moving.first_triangle;
  part = number;
}

std::int32_t ContactBody::add_vertex(std::int32_t t, int corner) {
  const std::int32_t v = vertex_number(t, corner);
  ContactVertex entry;
  entry.position = located(v);
  entry.normal =
      solid ? direction(features->vertex_normal[static_cast<std::size_t>(v)].cast<double>()) : Vector::Zero();
  entry.most_cosine = entry.normal.isZero() ? 2 : facing_cosine;
  entry.vertex = v;
  entry.side = 3 * t + corner;
  const auto index = static_cast<std::int32_t>(vertices.size());
  vertices.push_back(entry);
  vertex_index.insert(v, index);
  return index;
}

std::int32_t ContactBody::vertex(std::int32_t t, int corner) {
  const std::int32_t known = vertex_index[vertex_number(t, corner)];
  return known >= 0 ? known : add_vertex(t, corner);
}

bool ContactBody::edge(std::int32_t t, int k, const TriangleD& corners, const Vector& normal, ContactEdge& edge) const {
  edge.start = corners[static_cast<std::size_t>(k)];
  edge.along = corners[static_cast<std::size_t>((k + 1) % 3)] - edge.start;
  edge.length = edge.along.norm();
  if (!(edge.length > 0)) return false;
  edge.side = 3 * t + k;
  edge.out = {edge.along.cross(normal) / edge.length, Vector::Zero()};
  const std::int32_t twin = features->twin_of(edge.side);
  if (twin < 0) return true;
  const Vector other = face_normal(twin / 3);
  const double bend = other.dot(edge.out[0]);
  // Edges of degenerate triangles may point anywhere, and between two faces that coincide is a blade or a slit.
  const bool may_be_sharp = normal.isZero() || other.isZero() || (std::abs(bend) <= flat_edge && other.dot(normal) < 0);
  if (!may_be_sharp && (solid ? bend : std::abs(bend)) <= flat_edge) return false;
  edge.out[1] = other.cross(edge.along) / edge.length;
  return true;
}

void ContactBody::add_edges(std::int32_t t, const TriangleD& corners, const Vector& normal, unsigned owned,
                            ContactLeaf& leaf) {
  for (int k = 0; k < 3; ++k) {
    ContactEdge added;
    if ((owned >> (3 + k) & 1U) == 0 || !edge(t, k, corners, normal, added)) continue;
    if (leaf.edge_blocks == 0 || edges.back().length.back() > 0) {
      edges.emplace_back();
      ++leaf.edge_blocks;
    }
    ContactEdges& block = edges.back();
    const auto lane =
        static_cast<std::size_t>(std::find(block.length.begin(), block.length.end(), 0.0) - block.length.begin());
    const auto store = [&](ContactEdges::Vectors& to, const Vector& v) {
      for (std::size_t i = 0; i < 3; ++i) to[i][lane] = v[static_cast<Eigen::Index>(i)];
    };
    store(block.start, added.start);
    store(block.along, added.along);
    store(block.out[0], added.out[0]);
    store(block.out[1], added.out[1]);
    block.length[lane] = added.length;
    block.side[lane] = added.side;
  }
}

std::int32_t ContactBody::leaf(std::int32_t first, std::int32_t count) {
  const std::int32_t known = leaf_index[first];
  if (known >= 0) return known;
  const auto index = static_cast<std::int32_t>(leaves.size());
  leaf_index.insert(first, index);
  leaves.emplace_back();
  ContactLeaf& leaf = leaves.back();
  leaf.count = count;
  leaf.first_vertex = static_cast<std::int32_t>(vertices.size());
  leaf.first_edges = static_cast<std::int32_t>(edges.size());
  for (int lane = 0; lane < ContactLeaf::width; ++lane) {
    const std::int32_t at = first + std::min(lane, count - 1);
    const std::int32_t t = surface->tree.leaves[static_cast<std::size_t>(at)].triangle;
    const TriangleD corners = triangle(t);
    const Vector normal = face_normal(t);
    leaf.set(lane, t, corners, normal);
    if (lane >= count) continue;
    const unsigned owned = surface->owned[static_cast<std::size_t>(t)];
    for (int k = 0; k < 3; ++k) {
      if ((owned >> k & 1U) == 0) continue;
      add_vertex(t, k);
      ++leaf.vertex_count;
    }
    add_edges(t, corners, normal, owned, leaf);
  }
  return index;
}

}  // namespace encage

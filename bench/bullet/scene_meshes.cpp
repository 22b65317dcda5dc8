// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/scene_meshes.h"

#include "src/mesh/portable_trig.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

namespace encage::bullet_bench {
namespace {

/// A point of a profile: its distance from the axis, and its height.
struct ProfilePoint {
  double radius = 0, height = 0;
};

/// The surface that a profile from the axis to the axis sweeps about z; the interior is on its left.
TriangleMesh revolve(const std::vector<ProfilePoint>& profile, int around) {
  MeshBuilder builder;
  std::vector<std::vector<std::int32_t>> rings;
  for (const ProfilePoint& p : profile) {
    std::vector<std::int32_t>& ring = rings.emplace_back();
    for (int i = 0; i < around; ++i) {
      const SinCos turn = sincos_turns(static_cast<double>(i) / around);
      ring.push_back(builder.add_vertex({p.radius * turn.cos, p.radius * turn.sin, p.height}));
    }
  }
  for (std::size_t k = 0; k + 1 < rings.size(); ++k) {
    for (int i = 0; i < around; ++i) {
      const int j = (i + 1) % around;
      builder.add_quad(rings[k][i], rings[k][j], rings[k + 1][j], rings[k + 1][i]);
    }
  }
  return builder.mesh();
}

}  // namespace

std::int32_t MeshBuilder::add_vertex(const Eigen::Vector3d& p) {
  vertices_.push_back(p);
  return static_cast<std::int32_t>(vertices_.size()) - 1;
}

void MeshBuilder::add_triangle(std::int32_t a, std::int32_t b, std::int32_t c) { triangles_.emplace_back(a, b, c); }

void MeshBuilder::add_quad(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
  add_triangle(a, b, c);
  add_triangle(a, c, d);
}

TriangleMesh MeshBuilder::mesh() const {
  std::map<std::array<float, 3>, std::int32_t> numbers;
  std::vector<std::array<float, 3>> points;
  std::vector<std::int32_t> number;
  for (const Eigen::Vector3d& v : vertices_) {
    // Float32, as engines store them; adding 0 turns -0 into 0.
    const std::array<float, 3> p = {static_cast<float>(v.x()) + 0.F, static_cast<float>(v.y()) + 0.F,
                                    static_cast<float>(v.z()) + 0.F};
    const auto [at, added] = numbers.try_emplace(p, static_cast<std::int32_t>(points.size()));
    if (added) points.push_back(p);
    number.push_back(at->second);
  }
  std::vector<Eigen::Vector3i> kept;
  for (const Eigen::Vector3i& t : triangles_) {
    const Eigen::Vector3i corners(number[t[0]], number[t[1]], number[t[2]]);
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    kept.push_back(corners);
  }
  TriangleMesh mesh{Vertices(static_cast<Eigen::Index>(points.size()), 3),
                    Triangles(static_cast<Eigen::Index>(kept.size()), 3)};
  for (std::size_t v = 0; v < points.size(); ++v) {
    for (int k = 0; k < 3; ++k) mesh.vertices(static_cast<Eigen::Index>(v), k) = points[v][k];
  }
  for (std::size_t t = 0; t < kept.size(); ++t) mesh.triangles.row(static_cast<Eigen::Index>(t)) = kept[t].transpose();
  return mesh;
}

TriangleMesh make_torus(const Torus& torus) {
  MeshBuilder builder;
  std::vector<std::int32_t> ids;
  for (int i = 0; i < torus.around; ++i) {
    const SinCos turn = sincos_turns(static_cast<double>(i) / torus.around);
    for (int j = 0; j < torus.across; ++j) {
      const SinCos tube = sincos_turns(static_cast<double>(j) / torus.across);
      const double radius = torus.ring_radius + torus.tube_radius * tube.cos;
      ids.push_back(builder.add_vertex({radius * turn.cos, radius * turn.sin, torus.tube_radius * tube.sin}));
    }
  }
  const auto id = [&](int i, int j) { return ids[(i % torus.around) * torus.across + j % torus.across]; };
  for (int i = 0; i < torus.around; ++i) {
    for (int j = 0; j < torus.across; ++j) builder.add_quad(id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
  }
  return builder.mesh();
}

TriangleMesh make_bowl(const Bowl& bowl) {
  // Even steps along the radius, one ring on the edge of the foot.
  std::vector<ProfilePoint> outer;
  std::vector<ProfilePoint> inner;
  const double wall = bowl.radius - bowl.foot;
  const int foot_rings = std::max(1, static_cast<int>(std::lround(bowl.along * 0.7 * bowl.foot / bowl.radius)));
  for (int i = 0; i <= bowl.along; ++i) {
    const double radius =
        i <= foot_rings ? bowl.foot * i / foot_rings : bowl.foot + wall * (i - foot_rings) / (bowl.along - foot_rings);
    const double share = std::max(0.0, (radius - bowl.foot) / wall);
    const double slope = 2 * bowl.depth * share / wall, length = std::sqrt(1 + slope * slope);
    const ProfilePoint p{radius, bowl.depth * share * share};
    outer.push_back(p);
    inner.push_back({p.radius - bowl.thickness * slope / length, p.height + bowl.thickness / length});
  }
  std::vector<ProfilePoint> profile = outer;
  const ProfilePoint from = outer.back(), to = inner.back();
  const ProfilePoint middle{(from.radius + to.radius) / 2, (from.height + to.height) / 2};
  // The half circle from `from` to `to` that bulges along the wall.
  const double x = from.radius - middle.radius, z = from.height - middle.height;
  for (int k = 1; k < bowl.rim; ++k) {
    const SinCos turn = sincos_turns(0.5 * k / bowl.rim);
    profile.push_back({middle.radius + x * turn.cos - z * turn.sin, middle.height + x * turn.sin + z * turn.cos});
  }
  for (auto p = inner.rbegin(); p != inner.rend(); ++p) profile.push_back(*p);
  return revolve(profile, bowl.around);
}

}  // namespace encage::bullet_bench

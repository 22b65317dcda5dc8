// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/sample_shapes.h"

#include "oracles/meshes.h"

#include <cmath>
#include <random>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;
using shapes::box, shapes::cube, shapes::flipped, shapes::joined, shapes::moved, shapes::torus;
using Polygon = std::vector<Eigen::Vector2d>;

TriangleMesh make(const std::vector<Vector>& vertices, const std::vector<Eigen::Vector3i>& triangles) {
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<std::int64_t>(vertices.size()), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v) mesh.vertices.row(v) = vertices[v].transpose();
  mesh.triangles.resize(static_cast<std::int64_t>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) mesh.triangles.row(t) = triangles[t].transpose();
  return mesh;
}

TriangleMesh rounded(TriangleMesh mesh) {
  mesh.vertices = mesh.vertices.cast<float>().cast<double>();
  return mesh;
}

TriangleMesh tetrahedron() {
  return make({{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
}

/// An octahedron split once: 32 triangles, with every other vertex pulled in.
TriangleMesh star() {
  const std::vector<Vector> corner = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<Vector> vertices = corner;
  std::vector<Eigen::Vector3i> triangles;
  std::vector<std::vector<int>> middle(6, std::vector<int>(6, -1));
  const auto mid = [&](int a, int b) {
    int& m = middle[std::min(a, b)][std::max(a, b)];
    if (m < 0) {
      m = static_cast<int>(vertices.size());
      vertices.push_back((corner[a] + corner[b]) * 0.28);
    }
    return m;
  };
  for (int i = 0; i < 8; ++i) {
    int a = i & 1, b = 2 + (i >> 1 & 1), c = 4 + (i >> 2 & 1);
    if ((a + b + c) % 2 == 1) std::swap(b, c);
    const int ab = mid(a, b), bc = mid(b, c), ca = mid(c, a);
    for (const Eigen::Vector3i& t : {Eigen::Vector3i(a, ab, ca), Eigen::Vector3i(ab, b, bc), Eigen::Vector3i(ca, bc, c),
                                     Eigen::Vector3i(ab, bc, ca)}) {
      triangles.push_back(t);
    }
  }
  return make(vertices, triangles);
}

/// Extrudes a simple polygon (its corners counter-clockwise, with its triangles) along z.
TriangleMesh prism(const Polygon& polygon, const std::vector<Eigen::Vector3i>& triangles, double bottom, double top) {
  const int n = static_cast<int>(polygon.size());
  std::vector<Vector> v;
  for (const Eigen::Vector2d& p : polygon) v.emplace_back(p.x(), p.y(), bottom);
  for (const Eigen::Vector2d& p : polygon) v.emplace_back(p.x(), p.y(), top);
  std::vector<Eigen::Vector3i> faces;
  for (const Eigen::Vector3i& t : triangles) {
    faces.emplace_back(t[0], t[2], t[1]);
    faces.emplace_back(t[0] + n, t[1] + n, t[2] + n);
  }
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    faces.emplace_back(i, j, j + n);
    faces.emplace_back(i, j + n, i + n);
  }
  return make(v, faces);
}

const std::vector<Eigen::Vector3i> l_triangles = {{0, 1, 3}, {1, 2, 3}, {0, 3, 5}, {3, 4, 5}};
Polygon l_polygon(double d) {
  return {{-1 - d, -1 - d},     {1 + d, -1 - d},   {1 + d, -0.4 + d},
          {-0.4 + d, -0.4 + d}, {-0.4 + d, 1 + d}, {-1 - d, 1 + d}};
}

const std::vector<Eigen::Vector3i> u_triangles = {{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}, {0, 5, 6}, {0, 6, 7}};
Polygon u_polygon(double d) {
  return {{-1 - d, -1 - d},    {1 + d, -1 - d},      {1 + d, 1 + d},    {0.5 - d, 1 + d},
          {0.5 - d, -0.5 + d}, {-0.5 + d, -0.5 + d}, {-0.5 + d, 1 + d}, {-1 - d, 1 + d}};
}

TriangleMesh l_prism(double d) { return prism(l_polygon(d), l_triangles, -0.5 - d, 0.5 + d); }
TriangleMesh u_prism(double d) { return prism(u_polygon(d), u_triangles, -0.4 - d, 0.4 + d); }

TriangleMesh shell(double d) { return joined(cube(1 + d), flipped(cube(0.8 - d))); }

TriangleMesh two_boxes(double d) {
  return joined(box({-1.2 - d, -0.5 - d, -0.3 - d}, {-0.3 + d, 0.5 + d, 0.3 + d}),
                box({0.3 - d, -0.5 - d, -0.6 - d}, {1.1 + d, 0.4 + d, 0.2 + d}));
}

/// A box without a lid, i.e. without two triangles.
TriangleMesh open_box() {
  TriangleMesh mesh = cube(1);
  mesh.triangles.middleRows(2, 8) = mesh.triangles.bottomRows(8).eval();  // the lid: triangles 2 and 3
  mesh.triangles.conservativeResize(10, 3);
  return mesh;
}

/// A closed box with a spike: a degenerate triangle that shares no vertex, as in real inputs.
TriangleMesh spiked_box() {
  return joined(cube(0.7), make({{0.6, 0.1, 0}, {1.3, 0.2, 0.125}, {0.95, 0.15, 0.0625}}, {{0, 1, 2}, {0, 2, 1}}));
}

/// Both sides of a sheet: closed, with nothing inside.
TriangleMesh doubled(TriangleMesh sheet) {
  const Triangles back = flipped(sheet).triangles;
  sheet.triangles.conservativeResize(2 * back.rows(), 3);
  sheet.triangles.bottomRows(back.rows()) = back;
  return sheet;
}

/// A long prism over a thin triangle.
TriangleMesh needle(double half, double thin) {
  return prism({{-thin, -thin}, {thin, -thin}, {0, thin}}, {{0, 1, 2}}, -half, half);
}

/// A double cone whose rim turns only slightly from corner to corner: slivers about the axis.
TriangleMesh fan() {
  constexpr int count = 12;
  std::vector<Vector> v = {{0, 0, 1}, {0, 0, -1}};
  std::vector<Eigen::Vector3i> f;
  for (int i = 0; i < count; ++i) {
    // All but three corners are close together.
    const double angle = i < 3 ? 2.1 * i : 4.2 + 1e-4 * (i - 2);
    v.emplace_back(std::cos(angle), std::sin(angle), 0);
    const int a = 2 + i, b = 2 + (i + 1) % count;
    f.emplace_back(0, a, b);
    f.emplace_back(1, b, a);
  }
  return make(v, f);
}

/// A box with a tetrahedron of size 2e-4 on its largest face.
TriangleMesh spiky_box() {
  TriangleMesh mesh = box({-1, -1, -0.5}, {1, 1, 0.5});
  constexpr double tiny = 0x1p-13;
  return joined(mesh, moved(shapes::scaled(tetrahedron(), tiny), {0.25, -0.375, 0.5 + tiny}));
}

/// A box around a sheet, at the same distance on all sides.
TriangleMesh around_sheet(int across, double half, double distance) {
  Vector upper = Vector::Constant(half + distance);
  upper[across] = distance;
  return box(-upper, upper);
}

Sample sample(const std::string& name, const TriangleMesh& fine, const std::vector<TriangleMesh>& cages, double jitter,
              Solid solid = Solid::closed) {
  Sample s;
  s.name = name;
  s.hierarchy.fine = rounded(fine);
  s.hierarchy.solid = solid;
  s.source = s.hierarchy.fine;
  std::minstd_rand random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (std::int64_t v = 0; v < s.source.vertices.rows(); ++v) {
    const Vector d(uniform(random), uniform(random), uniform(random));
    s.source.vertices.row(v) += (d * (jitter / std::max(1e-3, d.norm()) * 0.999)).transpose();
  }
  s.hierarchy.fine_error = jitter;
  const Eigen::AlignedBox3d box = bounds(s.source);
  s.hierarchy.diagonal = box.diagonal().norm();
  for (const TriangleMesh& cage : cages) s.hierarchy.levels.push_back({rounded(cage), {}});
  return s;
}

}  // namespace

std::vector<Sample> sample_shapes(double jitter) {
  return {
      sample("tetrahedron", tetrahedron(), {shapes::scaled(tetrahedron(), 1.1), cube(1.4)}, jitter),
      sample("box", cube(1), {cube(1.05), cube(1.3)}, jitter),
      sample("star", star(), {shapes::scaled(star(), 1.05), shapes::scaled(star(), 1.2), cube(1.3)}, jitter),
      sample("l", l_prism(0), {l_prism(0.04), cube(1.2)}, jitter),
      sample("u", u_prism(0), {u_prism(0.05), u_prism(0.2), cube(1.3)}, jitter),
      sample("torus", torus(1, 0.35, 8, 4), {torus(1, 0.42, 8, 4), torus(1, 0.6, 8, 4)}, jitter),
      sample("shell", shell(0), {shell(0.03), shell(0.2), cube(1.3)}, jitter),
      sample("two boxes", two_boxes(0), {two_boxes(0.05), two_boxes(0.2), cube(1.5)}, jitter),
      sample("open box", open_box(), {cube(1.1), cube(1.3)}, jitter, Solid::surface_only),
      sample("spiked box", spiked_box(), {cube(1.4)}, jitter, Solid::capped),
  };
}

std::vector<Sample> large_sample_shapes(double jitter) {
  return {
      sample("sphere", shapes::sphere(4), {shapes::scaled(shapes::sphere(2), 1.1), cube(1.3)}, jitter),
      sample("fine torus", torus(1, 0.35, 32, 16), {torus(1, 0.4, 32, 16), torus(1, 0.6, 16, 4)}, jitter),
  };
}

std::vector<Sample> flat_shapes(double jitter) {
  return {
      sample("sheet", sheet(2, 2, 1), {around_sheet(2, 1, 0.05), cube(1.3)}, jitter, Solid::surface_only),
      sample("doubled sheet", doubled(sheet(3, 0, 1)), {around_sheet(0, 1, 0.05), cube(1.3)}, jitter),
      sample("wide sheet", doubled(sheet(3, 1, 1024)), {around_sheet(1, 1024, 0.5), cube(1100)}, jitter),
  };
}

std::vector<Sample> thin_shapes(double jitter) {
  const Vector corner(2e-3, 2e-3, 1.003);
  return {
      sample("needle", needle(1, 1e-4), {box(-corner, corner), cube(1.2)}, jitter),
      sample("fan", fan(), {shapes::scaled(fan(), 1.1), cube(1.3)}, jitter),
      sample("tiny feature", spiky_box(), {box({-1.02, -1.02, -0.52}, {1.02, 1.02, 0.52}), cube(1.2)}, jitter),
  };
}

std::vector<Sample> large_flat_shapes(double jitter) {
  return {
      sample("fine sheet", sheet(32, 1, 1), {around_sheet(1, 1, 0.05), cube(1.3)}, jitter, Solid::surface_only),
      sample("fine wide sheet", doubled(sheet(22, 2, 1024)), {around_sheet(2, 1024, 0.5), cube(1100)}, jitter),
  };
}

TriangleMesh sheet(int n, int across, double half) {
  TriangleMesh mesh;
  mesh.vertices.setZero((n + 1) * (n + 1), 3);
  mesh.triangles.resize(2 * n * n, 3);
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      const int v = i * (n + 1) + j;
      mesh.vertices(v, (across + 1) % 3) = half * (2.0 * i / n - 1);
      mesh.vertices(v, (across + 2) % 3) = half * (2.0 * j / n - 1);
      if (i == n || j == n) continue;
      mesh.triangles.row(2 * (i * n + j)) << v, v + n + 1, v + 1;
      mesh.triangles.row(2 * (i * n + j) + 1) << v + 1, v + n + 1, v + n + 2;
    }
  }
  return mesh;
}

Sample scaled(const Sample& sample, int exponent) {
  Sample s = sample;
  const double factor = std::ldexp(1.0, exponent);
  s.source.vertices *= factor;
  s.hierarchy.fine.vertices *= factor;
  s.hierarchy.fine_error *= factor;
  s.hierarchy.diagonal *= factor;
  for (CageLevel& level : s.hierarchy.levels) level.mesh.vertices *= factor;
  return s;
}

Sample without_cages(Sample sample) {
  sample.hierarchy.levels.clear();
  return sample;
}

Sample without_fine(Sample sample) {
  sample.hierarchy.fine = {};
  sample.hierarchy.fine_error = 0;
  return sample;
}

}  // namespace encage::test

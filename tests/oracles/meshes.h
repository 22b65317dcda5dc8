// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

// Small meshes with known properties.
namespace encage::shapes {

inline TriangleMesh mesh(const std::vector<std::array<double, 3>>& vertices,
                         const std::vector<std::array<std::int32_t, 3>>& triangles) {
  TriangleMesh m;
  m.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  m.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (int k = 0; k < 3; ++k) m.vertices(static_cast<Eigen::Index>(i), k) = vertices[i][k];
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) m.triangles(static_cast<Eigen::Index>(i), k) = triangles[i][k];
  }
  return m;
}

/// Returns an axis-parallel box of 12 triangles, oriented outward.
inline TriangleMesh box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  std::vector<std::array<double, 3>> v;
  for (int i = 0; i < 8; ++i) {
    v.push_back({i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]});
  }
  return mesh(v, {{0, 2, 3},
                  {0, 3, 1},
                  {4, 5, 7},
                  {4, 7, 6},
                  {0, 1, 5},
                  {0, 5, 4},
                  {2, 6, 7},
                  {2, 7, 3},
                  {0, 4, 6},
                  {0, 6, 2},
                  {1, 3, 7},
                  {1, 7, 5}});
}

inline TriangleMesh cube(double half, const Eigen::Vector3d& centre = Eigen::Vector3d::Zero()) {
  return box(centre.array() - half, centre.array() + half);
}

inline TriangleMesh tetrahedron(double size, const Eigen::Vector3d& at = Eigen::Vector3d::Zero()) {
  TriangleMesh m =
      mesh({{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, size}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}});
  m.vertices.rowwise() += at.transpose();
  return m;
}

/// Returns an octahedron subdivided `levels` times, with vertices on the unit sphere, oriented outward.
inline TriangleMesh sphere(int levels) {
  std::vector<std::array<double, 3>> v = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<std::array<std::int32_t, 3>> f = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                                {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
    const auto middle = [&](std::int32_t a, std::int32_t b) {
      const auto [it, added] = middles.try_emplace(std::minmax(a, b), static_cast<std::int32_t>(v.size()));
      if (added) {
        std::array<double, 3> m{};
        for (int k = 0; k < 3; ++k) m[k] = v[a][k] + v[b][k];
        const double length = std::sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
        for (double& x : m) x /= length;
        v.push_back(m);
      }
      return it->second;
    };
    std::vector<std::array<std::int32_t, 3>> finer;
    for (const auto& t : f) {
      const std::int32_t a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {t[1], b, a}, {t[2], c, b}, {a, b, c}});
    }
    f = std::move(finer);
  }
  return mesh(v, f);
}

/// Returns a torus around the z axis, oriented outward.
inline TriangleMesh torus(double big, double small, int around, int across) {
  std::vector<std::array<double, 3>> v;
  std::vector<std::array<std::int32_t, 3>> f;
  const double turn = 2 * std::acos(-1.0);
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double a = turn * i / around, b = turn * j / across;
      const double r = big + small * std::cos(b);
      v.push_back({r * std::cos(a), r * std::sin(a), small * std::sin(b)});
      const auto id = [&](int p, int q) { return p % around * across + q % across; };
      f.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      f.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  return mesh(v, f);
}

inline TriangleMesh scaled(TriangleMesh m, double factor) {
  m.vertices *= factor;
  return m;
}

inline TriangleMesh moved(TriangleMesh m, const Eigen::Vector3d& by) {
  m.vertices.rowwise() += by.transpose();
  return m;
}

inline TriangleMesh flipped(TriangleMesh m) {
  m.triangles.col(1).swap(m.triangles.col(2));
  return m;
}

inline TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh m;
  m.vertices.resize(a.vertices.rows() + b.vertices.rows(), 3);
  m.vertices << a.vertices, b.vertices;
  m.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
  m.triangles << a.triangles, (b.triangles.array() + static_cast<std::int32_t>(a.vertices.rows())).matrix();
  return m;
}

inline TriangleMesh with_triangle(const TriangleMesh& m, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                  const Eigen::Vector3d& c) {
  return joined(m, mesh({{a[0], a[1], a[2]}, {b[0], b[1], b[2]}, {c[0], c[1], c[2]}}, {{0, 1, 2}}));
}

/// Uniform random numbers; one seed gives one sequence on every machine.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_()) / 4294967296.0);
  }
  int integer(int count) { return static_cast<int>(engine_() % static_cast<unsigned>(count)); }
  Eigen::Vector3d point(double half) {
    const double x = (*this)(-half, half), y = (*this)(-half, half), z = (*this)(-half, half);
    return {x, y, z};
  }

 private:
  std::mt19937 engine_;
};

}  // namespace encage::shapes

// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/handmade/solid_mesh.h"

#include "src/mesh/portable_trig.h"

#include <encage/error.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>

namespace encage::handmade {
namespace {

using Triangle = std::array<std::int32_t, 3>;
using Ring = std::vector<std::int32_t>;  // vertices of a polygon

/// Above 0 if c lies to the left of ab.
double side(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

/// Segments ab and cd have a point in common other than a common end.
bool cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c, const Eigen::Vector2d& d) {
  if (a == c || a == d || b == c || b == d) return false;
  const auto apart = [](double p, double q, double r, double s) {
    return std::max(p, q) < std::min(r, s) || std::max(r, s) < std::min(p, q);
  };
  if (apart(a.x(), b.x(), c.x(), d.x()) || apart(a.y(), b.y(), c.y(), d.y())) return false;
  return side(a, b, c) * side(a, b, d) <= 0 && side(c, d, a) * side(c, d, b) <= 0;
}

/// True if the way from corner i of a polygon to p begins inside of it.
bool begins_inside(const Loop& points, const Ring& ring, std::size_t i, const Eigen::Vector2d& p) {
  const std::size_t n = ring.size();
  const Eigen::Vector2d &before = points[ring[(i + n - 1) % n]], &at = points[ring[i]],
                        &after = points[ring[(i + 1) % n]];
  const bool left_of_first = side(before, at, p) > 0, left_of_second = side(at, after, p) > 0;
  return side(before, at, after) > 0 ? left_of_first && left_of_second : left_of_first || left_of_second;
}

/// Joins one of the holes (clockwise) to the polygon around them, by the shortest bridge that crosses nothing.
void bridge(const Loop& points, Ring& ring, std::vector<Ring>& holes) {
  double shortest = std::numeric_limits<double>::infinity();
  std::size_t hole = 0, from = 0, to = 0;
  for (std::size_t h = 0; h < holes.size(); ++h) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      for (std::size_t j = 0; j < holes[h].size(); ++j) {
        const Eigen::Vector2d &a = points[ring[i]], &b = points[holes[h][j]];
        const double length = (a - b).norm();
        if (length >= shortest || !begins_inside(points, ring, i, b)) continue;
        const auto blocks = [&](const Ring& other) {
          for (std::size_t k = 0; k < other.size(); ++k) {
            if (cross(a, b, points[other[k]], points[other[(k + 1) % other.size()]])) return true;
          }
          return false;
        };
        if (blocks(ring) || std::any_of(holes.begin(), holes.end(), blocks)) continue;
        shortest = length;
        hole = h;
        from = i;
        to = j;
      }
    }
  }
  if (shortest == std::numeric_limits<double>::infinity()) throw Error("a hand-made shape has a hole outside of it");
  Ring joined(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(from) + 1);
  for (std::size_t k = 0; k <= holes[hole].size(); ++k) joined.push_back(holes[hole][(to + k) % holes[hole].size()]);
  joined.insert(joined.end(), ring.begin() + static_cast<std::ptrdiff_t>(from), ring.end());
  ring = std::move(joined);
  holes.erase(holes.begin() + static_cast<std::ptrdiff_t>(hole));
}

/// Twice the area of a triangle that counts as none.
constexpr double thinnest = 1e-9;

bool is_ear(const Loop& points, const Ring& ring, std::size_t i) {
  const std::size_t n = ring.size();
  const Eigen::Vector2d &a = points[ring[(i + n - 1) % n]], &b = points[ring[i]], &c = points[ring[(i + 1) % n]];
  if (!(side(a, b, c) > thinnest)) return false;
  return std::none_of(ring.begin(), ring.end(), [&](std::int32_t v) {
    const Eigen::Vector2d& p = points[v];
    if (p == a || p == b || p == c) return false;
    return side(a, b, p) > -thinnest && side(b, c, p) > -thinnest && side(c, a, p) > -thinnest;
  });
}

/// Triangles of a polygon with holes, by cutting off the ear with the shortest diagonal.
std::vector<Triangle> fill(const Loop& points, Ring ring, std::vector<Ring> holes) {
  while (!holes.empty()) bridge(points, ring, holes);
  std::vector<Triangle> triangles;
  while (ring.size() > 2) {
    const std::size_t n = ring.size();
    double shortest = std::numeric_limits<double>::infinity();
    std::size_t ear = n;
    for (std::size_t i = 0; i < n; ++i) {
      const double length = (points[ring[(i + n - 1) % n]] - points[ring[(i + 1) % n]]).norm();
      if (length >= shortest || !is_ear(points, ring, i)) continue;
      shortest = length;
      ear = i;
    }
    if (ear == n) throw Error("a polygon of the hand-made shapes is not simple");
    triangles.push_back({ring[(ear + n - 1) % n], ring[ear], ring[(ear + 1) % n]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  return triangles;
}

TriangleMesh to_mesh(const std::vector<Eigen::Vector3d>& vertices, const std::vector<Triangle>& triangles) {
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v) mesh.vertices.row(static_cast<Eigen::Index>(v)) = vertices[v];
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) mesh.triangles(static_cast<Eigen::Index>(t), k) = triangles[t][k];
  }
  return mesh;
}

/// Faces of a plate, put together.
class Plate {
 public:
  Plate(double low, double high) : low_(low), high_(high) {}

  TriangleMesh build(const Loop& outline, const std::vector<Recess>& recesses) {
    const Ring upper = add(outline, high_), lower = add(outline, low_);
    wall(lower, upper);
    std::vector<Ring> upper_holes, lower_holes;
    for (const Recess& recess : recesses) {
      const Ring rim = add(recess.outline, high_), floor = add(recess.outline, recess.height);
      wall(rim, floor);
      upper_holes.emplace_back(rim.rbegin(), rim.rend());
      if (recess.height == low_) {
        lower_holes.emplace_back(floor.rbegin(), floor.rend());
      } else {
        face(floor, {}, true);
      }
    }
    face(upper, upper_holes, true);
    face(lower, lower_holes, false);
    return to_mesh(vertices_, triangles_);
  }

 private:
  Ring add(const Loop& loop, double height) {
    Ring ring;
    for (const Eigen::Vector2d& p : loop) {
      ring.push_back(static_cast<std::int32_t>(vertices_.size()));
      points_.push_back(p);
      vertices_.emplace_back(p.x(), p.y(), height);
    }
    return ring;
  }

  void wall(const Ring& a, const Ring& b) {
    for (std::size_t i = 0; i < a.size(); ++i) {
      const std::size_t j = (i + 1) % a.size();
      triangles_.push_back({a[i], a[j], b[j]});
      triangles_.push_back({a[i], b[j], b[i]});
    }
  }

  void face(const Ring& ring, const std::vector<Ring>& holes, bool up) {
    for (Triangle t : fill(points_, ring, holes)) {
      if (!up) std::swap(t[1], t[2]);
      triangles_.push_back(t);
    }
  }

  double low_, high_;
  Loop points_;
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<Triangle> triangles_;
};

}  // namespace

TriangleMesh plate(const Loop& outline, double low, double high, const std::vector<Recess>& recesses) {
  return Plate(low, high).build(outline, recesses);
}

Loop rectangle(double x0, double y0, double x1, double y1) { return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}; }

Loop regular(int corners, double radius, const Eigen::Vector2d& centre, double turn) {
  Loop loop;
  for (int i = 0; i < corners; ++i) {
    const SinCos direction = sincos_turns(turn + static_cast<double>(i) / corners);
    loop.emplace_back(centre + radius * Eigen::Vector2d(direction.cos, direction.sin));
  }
  return loop;
}

TriangleMesh box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  return plate(rectangle(low.x(), low.y(), high.x(), high.y()), low.z(), high.z());
}

TriangleMesh refined(TriangleMesh mesh, double length) {
  for (;;) {
    std::vector<Eigen::Vector3d> vertices;
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) vertices.emplace_back(mesh.vertices.row(v));
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
    const auto middle = [&](std::int32_t a, std::int32_t b) -> std::int32_t {
      if ((vertices[a] - vertices[b]).norm() <= length) return -1;
      const auto [it, added] = middles.try_emplace(std::minmax(a, b), static_cast<std::int32_t>(vertices.size()));
      if (added) vertices.emplace_back((vertices[a] + vertices[b]) / 2);
      return it->second;
    };
    std::vector<Triangle> triangles;
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
      Triangle c{mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)};
      Triangle m{middle(c[0], c[1]), middle(c[1], c[2]), middle(c[2], c[0])};
      const auto count = std::count_if(m.begin(), m.end(), [](std::int32_t v) { return v >= 0; });
      if (count == 0) {
        triangles.push_back(c);
      } else if (count == 3) {
        triangles.insert(triangles.end(), {{c[0], m[0], m[2]}, {c[1], m[1], m[0]}, {c[2], m[2], m[1]}, m});
      } else {
        // Turned so that the first edge is split and, of two, the last is not.
        while (m[0] < 0 || (count == 2 && m[2] >= 0)) {
          std::rotate(c.begin(), c.begin() + 1, c.end());
          std::rotate(m.begin(), m.begin() + 1, m.end());
        }
        if (count == 1) {
          triangles.insert(triangles.end(), {{c[0], m[0], c[2]}, {m[0], c[1], c[2]}});
        } else {
          triangles.insert(triangles.end(), {{m[0], c[1], m[1]}, {c[0], m[0], m[1]}, {c[0], m[1], c[2]}});
        }
      }
    }
    mesh = to_mesh(vertices, triangles);
    if (middles.empty()) return mesh;
  }
}

TriangleMesh together(const std::vector<TriangleMesh>& meshes) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Triangle> triangles;
  for (const TriangleMesh& mesh : meshes) {
    const auto first = static_cast<std::int32_t>(vertices.size());
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) vertices.emplace_back(mesh.vertices.row(v));
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
      triangles.push_back({first + mesh.triangles(t, 0), first + mesh.triangles(t, 1), first + mesh.triangles(t, 2)});
    }
  }
  return to_mesh(vertices, triangles);
}

}  // namespace encage::handmade

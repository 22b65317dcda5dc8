// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/decimate/planar_faces.h"

#include "cagegen/sanitize/edge_table.h"
#include "cagegen/sanitize/weld.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

namespace encage::makers {

namespace {

using io::head;
using io::Side;
using io::tail;
using io::triangle_of;
using Point = Eigen::Vector3d;

constexpr std::int64_t most_triangles = 200'000;
constexpr double least_cosine = 0.999;  // between the normals of a face's triangles

using Kernel2 = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangulation = CGAL::Constrained_Delaunay_triangulation_2<
    Kernel2,
    CGAL::Triangulation_data_structure_2<CGAL::Triangulation_vertex_base_with_info_2<std::int32_t, Kernel2>,
                                         CGAL::Constrained_triangulation_face_base_2<Kernel2>>,
    CGAL::No_constraint_intersection_tag>;

class Merger {
 public:
  Merger(const TriangleMesh& mesh, double tolerance)
      : mesh_(mesh),
        tolerance_(tolerance),
        twin_(io::twins(io::EdgeTable(mesh.triangles, mesh.vertices.rows()), mesh.triangles.rows())) {}

  std::optional<TriangleMesh> run(std::int64_t most) {
    find_faces();
    keep_corners();
    // Euler's formula, but for the genus, which only adds.
    if (2 * std::count(kept_.begin(), kept_.end(), true) - 4 > most) return std::nullopt;
    std::vector<std::vector<Side>> borders(normals_.size());
    for (Side s = 0; s < static_cast<Side>(twin_.size()); ++s) {
      if (is_border(s)) borders[face_[triangle_of(s)]].push_back(s);
    }
    for (std::size_t f = 0; f < borders.size(); ++f) {
      if (!triangulate(borders[f], normals_[f])) return std::nullopt;
    }
    TriangleMesh result;
    result.vertices = mesh_.vertices;
    result.triangles.resize(static_cast<std::int64_t>(triangles_.size()), 3);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      result.triangles.row(static_cast<std::int64_t>(t)) << triangles_[t][0], triangles_[t][1], triangles_[t][2];
    }
    io::drop_unused_vertices(result);
    if (!io::is_closed_manifold(result.triangles, result.vertices.rows())) return std::nullopt;
    return result;
  }

 private:
  bool is_border(Side s) const { return face_[triangle_of(s)] != face_[triangle_of(twin_[s])]; }

  /// Grows faces from the largest triangles, which know their planes best.
  void find_faces() {
    const auto count = static_cast<std::size_t>(mesh_.triangles.rows());
    std::vector<Point> normals(count);
    std::vector<bool> thin(count);  // the normal means nothing: such a triangle is part of any face it lies in
    std::vector<std::pair<double, std::size_t>> order(count);
    for (std::size_t t = 0; t < count; ++t) {
      const auto row = static_cast<std::int64_t>(t);
      const Point a = mesh_.corner(row, 0);
      const Point b = mesh_.corner(row, 1), c = mesh_.corner(row, 2);
      normals[t] = (b - a).cross(c - a);
      const double twice_area = normals[t].norm();
      order[t] = {-twice_area, t};
      thin[t] = twice_area <= tolerance_ * std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
      if (!thin[t]) normals[t] /= twice_area;
    }
    std::sort(order.begin(), order.end());
    face_.assign(count, -1);
    for (const auto& [negative_area, first] : order) {
      if (face_[first] >= 0) continue;
      const auto face = static_cast<std::int32_t>(normals_.size());
      const Point& normal = normals_.emplace_back(normals[first]);
      const Point origin = mesh_.corner(static_cast<std::int64_t>(first), 0);
      const auto fits = [&](std::int32_t t) {
        if (face_[t] >= 0 || (!thin[t] && normals[t].dot(normal) < least_cosine)) return false;
        for (int k = 0; k < 3; ++k) {
          if (std::abs(normal.dot(mesh_.corner(t, k) - origin)) > tolerance_) return false;
        }
        return true;
      };
      std::vector<std::int32_t> members = {static_cast<std::int32_t>(first)};
      face_[first] = face;
      for (std::size_t i = 0; i < members.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
          const std::int32_t other = triangle_of(twin_[3 * members[i] + k]);
          if (!fits(other)) continue;
          face_[other] = face;
          members.push_back(other);
        }
      }
    }
  }

  /// The next side along the border of the same face, around the head of `s`.
  Side next_on_border(Side s) const {
    Side next = s % 3 == 2 ? s - 2 : s + 1;
    while (!is_border(next)) {
      next = twin_[next];
      next = next % 3 == 2 ? next - 2 : next + 1;
    }
    return next;
  }

  /// A vertex stays where three faces meet, where a face touches itself, and where the edge between two faces bends.
  void keep_corners() {
    std::vector<int> borders(static_cast<std::size_t>(mesh_.vertices.rows()), 0);
    for (Side s = 0; s < static_cast<Side>(twin_.size()); ++s) {
      if (is_border(s)) ++borders[tail(mesh_.triangles, s)];
    }
    kept_.assign(borders.size(), false);
    for (std::size_t v = 0; v < borders.size(); ++v) kept_[v] = borders[v] > 2;
    std::vector<bool> seen(twin_.size());
    // Chains between kept vertices first, then closed curves without one.
    for (const bool closed : {false, true}) {
      for (Side s = 0; s < static_cast<Side>(twin_.size()); ++s) {
        if (seen[s] || !is_border(s) || (!closed && !kept_[tail(mesh_.triangles, s)])) continue;
        std::vector<std::int32_t> chain = {tail(mesh_.triangles, s)};
        for (Side at = s;; at = next_on_border(at)) {
          seen[at] = seen[twin_[at]] = true;
          chain.push_back(head(mesh_.triangles, at));
          if (kept_[chain.back()] || chain.back() == chain.front()) break;
        }
        if (chain.front() == chain.back()) {
          kept_[chain.front()] = true;
          const auto far = std::max_element(chain.begin(), chain.end(), [&](std::int32_t a, std::int32_t b) {
            return distance(a, chain.front()) < distance(b, chain.front());
          });
          kept_[*far] = true;
          straighten(chain.data(), &*far);
          straighten(&*far, &chain.back());
        } else {
          straighten(chain.data(), &chain.back());
        }
      }
    }
  }

  double distance(std::int32_t a, std::int32_t b) const { return (mesh_.vertex(a) - mesh_.vertex(b)).norm(); }

  /// Keeps what lies off the lines between the vertices kept, of a chain whose ends are (Douglas and Peucker 1973).
  void straighten(const std::int32_t* begin, const std::int32_t* end) {
    std::vector<std::pair<const std::int32_t*, const std::int32_t*>> open = {{begin, end}};
    while (!open.empty()) {
      const auto [first, last] = open.back();
      open.pop_back();
      const std::int32_t* const farthest = farthest_off(first, last);
      if (farthest == nullptr) continue;
      kept_[*farthest] = true;
      open.push_back({first, farthest});
      open.push_back({farthest, last});
    }
  }

  /// The vertex between two others that is farthest off their line; null if none is off by more than the tolerance.
  const std::int32_t* farthest_off(const std::int32_t* first, const std::int32_t* last) const {
    const Point start = mesh_.vertex(*first), along = mesh_.vertex(*last) - start;
    const double length = along.squaredNorm();
    const std::int32_t* farthest = nullptr;
    double most = tolerance_;
    for (const std::int32_t* v = first + 1; v < last; ++v) {
      const Point to = mesh_.vertex(*v) - start;
      const double at = length > 0 ? std::clamp(to.dot(along) / length, 0.0, 1.0) : 0;
      const double off = (to - at * along).norm();
      if (off > most) {
        most = off;
        farthest = v;
      }
    }
    return farthest;
  }

  /// One face between its border's kept vertices. False if they do not bound one.
  bool triangulate(const std::vector<Side>& border, const Point& normal) {
    std::vector<std::array<std::int32_t, 2>> edges;
    for (const Side s : border) {
      if (!kept_[tail(mesh_.triangles, s)]) continue;
      Side last = s;
      while (!kept_[head(mesh_.triangles, last)]) last = next_on_border(last);
      edges.push_back({tail(mesh_.triangles, s), head(mesh_.triangles, last)});
    }
    if (edges.size() < 3) return false;
    if (edges.size() == 3) {
      if (edges[0][1] != edges[1][0]) std::swap(edges[1], edges[2]);
      triangles_.push_back({edges[0][0], edges[1][0], edges[2][0]});
      return true;
    }
    const Point u = normal.unitOrthogonal(), w = normal.cross(u);
    Triangulation triangulation;
    for (const auto& [from, to] : edges) {
      const auto corner = [&](std::int32_t v) {
        const Point p = mesh_.vertex(v);
        const auto handle = triangulation.insert(Kernel2::Point_2(p.dot(u), p.dot(w)));
        handle->info() = v;
        return handle;
      };
      const auto a = corner(from), b = corner(to);
      if (a == b) return false;
      try {
        triangulation.insert_constraint(a, b);
      } catch (const Triangulation::Intersection_of_constraints_exception&) {
        return false;
      }
    }
    return add_inside(triangulation);
  }

  /// Adds the triangles that an odd number of edges of the border separates from the outside.
  bool add_inside(const Triangulation& triangulation) {
    if (triangulation.dimension() < 2) return false;
    std::unordered_map<Triangulation::Face_handle, bool, CGAL::Handle_hash_function> inside;
    std::vector<Triangulation::Face_handle> reached = {triangulation.infinite_face()};
    inside[reached.front()] = false;
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const auto next = reached[i]->neighbor(k);
        if (!inside.try_emplace(next, inside[reached[i]] != reached[i]->is_constrained(k)).second) continue;
        reached.push_back(next);
        if (!inside[next]) continue;
        if (triangulation.is_infinite(next)) return false;
        triangles_.push_back({next->vertex(0)->info(), next->vertex(1)->info(), next->vertex(2)->info()});
      }
    }
    return true;
  }

  const TriangleMesh& mesh_;
  double tolerance_;
  std::vector<Side> twin_;
  std::vector<std::int32_t> face_;  ///< of each triangle
  std::vector<Point> normals_;      ///< of each face
  std::vector<bool> kept_;          ///< of each vertex
  std::vector<std::array<std::int32_t, 3>> triangles_;
};

}  // namespace

std::optional<TriangleMesh> merge_planar_faces(const TriangleMesh& mesh, double tolerance, std::int64_t most) {
  if (mesh.triangles.rows() > most_triangles) return std::nullopt;
  std::optional<TriangleMesh> merged = Merger(mesh, tolerance).run(most);
  if (merged && merged->triangles.rows() > most) return std::nullopt;
  return merged;
}

}  // namespace encage::makers

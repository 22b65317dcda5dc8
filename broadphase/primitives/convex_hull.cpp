// SPDX-License-Identifier: Apache-2.0
#include "broadphase/primitives/convex_hull.h"

#include "src/limits.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <utility>

namespace encage {
namespace {

using Index = std::int32_t;
using Points = std::vector<Eigen::Vector3d>;

/// Quickhull (Barber et al. 1996): it adds the point farthest above some face, and puts faces from the point to the rim
/// in place of all faces that see it.
class Quickhull {
 public:
  Quickhull(const Points& points, const std::array<Index, 4>& corners) : points_(points), next_(points.size(), -1) {
    begin(corners);
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      // Adding a point removes the face, or removes the point from its list.
      while (faces_[f].alive && !faces_[f].above.empty()) add_farthest(static_cast<Index>(f));
    }
  }

  std::vector<std::array<Index, 3>> triangles() const {
    std::vector<std::array<Index, 3>> all;
    for (const Face& face : faces_) {
      if (face.alive) all.push_back(face.corners);
    }
    return all;
  }

 private:
  struct Face {
    std::array<Index, 3> corners;
    std::array<Index, 3> across = {-1, -1, -1};  // the face beyond the edge (k, k + 1)
    std::vector<Index> above;                    // each point that some faces see is in the list of one
    bool alive = true, seen = false;
  };
  struct RimEdge {
    Index from, to, beyond;
  };

  /// Six volumes of the tetrahedron of the face and the point, less its rounding: > 0 only if the point is above.
  double height(const Face& face, Index point) const {
    const Eigen::Vector3d &a = points_[face.corners[0]], u = points_[face.corners[1]] - a,
                          v = points_[face.corners[2]] - a, w = points_[point] - a;
    return u.cross(v).dot(w) - 16 * eps * u.norm() * v.norm() * w.norm();
  }

  void begin(std::array<Index, 4> corners) {
    const Eigen::Vector3d& a = points_[corners[0]];
    if ((points_[corners[1]] - a).cross(points_[corners[2]] - a).dot(points_[corners[3]] - a) > 0) {
      std::swap(corners[0], corners[1]);
    }
    const auto [p, q, r, s] = corners;
    faces_.resize(4);
    faces_[0] = {{p, q, r}, {1, 2, 3}, {}};
    faces_[1] = {{q, p, s}, {0, 3, 2}, {}};
    faces_[2] = {{r, q, s}, {0, 1, 3}, {}};
    faces_[3] = {{p, r, s}, {0, 2, 1}, {}};
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto point = static_cast<Index>(i);
      if (std::find(corners.begin(), corners.end(), point) == corners.end()) assign(point, 0);
    }
  }

  /// Puts a point into the list of the first face from `first` on that it is above.
  void assign(Index point, std::size_t first) {
    for (std::size_t f = first; f < faces_.size(); ++f) {
      if (!faces_[f].alive || !(height(faces_[f], point) > 0)) continue;
      faces_[f].above.push_back(point);
      return;
    }
  }

  void add_farthest(Index at) {
    std::vector<Index>& list = faces_[at].above;
    const auto farthest = std::max_element(
        list.begin(), list.end(), [&](Index x, Index y) { return height(faces_[at], x) < height(faces_[at], y); });
    const Index point = *farthest;
    list.erase(farthest);

    std::vector<Index> seen = {at};
    std::vector<RimEdge> rim;
    faces_[at].seen = true;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const Face& face = faces_[seen[i]];
      for (std::size_t k = 0; k < 3; ++k) {
        Face& other = faces_[face.across[k]];
        if (other.seen) continue;
        if (height(other, point) > 0) {
          other.seen = true;
          seen.push_back(face.across[k]);
        } else {
          rim.push_back({face.corners[k], face.corners[(k + 1) % 3], face.across[k]});
        }
      }
    }
    const bool whole = sort_rim(rim);
    for (const Index f : seen) faces_[f].seen = false;
    if (!whole) return;  // rounding made the rim no circle: the point is left out
    replace(seen, rim, point);
  }

  /// Orders the edges along the rim. Returns false if they do not form one circle.
  bool sort_rim(std::vector<RimEdge>& rim) {
    bool simple = true;
    for (std::size_t i = 0; i < rim.size(); ++i) {
      simple = simple && next_[rim[i].from] < 0;
      next_[rim[i].from] = static_cast<Index>(i);
    }
    std::vector<RimEdge> sorted = {rim.front()};
    while (simple && sorted.size() <= rim.size()) {
      const Index next = next_[sorted.back().to];
      if (next < 0) break;
      if (next == 0) break;
      sorted.push_back(rim[next]);
    }
    simple = simple && sorted.size() == rim.size() && sorted.back().to == sorted.front().from;
    for (const RimEdge& edge : rim) next_[edge.from] = -1;
    rim = std::move(sorted);
    return simple;
  }

  void replace(const std::vector<Index>& seen, const std::vector<RimEdge>& rim, Index point) {
    const auto first = static_cast<Index>(faces_.size()), count = static_cast<Index>(rim.size());
    for (Index i = 0; i < count; ++i) {
      const auto& [from, to, beyond] = rim[i];
      faces_.push_back({{from, to, point}, {beyond, first + (i + 1) % count, first + (i + count - 1) % count}, {}});
      Face& other = faces_[beyond];
      for (std::size_t k = 0; k < 3; ++k) {
        if (other.corners[k] == to && other.corners[(k + 1) % 3] == from) other.across[k] = first + i;
      }
    }
    for (const Index f : seen) {
      faces_[f].alive = false;
      for (const Index left : std::exchange(faces_[f].above, {})) assign(left, static_cast<std::size_t>(first));
    }
  }

  const Points& points_;
  std::vector<Face> faces_;
  std::vector<Index> next_;  // the rim's edge from each point; -1 between uses
};

template <class Measure>
Index greatest(const Points& points, Measure&& measure) {
  Index best = 0;
  double most = -infinity;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double value = measure(points[i]);
    if (!(value > most)) continue;
    most = value;
    best = static_cast<Index>(i);
  }
  return best;
}

/// The convex polygon of points near a plane with this normal (Andrew 1979), counter-clockwise about it.
std::vector<Index> convex_polygon(const Points& points, const Eigen::Vector3d& along, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d across = normal.cross(along);
  std::vector<Eigen::Vector2d> flat;
  for (const Eigen::Vector3d& p : points) {
    flat.emplace_back(along.dot(p - points[0]), across.dot(p - points[0]));
  }
  std::vector<Index> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Index>(i);
  std::sort(order.begin(), order.end(), [&](Index i, Index j) {
    return std::tuple(flat[i].x(), flat[i].y(), i) < std::tuple(flat[j].x(), flat[j].y(), j);
  });
  const auto turns_left = [&](Index i, Index j, Index k) {
    const Eigen::Vector2d u = flat[j] - flat[i], v = flat[k] - flat[j];
    return u.x() * v.y() - u.y() * v.x() > 4 * eps * u.norm() * v.norm();
  };
  std::vector<Index> polygon;
  for (int half = 0; half < 2; ++half) {
    const std::size_t least = polygon.size() + 1;
    for (const Index i : order) {
      while (polygon.size() > least && !turns_left(polygon[polygon.size() - 2], polygon.back(), i)) polygon.pop_back();
      polygon.push_back(i);
    }
    polygon.pop_back();  // the other half begins with it
    std::reverse(order.begin(), order.end());
  }
  return polygon;
}

HullMesh mesh_of(const std::vector<std::array<Index, 3>>& triangles, std::size_t point_count, bool flat) {
  HullMesh mesh;
  mesh.flat = flat;
  std::vector<Index> vertex(point_count, -1);
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      Index& v = vertex[triangles[t][k]];
      if (v < 0) {
        v = static_cast<Index>(mesh.points.size());
        mesh.points.push_back(triangles[t][k]);
      }
      mesh.triangles(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(k)) = v;
    }
  }
  return mesh;
}

}  // namespace

HullMesh convex_hull(const std::vector<Eigen::Vector3d>& points, double flatness) {
  const Index a = greatest(points, [](const Eigen::Vector3d& p) { return -p.x(); });
  const Index first = greatest(points, [&](const Eigen::Vector3d& p) { return (p - points[a]).norm(); });
  // From there the farthest is as good as twice as far away as any two points are.
  const Index b = greatest(points, [&](const Eigen::Vector3d& p) { return (p - points[first]).norm(); });
  const Eigen::Vector3d way = points[b] - points[first];
  const double extent = way.norm(), least = flatness * extent;
  if (!(extent > 0)) return mesh_of({{first, first, first}}, points.size(), true);
  const Eigen::Vector3d along = way / extent;
  const auto beside = [&](const Eigen::Vector3d& p) { return along.cross(p - points[first]).norm(); };
  const Index c = greatest(points, beside);
  if (!(beside(points[c]) > least)) {
    const Index low = greatest(points, [&](const Eigen::Vector3d& p) { return -along.dot(p - points[first]); });
    const Index high = greatest(points, [&](const Eigen::Vector3d& p) { return along.dot(p - points[first]); });
    return mesh_of({{low, high, high}}, points.size(), true);
  }
  const Eigen::Vector3d normal = along.cross(points[c] - points[first]).normalized();
  const auto above = [&](const Eigen::Vector3d& p) { return std::abs(normal.dot(p - points[first])); };
  const Index d = greatest(points, above);
  if (above(points[d]) > least) {
    return mesh_of(Quickhull(points, {first, b, c, d}).triangles(), points.size(), false);
  }
  const std::vector<Index> polygon = convex_polygon(points, along, normal);
  std::vector<std::array<Index, 3>> fan;
  for (std::size_t i = 2; i < polygon.size(); ++i) fan.push_back({polygon[0], polygon[i - 1], polygon[i]});
  return mesh_of(fan, points.size(), true);
}

}  // namespace encage

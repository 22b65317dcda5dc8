// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/sanitize/solid_volume.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace encage::io {

namespace {

constexpr int fewest_rays = 64;        // along a side of the grid
constexpr int most_rays = 512;         // the grid is finer than the triangles, as far as that is affordable
constexpr double negligible = 1e-6;    // of the volume: roundings where surfaces touch
constexpr double offset = 0.41421356;  // of a ray in its cell: hardly any vertex or edge is hit

struct Crossing {
  std::int32_t ray;
  std::int32_t winding;  ///< +1 where the ray enters
  double at;
};

/// Parallel rays along the shortest side of the bounds.
class RayGrid {
 public:
  explicit RayGrid(const TriangleMesh& mesh) : mesh_(mesh), box_(bounds(mesh)) {
    box_.sizes().minCoeff(&axis_);
    u_ = (axis_ + 1) % 3;
    v_ = (axis_ + 2) % 3;
    const double wanted = 4 * std::sqrt(static_cast<double>(mesh.triangles.rows()));
    count_ = static_cast<int>(std::clamp(wanted, 1.0 * fewest_rays, 1.0 * most_rays));
    step_u_ = box_.sizes()[u_] / count_;
    step_v_ = box_.sizes()[v_] / count_;
  }

  double area_of_ray() const { return step_u_ * step_v_; }

  std::vector<Crossing> crossings() const {
    std::vector<Crossing> found;
    for (std::int64_t t = 0; t < mesh_.triangles.rows(); ++t) add_crossings(t, found);
    std::sort(found.begin(), found.end(),
              [](const Crossing& a, const Crossing& b) { return a.ray != b.ray ? a.ray < b.ray : a.at < b.at; });
    return found;
  }

 private:
  double u(int i) const { return box_.min()[u_] + (i + offset) * step_u_; }
  double v(int j) const { return box_.min()[v_] + (j + offset) * step_v_; }

  /// The first and the last ray between two coordinates.
  std::array<int, 2> rays_between(double low, double high, double start, double step) const {
    const double first = std::ceil((low - start) / step - offset - 1e-6);
    const double last = std::floor((high - start) / step - offset + 1e-6);
    return {static_cast<int>(std::clamp(first, 0.0, 1.0 * count_)),
            static_cast<int>(std::clamp(last, -1.0, count_ - 1.0))};
  }

  /// Twice the area of the triangle of edge pq and (u, v). Both triangles at an edge get the same number but for its
  /// sign, so that a ray never slips between them.
  double side(std::int32_t p, std::int32_t q, double u, double v) const {
    if (p > q) return -side(q, p, u, v);
    const Eigen::Vector3d a = mesh_.vertex(p), b = mesh_.vertex(q);
    return (b[u_] - a[u_]) * (v - a[v_]) - (b[v_] - a[v_]) * (u - a[u_]);
  }

  /// A ray through the edge lies on the left of the edge from its lower vertex.
  static bool is_left(std::int32_t p, std::int32_t q, double side) { return side > 0 || (side == 0 && p < q); }

  void add_crossings(std::int64_t t, std::vector<Crossing>& found) const {
    const std::array<std::int32_t, 3> c = {mesh_.triangles(t, 0), mesh_.triangles(t, 1), mesh_.triangles(t, 2)};
    const std::array<Eigen::Vector3d, 3> p = {mesh_.vertex(c[0]), mesh_.vertex(c[1]), mesh_.vertex(c[2])};
    const auto [u_low, u_high] = std::minmax({p[0][u_], p[1][u_], p[2][u_]});
    const auto [v_low, v_high] = std::minmax({p[0][v_], p[1][v_], p[2][v_]});
    const auto [i_first, i_last] = rays_between(u_low, u_high, box_.min()[u_], step_u_);
    const auto [j_first, j_last] = rays_between(v_low, v_high, box_.min()[v_], step_v_);
    for (int i = i_first; i <= i_last; ++i) {
      for (int j = j_first; j <= j_last; ++j) {
        std::array<double, 3> weight;
        int left = 0;
        for (int k = 0; k < 3; ++k) {
          const std::int32_t from = c[(k + 1) % 3], to = c[(k + 2) % 3];
          weight[k] = side(from, to, u(i), v(j));
          left += is_left(from, to, weight[k]);
        }
        const double sum = weight[0] + weight[1] + weight[2];
        if (left % 3 != 0 || sum == 0) continue;
        const double at = (weight[0] * p[0][axis_] + weight[1] * p[1][axis_] + weight[2] * p[2][axis_]) / sum;
        // Counterclockwise as seen from the far end: the ray leaves.
        found.push_back({i * count_ + j, left == 3 ? -1 : 1, at});
      }
    }
  }

  const TriangleMesh& mesh_;
  Eigen::AlignedBox3d box_;
  int axis_ = 0, u_ = 1, v_ = 2;
  int count_ = fewest_rays;
  double step_u_ = 0, step_v_ = 0;
};

}  // namespace

double solid_volume(const TriangleMesh& mesh) {
  const double volume = signed_volume(mesh);
  const RayGrid grid(mesh);
  const std::vector<Crossing> crossings = grid.crossings();
  double counted = 0;  // too often, along all rays
  int winding = 0;
  for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
    winding = i > 0 && crossings[i].ray != crossings[i - 1].ray ? crossings[i].winding : winding + crossings[i].winding;
    if (winding == 0 || winding == 1 || crossings[i + 1].ray != crossings[i].ray) continue;
    counted += (winding - 1) * (crossings[i + 1].at - crossings[i].at);
  }
  const double surplus = counted * grid.area_of_ray();
  const bool overlaps = std::abs(surplus) > negligible * std::abs(volume) && surplus < volume;
  return overlaps ? volume - surplus : volume;
}

}  // namespace encage::io

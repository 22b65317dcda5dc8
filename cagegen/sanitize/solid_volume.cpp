// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/sanitize/solid_volume.h"

#include "cagegen/sanitize/nesting.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace encage::io {

namespace {

// Rays along a side of the grid: a coarse one tells whether anything is counted several times, a fine one how much.
constexpr int fewest_rays = 64;
constexpr int most_rays = 256;
constexpr int fewest_fine_rays = 192;
constexpr double negligible = 1e-6;    // of the volume: roundings where surfaces touch
constexpr double accuracy = 1e-3;      // of what is summed along rays
constexpr double offset = 0.41421356;  // of a ray in its cell: hardly any vertex or edge is hit

struct Crossing {
  std::int32_t ray;
  std::int32_t winding;  ///< +1 where the ray enters
  double at;
};

/// Parallel rays along the shortest side of the bounds.
class RayGrid {
 public:
  RayGrid(const TriangleMesh& mesh, int count) : mesh_(mesh), box_(bounds(mesh)), count_(count) {
    box_.sizes().minCoeff(&axis_);
    u_ = (axis_ + 1) % 3;
    v_ = (axis_ + 2) % 3;
    step_u_ = box_.sizes()[u_] / count_;
    step_v_ = box_.sizes()[v_] / count_;
  }

  double area_of_ray() const { return step_u_ * step_v_; }

  std::vector<Crossing> crossings() const {
    std::vector<Crossing> found;
    for (std::int64_t t = 0; t < mesh_.triangles.rows(); ++t) add_crossings(t, found);
    return in_order(found);
  }

 private:
  double u(int i) const { return box_.min()[u_] + (i + offset) * step_u_; }
  double v(int j) const { return box_.min()[v_] + (j + offset) * step_v_; }

  /// By ray, which is a number below count_ squared, and along each.
  std::vector<Crossing> in_order(const std::vector<Crossing>& found) const {
    std::vector<std::size_t> next(static_cast<std::size_t>(count_) * count_ + 1, 0);
    for (const Crossing& c : found) ++next[c.ray + 1];
    for (std::size_t r = 1; r < next.size(); ++r) next[r] += next[r - 1];
    std::vector<Crossing> ordered(found.size());
    for (const Crossing& c : found) ordered[next[c.ray]++] = c;
    auto first = ordered.begin();
    for (std::size_t r = 0; r + 1 < next.size(); ++r) {  // `next` is where each ray ends now
      const auto last = ordered.begin() + static_cast<std::ptrdiff_t>(next[r]);
      std::sort(first, last, [](const Crossing& a, const Crossing& b) { return a.at < b.at; });
      first = last;
    }
    return ordered;
  }

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
  int count_;
  double step_u_ = 0, step_v_ = 0;
};

/// Holds if no part intersects another or itself.
double volume_of_nest(const TriangleMesh& mesh, const std::vector<std::vector<std::int32_t>>& parts) {
  const std::vector<std::vector<std::int32_t>> around = containers(mesh, parts);
  std::vector<double> volume;
  for (const auto& part : parts) volume.push_back(part_volume(mesh, part));
  double sum = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    int outside = 0;
    for (const std::int32_t outer : around[p]) outside += volume[outer] < 0 ? -1 : 1;
    const int inside = outside + (volume[p] < 0 ? -1 : 1);
    sum += std::abs(volume[p]) * ((inside != 0) - (outside != 0));
  }
  return sum;
}

/// By how much signed_volume() exceeds the volume of the solid.
double surplus(const TriangleMesh& mesh, int rays) {
  const RayGrid grid(mesh, rays);
  const std::vector<Crossing> crossings = grid.crossings();
  double sum = 0;
  int winding = 0;
  for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
    winding += crossings[i].winding;
    if (crossings[i + 1].ray != crossings[i].ray) {
      winding = 0;
    } else if (winding != 0 && winding != 1) {
      sum += (winding - 1) * (crossings[i + 1].at - crossings[i].at);
    }
  }
  return sum * grid.area_of_ray();
}

}  // namespace

double solid_volume(const TriangleMesh& mesh, const std::vector<std::vector<std::int32_t>>& parts) {
  const double volume = signed_volume(mesh);
  const double wanted = 4 * std::sqrt(static_cast<double>(mesh.triangles.rows()));
  const int rays = static_cast<int>(std::clamp(wanted, 1.0 * fewest_rays, 1.0 * most_rays));
  if (std::abs(surplus(mesh, rays)) <= negligible * volume) return volume;
  const double summed = volume - surplus(mesh, std::max(2 * rays, fewest_fine_rays));
  if (summed <= 0) return volume;
  const double nested = volume_of_nest(mesh, parts);
  return std::abs(nested - summed) <= accuracy * summed ? nested : summed;
}

}  // namespace encage::io

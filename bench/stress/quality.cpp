// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/stress/quality.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

namespace encage::stress {

namespace {

constexpr double degrees = 180 / std::numbers::pi;
constexpr double sharpest = 20;

double angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return degrees * std::atan2(a.cross(b).norm(), a.dot(b));
}

double smallest_angle(const TriangleMesh& mesh, std::int64_t t) {
  double least = 180;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d at = mesh.corner(t, k);
    least = std::min(least, angle(mesh.corner(t, (k + 1) % 3) - at, mesh.corner(t, (k + 2) % 3) - at));
  }
  return least;
}

/// The angle inside the solid at the edge from corner k of t, whose other triangle has the corner `opposite`.
double interior_angle(const TriangleMesh& mesh, std::int64_t t, int k, const Eigen::Vector3d& opposite) {
  const Eigen::Vector3d from = mesh.corner(t, k), along = (mesh.corner(t, (k + 1) % 3) - from).normalized();
  const auto across = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return (p - from) - along * along.dot(p - from);
  };
  const Eigen::Vector3d a = across(mesh.corner(t, (k + 2) % 3)), b = across(opposite);
  const double between = angle(a, b);
  const Eigen::Vector3d outward = along.cross(a);
  return outward.dot(b) > 0 ? 360 - between : between;
}

}  // namespace

Quality quality(const TriangleMesh& mesh) {
  Quality result;
  std::vector<double> smallest;
  std::map<std::pair<std::int32_t, std::int32_t>, Eigen::Vector3d> opposite;  // of the half edge
  std::vector<int> valence(static_cast<std::size_t>(mesh.vertices.rows()), 0);
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    smallest.push_back(smallest_angle(mesh, t));
    for (int k = 0; k < 3; ++k) {
      ++valence[static_cast<std::size_t>(mesh.triangles(t, k))];
      opposite[{mesh.triangles(t, k), mesh.triangles(t, (k + 1) % 3)}] = mesh.corner(t, (k + 2) % 3);
    }
  }
  if (smallest.empty()) return result;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = mesh.triangles(t, k), b = mesh.triangles(t, (k + 1) % 3);
      const auto twin = opposite.find({b, a});
      if (a < b && twin != opposite.end() && interior_angle(mesh, t, k, twin->second) < sharpest) ++result.folds;
    }
  }
  std::sort(smallest.begin(), smallest.end());
  result.smallest_angle = smallest.front();
  result.low_angle = smallest[smallest.size() / 20];
  result.highest_valence = *std::max_element(valence.begin(), valence.end());
  return result;
}

}  // namespace encage::stress

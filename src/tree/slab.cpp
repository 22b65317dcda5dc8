// SPDX-License-Identifier: Apache-2.0
#include "src/tree/slab.h"

#include "src/mesh/principal_frame.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace encage {
namespace {

using Corners = std::span<const std::array<Eigen::Vector3d, 3>>;

// Exceeds the rounding of a height, which is a sum of three products below 2^23.
constexpr double rounding = 0x1p-20;

Eigen::Vector3d mean_corner(Corners triangles) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& t : triangles) sum += t[0] + t[1] + t[2];
  return sum / (3 * static_cast<double>(triangles.size()));
}

Eigen::Matrix3d covariance(Corners triangles) {
  const Eigen::Vector3d mean = mean_corner(triangles);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& t : triangles) {
    for (const Eigen::Vector3d& corner : t) {
      const Eigen::Vector3d d = corner - mean;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j <= i; ++j) sum(i, j) += d[i] * d[j];
      }
    }
  }
  return sum;
}

Eigen::Vector3d area_vector(Corners triangles) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& t : triangles) sum += (t[1] - t[0]).cross(t[2] - t[0]);
  return sum;
}

std::array<std::int8_t, 3> rounded(const Eigen::Vector3d& direction) {
  const double norm = direction.norm();
  std::array<std::int8_t, 3> normal = {};
  if (!(norm > 0) || !std::isfinite(norm)) return normal;
  for (int axis = 0; axis < 3; ++axis) {
    normal[axis] = static_cast<std::int8_t>(std::floor(MeshNode::normal_size * direction[axis] / norm + 0.5));
  }
  return normal;
}

}  // namespace

SlabFitter::SlabFitter(const TriangleMesh& mesh, const TreeGrid& grid, std::span<const std::int32_t> order) {
  corners_.resize(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d x = mesh.corner(order[i], k);
      for (int axis = 0; axis < 3; ++axis) corners_[i][k][axis] = grid.coordinate(axis, x[axis]);
    }
  }
}

Slab SlabFitter::fit(std::int32_t begin, std::int32_t end) const {
  const Corners triangles = Corners(corners_).subspan(begin, end - begin);
  const PrincipalFrame frame = principal_frame(covariance(triangles));
  std::array<std::array<std::int8_t, 3>, 4> normals;
  for (int k = 0; k < 3; ++k) normals[k] = rounded(frame.axes.col(k));
  normals[3] = rounded(area_vector(triangles));

  std::array<double, 4> low, high;
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  for (const auto& t : triangles) {
    for (const Eigen::Vector3d& corner : t) {
      for (std::size_t k = 0; k < normals.size(); ++k) {
        const double height = Slab::height(normals[k], corner);
        low[k] = std::min(low[k], height);
        high[k] = std::max(high[k], height);
      }
    }
  }
  std::size_t thinnest = 0;
  double thickness = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < normals.size(); ++k) {
    const double squared = Slab::height(normals[k], {1.0 * normals[k][0], 1.0 * normals[k][1], 1.0 * normals[k][2]});
    if (squared == 0 || !(high[k] - low[k] < thickness * std::sqrt(squared))) continue;
    thinnest = k;
    thickness = (high[k] - low[k]) / std::sqrt(squared);
  }
  const auto units = [](double height) { return static_cast<std::int16_t>(height); };
  return {normals[thinnest], units(std::floor(low[thinnest] / MeshNode::slab_unit - rounding)),
          units(std::ceil(high[thinnest] / MeshNode::slab_unit + rounding))};
}

}  // namespace encage

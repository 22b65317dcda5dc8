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

void SlabBounds::add_normal(const Eigen::Vector3d& direction) { add_normal(rounded(direction)); }

void SlabBounds::add_box(const Eigen::Vector3d& lower, const Eigen::Vector3d& upper) {
  for (std::size_t k = 0; k < count_; ++k) {
    double low = 0, high = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double along = direction_[k][static_cast<std::size_t>(axis)];
      low += along * (along < 0 ? upper : lower)[axis];
      high += along * (along < 0 ? lower : upper)[axis];
    }
    low_[k] = std::min(low_[k], low);
    high_[k] = std::max(high_[k], high);
  }
}

Slab SlabBounds::thinnest() const {
  std::size_t thinnest = 0;
  double thickness = infinity;
  for (std::size_t k = 0; k < count_; ++k) {
    const auto& n = direction_[k];
    const double squared = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    if (squared == 0 || !(high_[k] - low_[k] < thickness * std::sqrt(squared))) continue;
    thinnest = k;
    thickness = (high_[k] - low_[k]) / std::sqrt(squared);
  }
  const auto units = [](double height) { return static_cast<std::int16_t>(height); };
  return {normals_[thinnest], units(std::floor(low_[thinnest] / MeshNode::slab_unit - rounding)),
          units(std::ceil(high_[thinnest] / MeshNode::slab_unit + rounding))};
}

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
  SlabBounds bounds;
  for (int k = 0; k < 3; ++k) bounds.add_normal(Eigen::Vector3d(frame.axes.col(k)));
  bounds.add_normal(area_vector(triangles));
  const Eigen::Vector3d* const first = triangles.front().data();
  bounds.add(3 * (end - begin), [&](std::int32_t i) -> const Eigen::Vector3d& { return first[i]; });
  return bounds.thinnest();
}

}  // namespace encage

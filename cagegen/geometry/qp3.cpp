// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/geometry/qp3.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <limits>

namespace encage::makers {

namespace {

constexpr int max_constraints = 96;
constexpr double relative_tolerance = 1e-10;  // of unit-length quantities in whitened space
constexpr double parallel_sine = 1e-9;        // sine below which two normals count as parallel

/// Closest point to `target` on the line point + t direction within the half-spaces.
std::optional<Eigen::Vector3d> nearest_on_line(const Eigen::Vector3d& target, const Eigen::Vector3d& point,
                                               const Eigen::Vector3d& direction,
                                               std::span<const LinearConstraint> constraints, double tolerance) {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  for (const LinearConstraint& c : constraints) {
    const double slope = c.normal.dot(direction);
    const double gap = c.offset - c.normal.dot(point);
    if (std::abs(slope) < parallel_sine) {
      if (gap > tolerance) return std::nullopt;
    } else if (slope > 0) {
      low = std::max(low, gap / slope);
    } else {
      high = std::min(high, gap / slope);
    }
  }
  if (low > high + tolerance) return std::nullopt;
  const double t = std::min(std::max(direction.dot(target - point), low), std::max(low, high));
  return point + t * direction;
}

std::optional<Eigen::Vector3d> nearest_on_plane(const Eigen::Vector3d& target, const LinearConstraint& plane,
                                                std::span<const LinearConstraint> constraints, double tolerance) {
  const Eigen::Vector3d foot = target + (plane.offset - plane.normal.dot(target)) * plane.normal;
  Eigen::Vector3d best = foot;
  for (std::size_t j = 0; j < constraints.size(); ++j) {
    const LinearConstraint& c = constraints[j];
    const double gap = c.offset - c.normal.dot(best);
    if (gap <= tolerance) continue;
    Eigen::Vector3d direction = plane.normal.cross(c.normal);
    const double sine = direction.norm();
    if (sine < parallel_sine) return std::nullopt;
    direction /= sine;
    // In-plane step from the foot to the line where both are tight.
    const Eigen::Vector3d across = direction.cross(plane.normal);
    const double slope = c.normal.dot(across);
    const Eigen::Vector3d point = foot + (c.offset - c.normal.dot(foot)) / slope * across;
    const auto next = nearest_on_line(target, point, direction, constraints.first(j), tolerance);
    if (!next) return std::nullopt;
    best = *next;
  }
  return best;
}

}  // namespace

std::optional<Eigen::Vector3d> solve_qp(const Eigen::Matrix3d& a, const Eigen::Vector3d& b,
                                        std::span<const LinearConstraint> constraints) {
  // With A = LL', y = L'p turns the problem into a projection of L^-1 b.
  const Eigen::LLT<Eigen::Matrix3d> factor(a);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const Eigen::Vector3d target = factor.matrixL().solve(b);
  std::array<LinearConstraint, max_constraints> whitened;
  std::size_t count = 0;
  double scale = target.norm();
  for (const LinearConstraint& c : constraints) {
    if (count == whitened.size()) break;  // those left out are tested by the caller like all others
    Eigen::Vector3d normal = factor.matrixL().solve(c.normal);
    const double length = normal.norm();
    if (!(length > 0)) continue;
    whitened[count++] = {normal / length, c.offset / length};
    scale = std::max(scale, std::abs(c.offset / length));
  }
  const double tolerance = relative_tolerance * scale;
  const std::span<const LinearConstraint> all(whitened.data(), count);
  Eigen::Vector3d best = target;
  for (std::size_t i = 0; i < count; ++i) {
    if (all[i].offset - all[i].normal.dot(best) <= tolerance) continue;
    const auto next = nearest_on_plane(target, all[i], all.first(i), tolerance);
    if (!next) return std::nullopt;
    best = *next;
  }
  return factor.matrixU().solve(best);
}

}  // namespace encage::makers

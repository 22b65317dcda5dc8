// SPDX-License-Identifier: Apache-2.0
#include "broadphase/separation/plane_check.h"

#include "src/limits.h"
#include "src/tree/visit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

/// True if n . x > limit, as computed, for some vertex x.
bool exceeds(const Surface& surface, const Vector& n, double limit) noexcept {
  return !visit_nodes(surface.tree, [&](const MeshNode& node, auto&& descend) {
    std::array<double, MeshNode::width> upper{};
    for (int k = 0; k < 3; ++k) {
      for (int lane = 0; lane < MeshNode::width; ++lane) {
        upper[lane] += n[k] * (n[k] > 0 ? surface.tree.upper(node, k, lane) : surface.tree.lower(node, k, lane));
      }
    }
    for (int lane = 0; lane < MeshNode::width && node.count(lane) != MeshNode::unused; ++lane) {
      if (upper[lane] <= limit) continue;
      if (node.count(lane) == MeshNode::inner) {
        descend(node.child(lane));
        continue;
      }
      for (std::int32_t i = node.child(lane); i < node.child(lane) + node.count(lane); ++i) {
        for (const std::int32_t v : surface.tree.leaves[i].vertices) {
          if (!(n.dot(surface.vertex(v)) <= limit)) return false;
        }
      }
    }
    return true;
  });
}

}  // namespace

PlaneCheck::PlaneCheck(const SimpleShape& shape, const Surface& surface, const Motion& motion, const HalfSpace& plane,
                       double margin, double arc) noexcept
    : surface_(surface, motion.scale), arc_(arc) {
  double size = std::abs(plane.offset) + surface_.radius() + motion.scale * shape.frame.origin.norm();
  for (std::size_t end = 0; end < 2; ++end) {
    const Eigen::Isometry3d& pose = end == 0 ? motion.start : motion.end;
    normal_[end] = pose.linear().transpose() * plane.normal;
    height_[end] = plane.normal.dot(pose * (motion.scale * shape.frame.origin)) - plane.offset;
    size += pose.translation().norm();
  }
  const bool unit = std::abs(plane.normal.norm() - 1) <= rigid_tolerance && std::isfinite(plane.offset) &&
                    margin >= 0 && arc >= 0 && std::isfinite(arc);
  // Heights are off by less than 32 units of roundoff of the sizes; the normal's length scales them by 1 +- 1e-9.
  clearance_ = unit ? (margin + shape.error_in_world(motion.scale)) * (1 + 4e-9) + 32 * eps * size
                    : std::numeric_limits<double>::infinity();
}

bool PlaneCheck::beyond_throughout() const noexcept {
  for (std::size_t end = 0; end < 2; ++end) {
    const double depth = height_[end] - (clearance_ + arc_);
    // The ball around the local origin decides most cases.
    if (depth > surface_.radius() * (1 + 2e-9)) continue;
    if (exceeds(*surface_, -normal_[end], depth / surface_.scale())) return false;
  }
  return true;
}

void PlaneCheck::visit_near(void (*visit)(void* context, std::int32_t vertex), void* context) const {
  const auto lowest = [&](const MeshNode& node, int lane, std::size_t end) {
    double sum = height_[end];
    for (int k = 0; k < 3; ++k) {
      const double n = surface_.scale() * normal_[end][k];
      sum += std::min(n * static_cast<double>(surface_->tree.lower(node, k, lane)),
                      n * static_cast<double>(surface_->tree.upper(node, k, lane)));
    }
    return sum;
  };
  // The reach is doubled, because the bounds of boxes carry as much rounding as the heights of vertices.
  const double reach = 2 * clearance_ + arc_;
  visit_nodes(surface_->tree, [&](const MeshNode& node, auto&& descend) {
    for (int lane = MeshNode::width - 1; lane >= 0; --lane) {
      if (node.count(lane) == MeshNode::unused) continue;
      if (lowest(node, lane, 0) > reach && lowest(node, lane, 1) > reach) continue;
      if (node.count(lane) == MeshNode::inner) {
        descend(node.child(lane));
        continue;
      }
      for (std::int32_t i = node.child(lane); i < node.child(lane) + node.count(lane); ++i) {
        for (const std::int32_t v : surface_->tree.leaves[i].vertices) visit(context, v);
      }
    }
    return true;
  });
}

double PlaneCheck::first_time(std::int32_t vertex) const {
  const Vector x = surface_.vertex(vertex);
  // The height above the clearance is a + b t + c t^2 with the bulge of the arc, which is convex. The result is the
  // first time at which it is 0.
  const double a = height_[0] + normal_[0].dot(x) - clearance_;
  const double end = height_[1] + normal_[1].dot(x) - clearance_;
  if (!(a > 0)) return 0;
  const double c = 4 * arc_;
  const double b = end - a - c;
  if (!(b < 0)) return end > 0 ? 2 : 0;
  const double discriminant = b * b - 4 * a * c;
  // The error moves a double root by its own square root, so the time is rounded down by more than that.
  if (discriminant < -16 * eps * b * b) return 2;
  const double root = 2 * a / (-b + std::sqrt(std::max(discriminant, 0.0)));
  return root <= 1 + 1e-7 ? std::min(1.0, root * (1 - 1e-7)) : end > 0 ? 2 : 1;
}

}  // namespace encage

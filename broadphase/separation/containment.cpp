// SPDX-License-Identifier: Apache-2.0
#include "broadphase/separation/containment.h"

#include "src/limits.h"
#include "src/tree/visit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

/// False only if the ray from `p` is proven to miss the box. Each quotient has a relative error of at most 2 eps: two
/// roundings.
bool may_meet(const WindingRay& ray, const MeshTreeView& tree, const MeshNode& node, int lane, const Vector& p) {
  const std::array<double, 3> direction = {1, ray.slope1, ray.slope2};
  double enter = 0;
  double leave = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const int axis = (ray.axis + k) % 3;
    double t0 = (static_cast<double>(tree.lower(node, axis, lane)) - p[axis]) / direction[k];
    double t1 = (static_cast<double>(tree.upper(node, axis, lane)) - p[axis]) / direction[k];
    if (t0 > t1) std::swap(t0, t1);
    enter = std::max(enter, t0 - 8 * eps * std::abs(t0));
    leave = std::min(leave, t1 + 8 * eps * std::abs(t1));
  }
  return enter <= leave;
}

/// Winding number of the surface about `p`, counted along the ray.
std::optional<int> winding(const Surface& surface, const WindingRay& ray, const Vector& p) {
  int sum = 0;
  const bool decided = visit_nodes(surface.tree, [&](const MeshNode& node, auto&& descend) {
    for (int lane = 0; lane < MeshNode::width; ++lane) {
      if (node.count(lane) == MeshNode::unused || !may_meet(ray, surface.tree, node, lane, p)) continue;
      if (node.count(lane) == MeshNode::inner) {
        descend(node.child(lane));
        continue;
      }
      for (std::int32_t i = node.child(lane); i < node.child(lane) + node.count(lane); ++i) {
        const auto& v = surface.tree.leaves[i].vertices;
        const std::optional<int> sign =
            crossing(ray, {surface.vertex(v[0]), surface.vertex(v[1]), surface.vertex(v[2])}, p);
        if (!sign) return false;
        sum += *sign;
      }
    }
    return true;
  });
  return decided ? std::optional(sum) : std::nullopt;
}

}  // namespace

// After shearing the ray onto its axis, and with m the largest coordinate of a corner relative to p, the two
// coordinates are at most 1.5 m and off by 3 eps m each. Hence an edge function is off by less than 32 eps m^2, and
// their mean of depths by less than 128 eps m^3.
std::optional<int> crossing(const WindingRay& ray, const std::array<Vector, 3>& triangle, const Vector& p) noexcept {
  std::array<double, 3> x, y, z;
  double m = 0;
  for (int k = 0; k < 3; ++k) {
    const Vector d = triangle[k] - p;
    m = std::max(m, d.cwiseAbs().maxCoeff());
    x[k] = d[ray.axis];
    y[k] = d[(ray.axis + 1) % 3] - ray.slope1 * x[k];
    z[k] = d[(ray.axis + 2) % 3] - ray.slope2 * x[k];
  }
  const double edge_error = 32 * eps * m * m;
  // Products below this could have lost bits to underflow.
  if (!(edge_error * m > smallest_product)) return std::nullopt;
  std::array<double, 3> w;
  bool positive = false, negative = false, open = false;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    w[k] = y[i] * z[j] - z[i] * y[j];
    if (w[k] > edge_error) {
      positive = true;
    } else if (w[k] < -edge_error) {
      negative = true;
    } else {
      open = true;
    }
  }
  if (positive && negative) return 0;
  const double depth = (w[0] * x[0] + w[1] * x[1] + w[2] * x[2]) * (negative ? -1 : 1);
  const double depth_error = 4 * edge_error * m;
  // The ray misses a triangle entirely behind it, whatever the edge functions are.
  if (std::max({x[0], x[1], x[2]}) < 0) return 0;
  if (open) return std::nullopt;
  if (depth < -depth_error) return 0;
  if (depth > depth_error) return positive ? 1 : -1;
  return std::nullopt;
}

Side locate(const Surface& surface, const Vector& point) noexcept {
  for (int axis = 0; axis < 3; ++axis) {
    if (point[axis] < static_cast<double>(surface.lower[axis]) ||
        point[axis] > static_cast<double>(surface.upper[axis])) {
      return Side::outside;
    }
  }
  for (const WindingRay& ray : rays) {
    if (const std::optional<int> number = winding(surface, ray, point)) {
      return *number != 0 ? Side::inside : Side::outside;
    }
  }
  return Side::unknown;
}

bool all_outside(const ScaledSurface& host, const ScaledSurface& guest, const AffineMap& to_host) noexcept {
  return std::all_of(guest->parts.begin(), guest->parts.end(), [&](const MeshPart& part) {
    return locate(*host, to_host(guest.vertex(part.vertex)) / host.scale()) == Side::outside;
  });
}

bool could_hold(const SimpleShape& host, double host_scale, const std::array<AffineMap, 2>& host_maps,
                const SimpleShape& guest, double guest_scale, const std::array<AffineMap, 2>& guest_maps,
                double slack) noexcept {
  const Surface& outer = host.outer();
  const ScaledSurface inner(guest.fine, guest_scale);
  // Hosts are no primitives; of a guest that is one, the core counts, which lies outside if a point of it does.
  const double reach = slack + host.error_in_world(host_scale) + guest.core_error_in_world(guest_scale);
  const Vector centre = 0.5 * host_scale * (outer.lower.cast<double>() + outer.upper.cast<double>());
  const Vector half = 0.5 * host_scale * (outer.upper.cast<double>() - outer.lower.cast<double>());
  // Points that are beyond the box along n at both ends, in the same sense, are beyond it throughout: vertex and box
  // move linearly.
  const auto beyond = [&](const Vector& n, const Vector& x) {
    bool above = true, below = true;
    for (std::size_t end = 0; end < 2; ++end) {
      const Vector u = host_maps[end].linear.transpose() * n;
      const double offset = n.dot(guest_maps[end](x) - host_maps[end](centre));
      const double required = u.cwiseAbs().dot(half) + reach;
      above = above && offset > required;
      below = below && -offset > required;
    }
    return above || below;
  };
  const auto outside = [&](std::int32_t v) {
    const Vector x = inner.vertex(v);
    for (const AffineMap& map : host_maps) {
      for (int axis = 0; axis < 3; ++axis) {
        // The length is at most 1, so a test against the full reach is safe.
        const Vector n = map.linear.col(axis) * (1 - 1e-8) / std::max(1.0, map.linear.col(axis).norm());
        if (beyond(n, x)) return true;
      }
    }
    return false;
  };
  // A connected part with a vertex outside the box is not inside the host unless it touches the host's surface.
  const bool excluded =
      !guest.fine.empty() && std::all_of(guest.fine.parts.begin(), guest.fine.parts.end(), [&](const MeshPart& part) {
        return std::any_of(part.extremes.begin(), part.extremes.end(), outside);
      });
  return !excluded;
}

}  // namespace encage

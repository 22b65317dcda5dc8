// SPDX-License-Identifier: Apache-2.0
#include "broadphase/query/half_space.h"

#include "src/limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

/// Bounds the rounding of a height over the plane, for points with norms up to `norm`.
double height_error(const HalfSpace& half_space, double norm) {
  return 16 * eps * (norm + std::abs(half_space.offset));
}

double height(const HalfSpace& half_space, const Vector& point) {
  return half_space.normal.dot(point) - half_space.offset;
}

/// A height that changes along a ray: at + t * slope, each with the bound of its rounding.
struct Height {
  double at, at_error, slope, slope_error;
};

Height height_along(const HalfSpace& half_space, const Vector& origin, const Vector& direction) {
  const Vector products = half_space.normal.cwiseProduct(direction);
  Height h{height(half_space, origin), height_error(half_space, origin.norm()), products.sum(),
           8 * eps * products.cwiseAbs().sum()};
  // Products may underflow, unless a factor is 0.
  for (int k = 0; k < 3; ++k) {
    if (half_space.normal[k] != 0 && direction[k] != 0) h.slope_error += 1e-300;
  }
  return h;
}

/// The parameter, between low and high, where the height is 0 or may first be; no value if it is nowhere.
std::optional<double> zero_between(const Height& h, double low, double high) {
  if (std::abs(h.slope) > 2 * h.slope_error) {
    const double zero = std::clamp(-h.at / h.slope, -1e300, 1e300);
    const double error =
        (h.at_error + h.slope_error * std::abs(zero)) / (std::abs(h.slope) - h.slope_error) + 4 * eps * std::abs(zero);
    if (zero + error < low || zero - error > high) return std::nullopt;
    return std::max(low, std::min(zero, high));
  }
  const double above = std::abs(h.at) - h.at_error;
  if (above <= 0) return low;
  // Both factors are 0, or the plane is this far at least.
  if (h.slope_error == 0) return std::nullopt;
  const double far = above / (std::abs(h.slope) + h.slope_error);
  const bool certain = std::abs(h.slope) > h.slope_error, rises = (h.at > 0) == (h.slope > 0);
  if (low <= -far && (rises || !certain)) return low;
  if (high >= far && (!rises || !certain)) return std::max(low, far);
  return std::nullopt;
}

}  // namespace

std::optional<RayHit> plane_hit(const HalfSpace& half_space, const Ray& ray, const RayOptions& options) noexcept {
  const double size = ray.direction.cwiseAbs().maxCoeff();
  const Height h = height_along(half_space, ray.origin, ray.direction / size);
  if (options.back_faces == BackFaces::ignore && h.slope > h.slope_error) return std::nullopt;
  const std::optional<double> parameter = zero_between(h, ray.t_min * size, ray.t_max * size);
  if (!parameter) return std::nullopt;
  constexpr double most = std::numeric_limits<double>::max();
  RayHit hit;
  hit.t = std::clamp(std::clamp(*parameter / size, ray.t_min, ray.t_max), -most, most);
  hit.normal = half_space.normal.normalized();
  hit.back_face = h.slope > 0;
  return hit;
}

PointSide plane_side(const HalfSpace& half_space, const Vector& point) noexcept {
  const double h = height(half_space, point), error = height_error(half_space, point.norm());
  return h > error ? PointSide::outside : h < -error ? PointSide::inside : PointSide::unknown;
}

ClosestPoint closest_on_plane(const HalfSpace& half_space, const Vector& point, double limit) noexcept {
  const double length = half_space.normal.norm(), h = height(half_space, point) / length;
  const double error = height_error(half_space, point.norm());
  ClosestPoint result;
  result.lower = std::max(0.0, std::min(std::abs(h), limit) - error);
  if (!(std::abs(h) < limit)) return result;
  result.upper = std::abs(h) + error;
  result.point = point - h / length * half_space.normal;
  return result;
}

bool reaches_plane(const HalfSpace& half_space, std::span<const Vector> hull, double radius) noexcept {
  double least = infinity, norm = radius;
  for (const Vector& p : hull) {
    least = std::min(least, height(half_space, p));
    norm = std::max(norm, p.norm() + radius);
  }
  return !(least - radius * half_space.normal.norm() > height_error(half_space, norm));
}

bool half_spaces_meet(const HalfSpace& a, const HalfSpace& b) noexcept {
  return !(a.normal == -b.normal && a.offset < -b.offset);
}

}  // namespace encage

// SPDX-License-Identifier: Apache-2.0
#include "broadphase/query/rounded.h"

#include "broadphase/separation/containment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace encage {
namespace {

Eigen::Vector3d core_corner(const Surface& core, std::int32_t triangle, int k) {
  const auto& t = core.mesh.triangles[static_cast<std::size_t>(triangle)];
  return core.vertex(static_cast<std::int32_t>(t[static_cast<std::size_t>(k)]));
}

/// An outward direction of the core at a point of it, in the local frame: where the point asked for is too near for a
/// direction of its own.
Eigen::Vector3d outward_at(const Surface& core, const SurfacePoint& at) {
  const Eigen::Vector3d a = core_corner(core, at.triangle, 0), b = core_corner(core, at.triangle, 1),
                        c = core_corner(core, at.triangle, 2);
  Eigen::Vector3d normal = unit_normal({a, b, c});
  if (!normal.isZero(0)) return normal;
  const Eigen::Vector3d way = a == b ? Eigen::Vector3d(c - a) : Eigen::Vector3d(b - a);
  return way.isZero(0) ? Eigen::Vector3d::UnitX() : Eigen::Vector3d(way.stableNormalized().unitOrthogonal());
}

/// Barycentric coordinates of a point on a feature of a triangle.
std::array<double, 3> weights_of(const Surface& core, const SurfacePoint& at) {
  std::array<double, 3> weight = {0, 0, 0};
  const auto corner = static_cast<std::size_t>(at.corner), next = (corner + 1) % 3;
  const auto position = [&](std::size_t k) { return core_corner(core, at.triangle, static_cast<int>(k)); };
  switch (at.kind) {
    case SurfacePoint::Kind::vertex: weight[corner] = 1; return weight;
    case SurfacePoint::Kind::edge: {
      const Eigen::Vector3d along = position(next) - position(corner);
      const double squared = along.squaredNorm();
      weight[next] = squared > 0 ? std::clamp(along.dot(at.point - position(corner)) / squared, 0.0, 1.0) : 0;
      weight[corner] = 1 - weight[next];
      return weight;
    }
    case SurfacePoint::Kind::face: break;
  }
  const Eigen::Vector3d normal = (position(1) - position(0)).cross(position(2) - position(0));
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d u = position((k + 1) % 3) - at.point, v = position((k + 2) % 3) - at.point;
    weight[k] = std::max(0.0, normal.dot(u.cross(v)));
    sum += weight[k];
  }
  if (!(sum > 0)) return {1, 0, 0};
  for (double& w : weight) w /= sum;
  return weight;
}

/// A ray in the local frame, beginning near the core's middle. A point of it is origin + p * direction.
class RoundedRay {
 public:
  RoundedRay(const PosedPart& part, const Ray& ray) : part_(part), core_(part.shape().fine), ray_(ray) {
    size_ = ray.direction.cwiseAbs().maxCoeff();
    const Eigen::Vector3d direction = ray.direction / size_;  // between 1 and 2 long
    const SimpleShape& shape = part.shape();
    const double radius = shape.convex_radius;
    const double world_radius = part.scale() * (core_.radius + radius);
    slack_ = part.farthest_local(part.rounding(ray.origin.norm() + world_radius)) + shape.fine_error +
             2 * (part.farthest_local(part.scale()) - 1) * radius;
    // Coordinates are small beside a point of the ray that is near the body.
    const Eigen::Vector3d middle = part.world(0.5 * (core_.lower.cast<double>() + core_.upper.cast<double>()));
    shift_ = direction.dot(ray.origin - middle) / direction.squaredNorm();
    origin_ = part.local(ray.origin - shift_ * direction);
    direction_ = part.local_direction(direction);
    const double reach = 2 * (1 + 1e-8) * (part.scale() * (core_.radius + radius + slack_));
    low_ = std::max(ray.t_min * size_ + shift_, -reach);
    high_ = std::min(ray.t_max * size_ + shift_, reach);
  }

  RoundedHits cast(bool back) {
    RoundedHits result;
    if (!(low_ <= high_)) return result;
    const End first = enter(low_, high_, 1);
    if (first.kind == End::Kind::missed) return result;
    if (first.kind == End::Kind::tired) {
      result.unknown = true;
      result.from = t(first.p);
      return result;
    }
    if (first.kind == End::Kind::touched) result.hits[static_cast<std::size_t>(result.count++)] = hit(first, false);
    if (!back) return result;
    // The body is convex: it is left where the same ray enters it from the other end.
    const End last = enter(high_, low_, -1);
    if (last.kind == End::Kind::tired || (last.kind == End::Kind::missed && result.count == 0)) {
      result.unknown = true;
      result.from = result.count > 0 ? result.hits[0].t : t(low_);
      result.count = 0;
      return result;
    }
    if (last.kind != End::Kind::touched || (result.count > 0 && !(last.p > first.p))) return result;
    result.hits[static_cast<std::size_t>(result.count++)] = hit(last, true);
    return result;
  }

 private:
  struct End {
    enum class Kind : std::uint8_t {
      missed,   // proven
      inside,   // the ray begins inside
      touched,  // within rounding of the surface at p
      tired,
    } kind;
    double p = 0;
    SurfacePoint nearest{};
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  };

  double t(double p) const {
    constexpr double most = std::numeric_limits<double>::max();
    return std::clamp(std::clamp((p - shift_) / size_, ray_.t_min, ray_.t_max), -most, most);
  }

  /// Follows the ray from p to the other end of its range. The core's extent along any direction bounds the body by a
  /// half-space, before which the ray is outside. The direction to the nearest point makes this Newton's method for the
  /// distance, which is convex along the ray.
  End enter(double p, double end, int sense) const {
    const double radius = part_.shape().convex_radius;
    for (int step = 0; step < 128; ++step) {
      const Eigen::Vector3d x = origin_ + p * direction_;
      SurfacePoint nearest;
      if (!nearest_point(core_, x, infinity, nearest)) return {End::Kind::tired, p};
      const Eigen::Vector3d away = x - nearest.point;
      const double distance = away.norm();
      if (step == 0) {
        const bool held = !flat_core(part_.shape()) && locate(core_, x) == Side::inside;
        if (held || distance < radius - slack_) return {End::Kind::inside, p, nearest};
      }
      if (!(distance > slack_)) return {End::Kind::touched, p, nearest, outward_at(core_, nearest)};
      const Eigen::Vector3d normal = away / distance;
      if (distance - radius <= slack_) return {End::Kind::touched, p, nearest, normal};
      const double height = normal.dot(x) - (extent(normal) + (radius + slack_) * (1 + 8 * eps));
      if (!(height > slack_)) return {End::Kind::touched, p, nearest, normal};
      const double speed = -sense * normal.dot(direction_);
      if (!(speed > 0)) return {End::Kind::missed, p};
      const double next = p + sense * (height / speed) * (1 - 8 * eps);
      if (sense * (next - end) > 0) return {End::Kind::missed, p};
      p = next;
    }
    return {End::Kind::tired, p};
  }

  double extent(const Eigen::Vector3d& normal) const {
    double most = -infinity;
    for (std::size_t v = 0; v < core_.mesh.vertices.size(); ++v) {
      most = std::max(most, normal.dot(core_.vertex(static_cast<std::int32_t>(v))));
    }
    return most;
  }

  RayHit hit(const End& end, bool back) const {
    RayHit hit;
    hit.t = t(end.p);
    hit.triangle = end.nearest.triangle + part_.first_triangle();
    hit.barycentric = weights_of(core_, end.nearest);
    hit.normal = part_.world_normal(end.normal).normalized();
    hit.back_face = back;
    return hit;
  }

  const PosedPart& part_;
  const Surface& core_;
  const Ray& ray_;
  double size_ = 0;                     // parameters per t
  double shift_ = 0;                    // parameter of the ray's origin
  Eigen::Vector3d origin_, direction_;  // local frame
  double slack_ = 0;                    // local units: what body and ray may be off
  double low_ = 0, high_ = 0;
};

}  // namespace

RoundedPoint nearest_on_rounded(const PosedPart& part, const Eigen::Vector3d& point) noexcept {
  const SimpleShape& shape = part.shape();
  const Surface& core = shape.fine;
  const double scale = part.scale(), radius = scale * shape.convex_radius;
  const Eigen::Vector3d p = part.local(point);
  const double rounding = part.rounding(point.norm() + radius), slack = rounding + shape.core_error_in_world(scale);
  RoundedPoint result;
  if (!nearest_point(core, p, infinity, result.core)) {
    result.lower = -infinity;
    result.upper = infinity;
    result.point = point;
    return result;
  }
  const Eigen::Vector3d on_core = part.world(result.core.point);
  const double distance = (point - on_core).norm();
  const double most = distance * (1 + 4 * eps) + slack;
  const double least = std::max(0.0, part.shortest(result.core.lower) - slack);
  const Side side = flat_core(shape) ? Side::outside : least > 0 ? locate(core, p) : Side::unknown;
  result.lower = (side == Side::outside ? least : -most) - (1 + 1e-8) * radius;
  result.upper = (side == Side::inside ? -least : most) - shape.least_radius(scale);
  // Towards a point beside the core, or from one within it. Next to the core that direction is rounding.
  const Eigen::Vector3d away = (side == Side::inside ? -1 : 1) * (point - on_core);
  Eigen::Vector3d normal = away / distance;
  if (!(side != Side::unknown && distance > 1e4 * rounding)) {
    normal = part.world_normal(outward_at(core, result.core)).normalized();
    if (flat_core(shape) && normal.dot(away) < 0) normal = -normal;
  }
  result.point = on_core + radius * normal;
  return result;
}

RoundedHits cast_at_rounded(const PosedPart& part, const Ray& ray, bool back) noexcept {
  return RoundedRay(part, ray).cast(back);
}

}  // namespace encage

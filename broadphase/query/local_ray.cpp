// SPDX-License-Identifier: Apache-2.0
#include "broadphase/query/local_ray.h"

#include "broadphase/contact/nearest_point.h"
#include "broadphase/distance/triangle_distance.h"
#include "src/limits.h"

#include <algorithm>
#include <cmath>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

/// Weights of the corners at the triangle's point nearest to `p`.
std::array<double, 3> weights_at(const TriangleD& t, const Vector& p) {
  const SurfacePoint nearest = nearest_in_triangle(p, t);
  std::array<double, 3> weights = {0, 0, 0};
  if (nearest.kind != SurfacePoint::Kind::face) {
    const int from = nearest.corner, to = (from + 1) % 3;
    const Vector edge = t[to] - t[from];
    const double squared = edge.squaredNorm();
    const bool at_corner = nearest.kind == SurfacePoint::Kind::vertex || !(squared > 0);
    weights[to] = at_corner ? 0 : std::clamp(edge.dot(nearest.point - t[from]) / squared, 0.0, 1.0);
    weights[from] = 1 - weights[to];
    return weights;
  }
  const Vector n = (t[1] - t[0]).cross(t[2] - t[0]);
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    weights[k] = std::max(0.0, n.dot((t[(k + 1) % 3] - nearest.point).cross(t[(k + 2) % 3] - nearest.point)));
    sum += weights[k];
  }
  for (double& weight : weights) weight /= sum;  // the triangle is not thin
  return weights;
}

/// Half the diagonal of the surface's box.
double radius_of(const Surface& surface) {
  return (1 + 8 * eps) * 0.5 * (surface.upper.cast<double>() - surface.lower.cast<double>()).norm();
}

/// Fills in what follows from the direction and the error.
void set_direction(LocalRay& ray, const Surface& surface, double radius, double error) {
  ray.error = error;
  int axis = 0;
  const double largest = ray.direction.cwiseAbs().maxCoeff(&axis);
  ray.axes = {axis, (axis + 1) % 3, (axis + 2) % 3};
  for (std::size_t k = 0; k < 2; ++k) ray.shear[k] = ray.direction[ray.axes[k + 1]] / ray.direction[axis];
  ray.per_axis = 1 / ray.direction[axis];
  ray.along = static_cast<double>(surface.tree.grid.step) / 32 + 8 * error;
  ray.certain = ray.along / largest;
  ray.length = (2 * radius + 4 * error) / ray.direction.norm();
}

}  // namespace

std::optional<LocalRay> local_ray(const PosedPart& part, const Surface& surface, const Ray& ray,
                                  const RayOptions& options) noexcept {
  LocalRay local;
  local.size = ray.direction.cwiseAbs().maxCoeff();
  local.direction = part.local_direction(ray.direction / local.size);
  const Vector middle = 0.5 * (surface.lower.cast<double>() + surface.upper.cast<double>());
  const double radius = radius_of(surface);
  const Vector from_middle = part.local(ray.origin) - middle;
  local.shift = -from_middle.dot(local.direction) / local.direction.squaredNorm();
  const Vector nearest = from_middle + local.shift * local.direction;
  const double moved = part.rounding(ray.origin.norm()) / part.scale();
  if (nearest.norm() > radius + 2 * moved) return std::nullopt;
  local.origin = middle + nearest;
  local.t_min = ray.t_min;
  local.t_max = ray.t_max;
  local.low = ray.t_min * local.size - local.shift;
  local.high = ray.t_max * local.size - local.shift;
  set_direction(local, surface, radius, 2 * moved + 32 * eps * radius);
  local.ignore_back_faces = options.back_faces == BackFaces::ignore;
  return local;
}

LocalRay local_ray(const Surface& surface, const WindingRay& ray, const Vector& point) noexcept {
  LocalRay local;
  local.origin = point;
  local.direction[ray.axis] = 1;
  local.direction[(ray.axis + 1) % 3] = ray.slope1;
  local.direction[(ray.axis + 2) % 3] = ray.slope2;
  local.low = local.t_min = local.shift = 0;
  local.high = local.t_max = infinity;
  local.size = 1;
  set_direction(local, surface, radius_of(surface), 32 * eps * radius_of(surface));
  local.ignore_back_faces = false;
  return local;
}

// With m the largest coordinate of a corner relative to the ray's origin, y and z are off by 3 eps m, which
// LocalRay::error holds besides the error of the ray: in all `error`. With M the largest of all y and z, a weight is
// off by 4 error M + 2 error^2 and by 3 roundings of M^2, M being at most 2 m.
SeenTriangle::SeenTriangle(const LocalRay& ray, const TriangleD& corners) {
  double most = 0;
  for (int k = 0; k < 3; ++k) {
    const Vector d = corners[k] - ray.origin;
    x[k] = d[ray.axes[0]];
    y[k] = d[ray.axes[1]] - ray.shear[0] * x[k];
    z[k] = d[ray.axes[2]] - ray.shear[1] * x[k];
    most = std::max({most, std::abs(y[k]), std::abs(z[k])});
  }
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    weight[k] = y[i] * z[j] - z[i] * y[j];
  }
  determinant = weight[0] + weight[1] + weight[2];
  tolerance = 6 * ray.error * (most + ray.error);
  extent = std::max({x[0], x[1], x[2]}) - std::min({x[0], x[1], x[2]});
}

std::optional<double> look_closely(const LocalRay& ray, const TriangleD& corners) noexcept {
  const SeenTriangle seen(ray, corners);
  if (ray.ignore_back_faces && seen.determinant * ray.per_axis > 3 * seen.tolerance * std::abs(ray.per_axis)) {
    return std::nullopt;
  }
  const double low = std::max(ray.low, -ray.length), high = std::min(ray.high, ray.length);
  if (!(low <= high)) return std::nullopt;
  // Relative to the ray's origin, where the ray and the triangle are near each other.
  const TriangleD triangle = {corners[0] - ray.origin, corners[1] - ray.origin, corners[2] - ray.origin};
  const Vector from = low * ray.direction, to = high * ray.direction;
  const TriangleDistance nearest = triangle_distance(triangle, {from, to, to}, ray.error);
  if (nearest.lower > 0) return std::nullopt;
  if (seen.steep(ray)) return std::clamp(seen.parameter(ray), low, high);
  // The first place near an edge, or the start of the range.
  const double squared = ray.direction.squaredNorm();
  double first = ray.direction.dot(nearest.point_b) / squared;
  for (int k = 0; k < 3; ++k) {
    const Vector& a = triangle[k];
    const Vector edge = triangle[(k + 1) % 3] - a;
    const auto consider = [&](const Vector& p) {
      const double at = std::clamp(ray.direction.dot(p) / squared, low, high);
      if (at < first && (at * ray.direction - p).norm() <= 2 * ray.error) first = at;
    };
    consider(a);
    // The line and the edge are nearest where the edge, seen across the ray, is nearest to 0.
    const Vector across = edge - ray.direction.dot(edge) / squared * ray.direction;
    const double length = across.squaredNorm();
    if (length > 0) consider(a + std::clamp(-across.dot(a) / length, 0.0, 1.0) * edge);
  }
  if (low < first && triangle_distance(triangle, {from, from, from}, ray.error).upper <= 3 * ray.error) first = low;
  return first;
}

RayHit describe_hit(const PosedPart& part, const LocalRay& ray, const TriangleD& corners, double parameter) noexcept {
  RayHit hit;
  hit.t = ray.t(parameter);
  const SeenTriangle seen(ray, corners);
  bool weighed = seen.steep(ray);
  if (weighed) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      hit.barycentric[k] = std::max(0.0, std::copysign(1.0, seen.determinant) * seen.weight[k]);
      sum += hit.barycentric[k];
    }
    weighed = sum > 0;
    for (double& weight : hit.barycentric) weight = weighed ? weight / sum : 0;
  }
  if (!weighed) {
    const Vector p = parameter * ray.direction;
    hit.barycentric = weights_at({corners[0] - ray.origin, corners[1] - ray.origin, corners[2] - ray.origin}, p);
  }
  const Vector normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  if (normal.squaredNorm() > smallest_square) hit.normal = part.world_normal(normal.normalized()).normalized();
  hit.back_face = !hit.normal.isZero(0) && seen.determinant * ray.per_axis > 0;
  return hit;
}

}  // namespace encage

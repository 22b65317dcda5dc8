// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/octopus/octopus_shape.h"

#include "src/mesh/portable_trig.h"

#include <Eigen/Geometry>

#include <array>
#include <cmath>

namespace encage::octopus {
namespace {

using Tube = ImplicitSurface::Tube;

// How one arm runs; angles in turns. It leaves the head at `heading`, first sinks, then levels off, and curls at the
// tip by `curl` in a plane that leans by `lean` from the vertical.
struct Arm {
  double heading;
  double length;
  double sink;  // pitch at the root, below the horizon
  double rise;  // pitch where the curl begins
  double curl;  // turned through from there to the tip
  double lean;
  double sway;  // turned sideways on the way out
};

// Anticlockwise from the front left; the pose is alive, hence not symmetric.
constexpr std::array<Arm, 8> arms{{
    {-0.185, 1.45, 0.130, 0.02, 0.95, 0.03, 0.020},
    {-0.065, 1.50, 0.115, 0.01, 0.60, -0.06, 0.055},
    {0.060, 1.55, 0.110, 0.03, 1.05, 0.05, -0.030},
    {0.180, 1.40, 0.120, 0.02, 0.55, -0.04, 0.045},
    {0.310, 1.45, 0.115, 0.01, 0.90, 0.06, -0.035},
    {0.435, 1.55, 0.110, 0.03, 0.65, 0.04, 0.040},
    {0.560, 1.50, 0.115, 0.02, 1.00, -0.05, -0.045},
    {0.690, 1.45, 0.135, 0.00, 0.50, 0.07, -0.030},
}};

constexpr double root_radius = 0.115, least_tip_radius = 0.014;
constexpr int arm_rods = 160;

double smooth_step(double x) {
  x = std::min(1.0, std::max(0.0, x));
  return x * x * (3 - 2 * x);
}

struct ArmPoint {
  Eigen::Vector3d position, tangent, normal;  // normal: towards the inside of the curl
  double radius;
};

std::vector<ArmPoint> trace(const Arm& arm, double tip_radius) {
  // A thicker tip needs a wider curl, or it would meet its own arm.
  const double curl = arm.curl / (1 + 15 * (tip_radius - least_tip_radius));
  const SinCos heading = sincos_turns(arm.heading);
  const Eigen::Vector3d root(0.10 * heading.cos, 0.10 * heading.sin - 0.02, -0.06);
  std::vector<ArmPoint> points;
  Eigen::Vector3d position = root;
  for (int i = 0; i <= arm_rods; ++i) {
    const double u = static_cast<double>(i) / arm_rods;
    // Levels off on the first part; the curl's curvature grows like that of a logarithmic spiral.
    const double out = smooth_step(u / 0.55);
    const double c = std::max(0.0, (u - 0.35) / 0.65);
    const double pitch = -arm.sink + (arm.sink + arm.rise) * out + curl * c * c * (0.35 + 0.65 * c);
    const SinCos p = sincos_turns(pitch);
    const SinCos h = sincos_turns(arm.heading + arm.sway * smooth_step(u / 0.8));
    const SinCos l = sincos_turns(arm.lean * smooth_step(u / 0.5));
    const Eigen::Vector3d ahead(h.cos, h.sin, 0), aside(-h.sin, h.cos, 0);
    const Eigen::Vector3d top = l.cos * Eigen::Vector3d::UnitZ() + l.sin * aside;
    ArmPoint point;
    point.position = position;
    point.tangent = p.cos * ahead + p.sin * top;
    point.normal = p.cos * top - p.sin * ahead;
    point.radius = tip_radius + (root_radius - tip_radius) * (1 - u) * (0.75 + 0.25 * (1 - u));
    points.push_back(point);
    position += arm.length / arm_rods * point.tangent;
  }
  return points;
}

Tube flesh(const std::vector<ArmPoint>& points) {
  Tube tube{{}, 0.10};
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    tube.rods.emplace_back(points[i].position, points[i + 1].position, points[i].radius, points[i + 1].radius);
  }
  return tube;
}

// Two rows along the outer side of the curl, which lies on the ground further in.
Tube suckers(const std::vector<ArmPoint>& points, double least_radius) {
  Tube tube{{}, 0.010};
  double travelled = 0, next = 0.16;
  int side = 1;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const ArmPoint& p = points[i];
    travelled += (points[i + 1].position - p.position).norm();
    const double radius = 0.27 * p.radius;
    if (travelled < next || radius < least_radius) continue;
    const Eigen::Vector3d across = side * p.tangent.cross(p.normal);
    const Eigen::Vector3d direction = (0.42 * across - p.normal).normalized();
    const Eigen::Vector3d foot = p.position + (p.radius - 0.7 * radius) * direction;
    const Eigen::Vector3d cup = p.position + (p.radius - 0.15 * radius) * direction;
    tube.rods.emplace_back(foot, cup, 0.8 * radius, radius);
    side = -side;
    next = travelled + 1.3 * radius;
  }
  return tube;
}

// A uniform cubic B-spline through space and radius.
Tube spline_tube(const std::vector<Eigen::Vector4d>& control, int rods_per_span, double blend) {
  Tube tube{{}, blend};
  std::vector<Eigen::Vector4d> points;
  for (std::size_t i = 0; i + 3 < control.size(); ++i) {
    for (int j = i == 0 ? 0 : 1; j <= rods_per_span; ++j) {
      const double t = static_cast<double>(j) / rods_per_span, s = 1 - t;
      points.push_back((s * s * s * control[i] + (3 * t * t * t - 6 * t * t + 4) * control[i + 1] +
                        (3 * s * s * s - 6 * s * s + 4) * control[i + 2] + t * t * t * control[i + 3]) /
                       6);
    }
  }
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    tube.rods.emplace_back(points[i].head<3>(), points[i + 1].head<3>(), points[i][3], points[i + 1][3]);
  }
  return tube;
}

Tube ball(const Eigen::Vector3d& centre, double radius, double blend) {
  return {{Rod(centre, centre, radius, radius)}, blend};
}

}  // namespace

ImplicitSurface octopus_shape(double detail) {
  std::vector<Tube> tubes;
  std::vector<Tube> cups;
  for (const Arm& arm : arms) {
    const std::vector<ArmPoint> points = trace(arm, std::max(least_tip_radius, 2.2 * detail));
    tubes.push_back(flesh(points));
    cups.push_back(suckers(points, std::max(0.0065, 2 * detail)));
    if (cups.back().rods.empty()) cups.pop_back();
  }
  // From between the arms through head and neck to the tip of the mantle.
  tubes.push_back(spline_tube({{0, -0.02, -0.10, 0.15},
                               {0, -0.02, -0.04, 0.17},
                               {0, -0.03, 0.08, 0.20},
                               {0, -0.02, 0.19, 0.20},
                               {0, 0.03, 0.31, 0.22},
                               {0, 0.12, 0.45, 0.32},
                               {0, 0.23, 0.58, 0.37},
                               {0, 0.36, 0.70, 0.31},
                               {0, 0.47, 0.79, 0.21},
                               {0, 0.54, 0.84, 0.14}},
                              24, 0.10));
  for (const double side : {-1.0, 1.0}) {
    tubes.push_back(ball({side * 0.165, -0.125, 0.185}, 0.085, 0.06));  // the bulge around the eye
    tubes.push_back(ball({side * 0.200, -0.165, 0.205}, 0.055, 0.012));
  }
  for (Tube& tube : cups) tubes.push_back(std::move(tube));
  return ImplicitSurface(std::move(tubes));
}

}  // namespace encage::octopus

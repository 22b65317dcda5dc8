// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a rigid-body engine brings along: bodies with poses in float, and a sequential-impulse solver.

#include <Eigen/Geometry>

#include <algorithm>
#include <utility>

using Eigen::Isometry3f;
using Vector = Eigen::Vector3d;
using Matrix = Eigen::Matrix3d;
constexpr double dt = 1.0 / 120, friction = 0.5;

struct Body {
  Isometry3f pose;
  Vector velocity = Vector::Zero(), spin = Vector::Zero(), centre = Vector::Zero();
  double inverse_mass = 0;
  Matrix inverse_inertia = Matrix::Zero();

  Vector velocity_at(const Vector& p) const { return velocity + spin.cross(p - centre); }
  void push(const Vector& p, const Vector& j) {
    velocity += inverse_mass * j, spin += inverse_inertia * (p - centre).cross(j);
  }
  double yielding(const Vector& p, const Vector& n) const {
    return inverse_mass + n.dot((inverse_inertia * (p - centre).cross(n)).cross(p - centre));
  }
  Isometry3f moved() const {
    const Eigen::AngleAxisd turn(dt * spin.norm(), spin.stableNormalized());
    const Eigen::Isometry3d step(Eigen::Translation3d(centre + dt * velocity) * turn * Eigen::Translation3d(-centre));
    return (step * pose.cast<double>()).cast<float>();
  }
};

struct Point {
  Body *a, *b;
  Vector at, normal;
  double separation, pushed = 0;

  void solve() {
    const Vector v = a->velocity_at(at) - b->velocity_at(at);
    const double wanted = separation > 0 ? -separation / dt : std::min(-0.1 * separation / dt, 1.0);
    const double sum = pushed + (wanted - normal.dot(v)) / (a->yielding(at, normal) + b->yielding(at, normal));
    const double before = std::exchange(pushed, std::max(0.0, sum));
    push((pushed - before) * normal);
    const Vector slip = v - normal.dot(v) * normal, way = slip.stableNormalized();
    push(-std::min(friction * pushed, slip.norm() / (a->yielding(at, way) + b->yielding(at, way))) * way);
  }
  void push(const Vector& impulse) { a->push(at, impulse), b->push(at, -impulse); }
};

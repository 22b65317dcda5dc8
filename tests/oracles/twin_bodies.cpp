// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/twin_bodies.h"

#include <array>

namespace encage::test {

using Vector = Eigen::Vector3d;

namespace {

void add_kinds(const Sample& sample, double unit, std::vector<Body>& all) {
  all.emplace_back(sample);
  all.emplace_back(without_cages(sample));
  all.emplace_back(without_fine(sample));
  all.emplace_back(scaled(sample, -3));
  Sample moved = sample;
  moved.hierarchy.origin = Vector(10'000, -2'500.25, 0.375) * unit;
  all.emplace_back(moved);
  // One scale is a power of two, where lattices still meet exactly; the others round.
  constexpr std::array scales = {0.3712, 2.0, 1 / 3.0, 37.3, 1e-3};
  all.emplace_back(sample, scales[all.size() % scales.size()], all.size() % 4 == 1);
}

using MakeSamples = std::vector<Sample>(double jitter);

std::vector<Body> all_kinds(const std::vector<MakeSamples*>& makers, int exponent) {
  std::vector<Body> all;
  for (const double jitter : {0.0, 1e-4}) {
    for (MakeSamples* make : makers) {
      for (const Sample& sample : make(jitter)) add_kinds(scaled(sample, exponent), std::ldexp(1.0, exponent), all);
    }
  }
  return all;
}

}  // namespace

std::vector<Body> twin_bodies(int exponent) { return all_kinds({sample_shapes, flat_shapes, thin_shapes}, exponent); }

std::vector<Body> large_twin_bodies(int exponent) {
  return all_kinds({large_sample_shapes, large_flat_shapes}, exponent);
}

Vector TwinRandom::point(double half) {
  const double x = uniform(-half, half), y = uniform(-half, half), z = uniform(-half, half);
  return {x, y, z};
}

Vector TwinRandom::direction() {
  Vector d;
  do {
    d = point(1);
  } while (d.norm() > 1 || d.norm() < 0.1);
  return d.normalized();
}

Eigen::Isometry3d TwinRandom::pose() {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(uniform(0, 3.14), direction()).toRotationMatrix();
  const double reach = below(16) == 0 ? 1e6 : std::array{1.0, 10.0, 10'000.0}[below(3)];
  pose.translation() = point(reach);
  if (below(8) == 0) pose.linear() *= 1 + uniform(-2.5e-10, 2.5e-10);
  return pose;
}

Vector TwinRandom::surface_point(const Body& body) {
  const TriangleMesh& mesh = body.sample.source;
  const auto t = static_cast<std::int64_t>(below(static_cast<unsigned>(mesh.triangles.rows())));
  double u = uniform(0, 1), v = uniform(0, 1);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return body.scale * (body.origin() + (1 - u - v) * mesh.corner(t, 0) + u * mesh.corner(t, 1) + v * mesh.corner(t, 2));
}

Vector TwinRandom::meeting_place(const Body& a, const Eigen::Isometry3d& pose_a, const Body& b,
                                 const Eigen::Isometry3d& pose_b) {
  if (below(2) == 0) return a.centre(pose_a) + direction() * uniform(0, 0.15) * (a.diagonal() + b.diagonal());
  return pose_a * surface_point(a) - pose_b.linear() * (surface_point(b) - b.scale * b.origin());
}

Eigen::Matrix3d TwinRandom::quarter_turns() {
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d z = (Eigen::Matrix3d() << 0, -1, 0, 1, 0, 0, 0, 0, 1).finished();
  const Eigen::Matrix3d x = (Eigen::Matrix3d() << 1, 0, 0, 0, 0, -1, 0, 1, 0).finished();
  for (unsigned i = below(4); i > 0; --i) r = r * z;
  for (unsigned i = below(4); i > 0; --i) r = r * x;
  return r;
}

Vector TwinRandom::lattice_point() {
  Vector cell;
  for (int k = 0; k < 3; ++k) cell[k] = 0.125 * std::floor(uniform(-20, 20));
  return cell;
}

}  // namespace encage::test

// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/broadphase/twin_bodies.h"

#include <gtest/gtest.h>

#include <array>

namespace encage::test {

using Vector = Eigen::Vector3d;

namespace {

void add_kinds(const Sample& sample, std::vector<Body>& all) {
  all.emplace_back(sample);
  all.emplace_back(without_cages(sample));
  all.emplace_back(without_fine(sample));
  all.emplace_back(scaled(sample, -3));
  Sample moved = sample;
  moved.hierarchy.origin = Vector(10'000, -2'500.25, 0.375);
  all.emplace_back(moved);
}

using MakeSamples = std::vector<Sample>(double jitter);

std::vector<Body> all_kinds(MakeSamples* make_shapes, MakeSamples* make_sheets) {
  std::vector<Body> all;
  for (const double jitter : {0.0, 1e-4}) {
    for (const Sample& sample : make_shapes(jitter)) add_kinds(sample, all);
    for (const Sample& sample : make_sheets(jitter)) add_kinds(sample, all);
  }
  return all;
}

}  // namespace

std::vector<Body> twin_bodies() { return all_kinds(sample_shapes, flat_shapes); }

std::vector<Body> large_twin_bodies() { return all_kinds(large_sample_shapes, large_flat_shapes); }

void TwinFigures::record() const {
  testing::Test::RecordProperty("rejected", rejected);
  testing::Test::RecordProperty("asked", asked);
  testing::Test::RecordProperty("contacts", contacts);
  testing::Test::RecordProperty("far", far);
  testing::Test::RecordProperty("far_kept", far_kept);
}

Vector TwinRandom::direction() {
  Vector d;
  do {
    d = Vector(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
  } while (d.norm() > 1 || d.norm() < 0.1);
  return d.normalized();
}

Eigen::Isometry3d TwinRandom::pose() {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(uniform(0, 3.14), direction()).toRotationMatrix();
  const double reach = std::array{1.0, 10.0, 10'000.0}[below(3)];
  pose.translation() = Vector(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)) * reach;
  if (below(8) == 0) pose.linear() *= 1 + uniform(-2.5e-10, 2.5e-10);
  return pose;
}

Vector TwinRandom::surface_point(const Body& body) {
  const TriangleMesh& mesh = body.sample.source;
  const auto t = static_cast<std::int64_t>(below(static_cast<unsigned>(mesh.triangles.rows())));
  double u = uniform(0, 1), v = uniform(0, 1);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return body.origin() + (1 - u - v) * mesh.corner(t, 0) + u * mesh.corner(t, 1) + v * mesh.corner(t, 2);
}

Vector TwinRandom::meeting_place(const Body& a, const Eigen::Isometry3d& pose_a, const Body& b,
                                 const Eigen::Isometry3d& pose_b) {
  if (below(2) == 0) return a.centre(pose_a) + direction() * uniform(0, 0.15) * (a.diagonal() + b.diagonal());
  return pose_a * surface_point(a) - pose_b.linear() * (surface_point(b) - b.origin());
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

// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/broadphase/twin_bodies.h"

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

}  // namespace

std::vector<Body> twin_bodies() {
  std::vector<Body> all;
  for (const double jitter : {0.0, 1e-4}) {
    for (const Sample& sample : sample_shapes(jitter)) add_kinds(sample, all);
  }
  return all;
}

std::vector<Body> large_twin_bodies() {
  std::vector<Body> all;
  for (const double jitter : {0.0, 1e-4}) {
    for (const Sample& sample : large_sample_shapes(jitter)) add_kinds(sample, all);
  }
  return all;
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

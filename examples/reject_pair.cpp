// SPDX-License-Identifier: Apache-2.0
// Asks whether two copies of a baked model, DISTANCE apart along x, are proven separated.
#include <encage/encage.h>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) try {
  if (argc != 3) return std::fprintf(stderr, "usage: reject_pair MODEL.glb DISTANCE\n"), 2;
  const encage::ShapePtr shape = encage::make_shape(encage::read_asset(argv[1]));
  Eigen::Isometry3d aside = Eigen::Isometry3d::Identity();
  aside.translation().x() = std::atof(argv[2]);
  const auto verdict = encage::separated(*shape, encage::Motion::resting(Eigen::Isometry3d::Identity()), *shape,
                                         encage::Motion::resting(aside));
  std::puts(verdict.separated ? "separated" : "maybe touching");
} catch (const encage::Error& error) {
  return std::fprintf(stderr, "reject_pair: %s\n", error.what()), 2;
}

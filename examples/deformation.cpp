// SPDX-License-Identifier: Apache-2.0
// A baked model as a soft body, and a rigid copy of it DISTANCE away. The soft body is struck and rings with less and
// less amplitude. The world only has to know a bound of how far its vertices are from the rigid pose; trees and cages
// stay as they were baked.
#include <encage/encage.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace {

/// The position of the vertex x (body frame) of the ringing body at `time`, no farther from x than the amplitude.
Eigen::Vector3d ringing(const Eigen::Vector3d& x, double time, double amplitude) {
  const double wave = std::sin(4 * x.z() - 20 * time);
  return x + amplitude * wave * Eigen::Vector3d(0.8, 0.6, 0);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) return std::fprintf(stderr, "usage: deformation MODEL.glb DISTANCE\n"), 2;
  encage::World world;
  const encage::ShapeId shape = world.add_shape(encage::load_shape(argv[1]));
  const auto at = [](double x) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)); };
  const encage::BodyId soft = world.add_body(shape, at(0));
  world.add_body(shape, at(std::atof(argv[2])), {.kind = encage::BodyKind::static_});

  encage::CandidateOptions options{.triangles = true};
  options.ended = [](const encage::CandidatePair&) { std::printf("  separated from now on\n"); };
  for (int step = 0; step < 6; ++step) {
    const double time = step / 60.0, amplitude = 0.5 * std::exp(-30 * time);
    // A simulation takes the largest |vertex - rigid place| of the step; here the amplitude is known to bound it.
    world.set_deformation(soft, amplitude);
    std::printf("step %d: within %.3f of the rigid pose, e.g. the origin at x = %.3f\n", step, amplitude,
                ringing(Eigen::Vector3d::Zero(), time, amplitude).x());
    world.find_candidates(options, [](const encage::CandidatePair& pair) {
      std::printf("  may touch: %zu pairs of triangles, to be tested where they really are\n", pair.triangles.size());
    });
  }
} catch (const encage::Error& error) {
  return std::fprintf(stderr, "deformation: %s\n", error.what()), 2;
}

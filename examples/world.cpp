// SPDX-License-Identifier: Apache-2.0
// Two copies of a baked model, 100 apart. One moves towards the other by DISTANCE: may they touch?
// And what does a ray along the x axis hit first?
#include <encage/encage.h>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) try {
  if (argc != 3) return std::fprintf(stderr, "usage: world MODEL.glb DISTANCE\n"), 2;
  encage::World world;
  const encage::ShapeId shape = world.add_shape(encage::load_shape(argv[1]));
  const auto at = [](double x) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)); };
  world.add_body(shape, at(100), {.kind = encage::BodyKind::static_});
  const encage::BodyId mover = world.add_body(shape, at(0));
  world.set_motion(mover, {at(0), at(std::atof(argv[2]))});
  world.find_candidates({.triangles = true}, [](const encage::CandidatePair& pair) {
    std::printf("bodies %u and %u may touch: %zu pairs of triangles\n", index(pair.a), index(pair.b),
                pair.triangles.size());
  });
  std::printf("%d bodies searched\n", static_cast<int>(world.body_count()));
  const encage::WorldRayHit hit = encage::cast_ray(world, {.origin = {-1000, 0, 0}, .direction = {1, 0, 0}});
  if (hit.answer == encage::RayAnswer::hit) std::printf("a ray along x hits body %u\n", index(hit.object.body));
} catch (const encage::Error& error) {
  return std::fprintf(stderr, "world: %s\n", error.what()), 2;
}

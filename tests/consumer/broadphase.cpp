// SPDX-License-Identifier: GPL-3.0-or-later
#include <encage/encage.h>

#include <cstdio>

// The run time, linked in whatever way: a tetrahedron without cages, against a copy far away and one in the same
// place, as a pair and in a world; and an exception of the library's.
int main() {
  encage::CageHierarchy hierarchy;
  hierarchy.fine.vertices.resize(4, 3);
  hierarchy.fine.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  hierarchy.fine.triangles.resize(4, 3);
  hierarchy.fine.triangles << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  hierarchy.source_volume = 1.0 / 6;
  hierarchy.diagonal = 1.7320508075688772;
  const encage::ShapePtr shape = encage::make_shape(hierarchy);

  const encage::Motion here;
  encage::Motion there;
  there.start.translation().x() = there.end.translation().x() = 5;
  const bool apart = encage::separated(*shape, here, *shape, there).separated;
  const bool together = encage::separated(*shape, here, *shape, here).separated;

  encage::World world;
  const encage::ShapeId id = world.add_shape(shape);
  world.add_body(id, here.start);
  world.add_body(id, there.start);
  const encage::BodyId third = world.add_body(id, here.start);
  int candidates = 0;
  world.find_candidates({.triangles = true},
                        [&](const encage::CandidatePair& pair) { candidates += pair.b == third ? 1 : 1000; });

  bool caught = false;
  try {
    encage::load_shape("there/is/no/such/asset.glb");
  } catch (const encage::Error&) {
    caught = true;
  }

  const encage::Version linked = encage::version();
  const bool versions_agree = linked.major == ENCAGE_VERSION_MAJOR && linked.minor == ENCAGE_VERSION_MINOR &&
                              linked.patch == ENCAGE_VERSION_PATCH;
  std::printf("Encage %d.%d.%d: apart %d, together %d, candidates %d, error caught %d\n", linked.major, linked.minor,
              linked.patch, apart, together, candidates, caught);
  return apart && !together && candidates == 1 && caught && versions_agree ? 0 : 1;
}

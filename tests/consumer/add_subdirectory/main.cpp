// SPDX-License-Identifier: GPL-3.0-or-later
#include <encage/encage.h>

#include <cstdio>

// A tetrahedron without cages, against a copy far away and against one in the same place.
int main() {
  encage::CageHierarchy hierarchy;
  hierarchy.fine.vertices.resize(4, 3);
  hierarchy.fine.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  hierarchy.fine.triangles.resize(4, 3);
  hierarchy.fine.triangles << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  hierarchy.source_volume = 1.0 / 6;
  hierarchy.diagonal = 1.7320508075688772;
  const encage::ShapePtr shape = encage::make_shape(hierarchy);

  encage::Motion here;
  encage::Motion there;
  there.start.translation().x() = there.end.translation().x() = 5;
  const bool apart = encage::separated(*shape, here, *shape, there).separated;
  const bool together = encage::separated(*shape, here, *shape, here).separated;
  std::printf("Encage %d.%d: apart %d, together %d\n", encage::version().major, encage::version().minor, apart,
              together);
  return apart && !together ? 0 : 1;
}

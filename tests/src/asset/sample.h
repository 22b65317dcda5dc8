// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/cage.h>

namespace encage {

/// A cube of side 1 in an octahedron in a tetrahedron, far from 0: small, with known volumes, and with every optional
/// field of the format. The octahedron has faces parallel to its cage's, so the clearances are known, too.
inline CageHierarchy sample_hierarchy() {
  CageHierarchy h;
  h.origin = {1000.5, 0, -0.1};
  h.solid = Solid::capped;
  h.source_hash = {.low = 0x0123456789abcdef, .high = 0xfedcba9876543210};
  h.source_volume = 1;
  h.diagonal = 1.7320508075688772;
  h.fine.vertices.resize(8, 3);
  for (int v = 0; v < 8; ++v) h.fine.vertices.row(v) << (v & 1) - 0.5, (v >> 1 & 1) - 0.5, (v >> 2 & 1) - 0.5;
  h.fine.triangles.resize(12, 3);
  h.fine.triangles << 0, 2, 1, 1, 2, 3, 0, 1, 4, 1, 5, 4, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5, 2, 6, 3, 3, 6, 7, 4, 5, 6,
      5, 7, 6;
  h.cap_count = 2;
  h.fine_error = 5.9604644775390625e-08;

  TriangleMesh octahedron;
  octahedron.vertices.resize(6, 3);
  octahedron.vertices << 2, 0, 0, -2, 0, 0, 0, 2, 0, 0, -2, 0, 0, 0, 2, 0, 0, -2;
  octahedron.triangles.resize(8, 3);
  octahedron.triangles << 0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5;
  Certificate first;
  first.clearance = 0.28125;  // below 0.5 / sqrt(3)
  first.volume = 10.666666666666666;
  first.volume_ratio = 10.666666666666666;
  first.components = 1;
  first.method = Method::hull;
  first.start = "hull/2";
  h.levels.push_back({octahedron, first});

  TriangleMesh tetrahedron;
  tetrahedron.vertices.resize(4, 3);
  tetrahedron.vertices << 3, 3, 3, 3, -3, -3, -3, 3, -3, -3, -3, 3;
  tetrahedron.triangles.resize(4, 3);
  tetrahedron.triangles << 0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2;
  Certificate second = first;
  second.clearance = 0.5625;  // below 1 / sqrt(3)
  second.volume = 72;
  second.volume_ratio = 72;
  second.no_new_handles = true;
  second.method = Method::collapse;
  second.start = "wrap/50";
  h.levels.push_back({tetrahedron, second});
  h.options = R"({"faces":[8,4],"min_clearance":1e-05})";
  return h;
}

}  // namespace encage

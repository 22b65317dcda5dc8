// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <string>
#include <vector>

namespace encage::test {

/// A closed torus about z of radius 1, 2 * around * along triangles.
TriangleMesh torus(int around, int along, double tube = 0.3);

/// Coarse meshes of 192 and 120 triangles around every torus() with a tube of 0.3. They become cages in a fifth of the
/// time that it takes to make some of so many faces.
std::vector<TriangleMesh> coarse_rings();

/// Wavefront OBJ that round-trips doubles.
std::string to_obj(const TriangleMesh& mesh);

}  // namespace encage::test

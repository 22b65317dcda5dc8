// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <string>

namespace encage::test {

/// A closed torus about z with outer radius 1.3, 2 * around * along triangles.
TriangleMesh torus(int around, int along);

/// Wavefront OBJ that round-trips doubles.
std::string to_obj(const TriangleMesh& mesh);

}  // namespace encage::test

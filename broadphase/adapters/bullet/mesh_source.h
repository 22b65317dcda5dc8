// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/mesh.h>

class btConcaveShape;
class btStridingMeshInterface;

namespace encage::bullet {

/// Copies the vertices and triangles of all parts, in their order and without the local scaling. Throws Error for types
/// of vertices or indices that Bullet does not know.
TriangleMesh copy_source(const btStridingMeshInterface& source);

/// The triangles that a concave shape passes to callbacks, in its frame and with its scaling; equal vertices are one.
TriangleMesh collect_triangles(const btConcaveShape& shape);

}  // namespace encage::bullet

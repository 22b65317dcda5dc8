// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/adapters/bullet/pair_proof.h"

#include <Eigen/Geometry>
#include <array>

namespace encage::bullet {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// True only if btPrimitiveTriangle::overlap_test_conservative() finds all corners of `other` farther than `margins` in
/// front of `face`, where Bullet's corners, in the world, are up to `error` away from these.
bool lies_in_front(const Triangle& face, const Triangle& other, double margins, double error) noexcept;

/// True only if GImpact finds no contact between any triangles that are up to `distance` apart: of each two, one lies
/// in front of the other. Gives up after a few thousand pairs. Needs the numbers of triangles to be the fine meshes'.
bool all_in_front(const AttachedMesh& a, const Motion& motion_a, const AttachedMesh& b, const Motion& motion_b,
                  double distance, double error) noexcept;

}  // namespace encage::bullet

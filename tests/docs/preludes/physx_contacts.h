// SPDX-License-Identifier: GPL-3.0-or-later
// scope: namespace
// What the block uses of PhysX, which Debian does not package.
#include <array>
#include <cstdint>
#include <span>
using PxReal = float;
using PxU32 = std::uint32_t;
struct PxVec3 {
  PxVec3(float, float, float) {}
};
struct PxGeometry {};
struct PxTransform {};
struct PxContactBuffer {
  bool contact(const PxVec3&, const PxVec3&, PxReal, PxU32) { return true; }
};
struct Callbacks {
  bool generateContacts(const PxGeometry& a, const PxGeometry& b, const PxTransform& at_a, const PxTransform& at_b,
                        const PxReal contactDistance, const PxReal meshContactMargin, const PxReal toleranceLength,
                        PxContactBuffer& contacts) const;
};
encage::ShapePtr shape;
encage::ManifoldCache cache;
const encage::Shape& shape_of(const PxGeometry&) { return *shape; }
encage::Motion motion_of(const PxTransform&) { return {}; }
encage::ManifoldCache& cache_of(const PxGeometry&, const PxGeometry&) { return cache; }
PxVec3 to_px(const Eigen::Vector3d&) { return {0, 0, 0}; }

// SPDX-License-Identifier: GPL-3.0-or-later
// scope: namespace
// What the block uses of PhysX, which Debian does not package.
using PxReal = float;
struct PxGeometry {};
struct PxTransform {};
struct PxContactBuffer {};
struct Callbacks {
  bool generateContacts(const PxGeometry& a, const PxGeometry& b, const PxTransform& at_a, const PxTransform& at_b,
                        const PxReal contactDistance, const PxReal meshContactMargin, const PxReal toleranceLength,
                        PxContactBuffer& contacts) const;
};
double rounding = 0;
encage::ShapePtr shape;
const encage::Shape& shape_of(const PxGeometry&) { return *shape; }
encage::Motion motion_of(const PxTransform&) { return {}; }
bool make_contacts(const PxGeometry&, const PxGeometry&, const PxTransform&, const PxTransform&, PxReal,
                   PxContactBuffer&) {
  return true;
}

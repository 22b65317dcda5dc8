// SPDX-License-Identifier: GPL-3.0-or-later
// What the block uses of Jolt, which Debian does not package.
#include <functional>
namespace JPH {
struct Body {};
struct Mat44 {};
using Mat44Arg = const Mat44&;
struct CollideShapeSettings {
  float mMaxSeparationDistance = 0.02f;
};
struct CollideShapeCollector {};
struct ShapeFilter {};
struct PhysicsSystem {
  using SimCollideBodyVsBody = std::function<void(const Body&, const Body&, Mat44Arg, Mat44Arg, CollideShapeSettings&,
                                                  CollideShapeCollector&, const ShapeFilter&)>;
  void SetSimCollideBodyVsBody(const SimCollideBodyVsBody&) {}
  static void sDefaultSimCollideBodyVsBody(const Body&, const Body&, Mat44Arg, Mat44Arg, CollideShapeSettings&,
                                           CollideShapeCollector&, const ShapeFilter&) {}
};
}  // namespace JPH
JPH::PhysicsSystem physics_system;
double rounding = 0;
encage::ShapePtr shape;
const encage::Shape& shape_of(const JPH::Body&) { return *shape; }
encage::Motion motion_of(const JPH::Body&, JPH::Mat44Arg) { return {}; }

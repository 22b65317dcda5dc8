// SPDX-License-Identifier: GPL-3.0-or-later
// scope: namespace
// What the block uses of Coal, which Debian 12 does not package.
#include <algorithm>
namespace coal {
struct CollisionObject {};
struct CollisionRequest {
  double security_margin = 0;
};
struct CollisionData {
  CollisionRequest request;
};
struct CollisionCallBackDefault {
  virtual ~CollisionCallBackDefault() = default;
  virtual bool collide(CollisionObject*, CollisionObject*) { return false; }
  CollisionData data;
};
}  // namespace coal
double rounding = 0;
encage::ShapePtr shape;
const encage::Shape& shape_of(const coal::CollisionObject&) { return *shape; }
encage::Motion motion_of(const coal::CollisionObject&) { return {}; }

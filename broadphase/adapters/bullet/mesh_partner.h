// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/shape.h>

#include <LinearMath/btVector3.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>

class btCollisionShape;

namespace encage::bullet {

/// What of a shape of Bullet's may change between two steps, and is quick to compare.
struct PartnerTraits {
  int type = -1;
  btVector3 scaling{1, 1, 1}, low{0, 0, 0}, high{0, 0, 0};  ///< the last two: bounds in the shape's frame
  btScalar margin = 0;

  friend bool operator==(const PartnerTraits&, const PartnerTraits&) = default;
};

PartnerTraits traits_of(const btCollisionShape& shape);

/// One of Bullet's own shapes as contact_manifold() takes it. Its frame is the shape's, scaling included.
struct Partner {
  ShapePtr shape;     ///< null if there are no triangles
  double radius = 0;  ///< that rounds the shape: world units
  double reach = 0;   ///< largest distance of a point from the origin, the radius included
  PartnerTraits traits;
  std::uint64_t content = 0;  ///< hash of what the traits do not tell
};

/// True for types of shapes that can be converted: convex shapes, triangle meshes and height fields.
bool is_partner_type(int type) noexcept;

/// Converts a shape of such a type. O(n log n). Throws Error if the vertices of a mesh are not finite.
Partner make_partner(const btCollisionShape& shape);

/// The converted shapes. Thread safe.
class Partners {
 public:
  /// Returns the shape as it is now; converts it if it is new or has changed.
  std::shared_ptr<const Partner> get(const btCollisionShape& shape);
  bool forget(const btCollisionShape& shape) noexcept;

 private:
  std::mutex mutex_;
  std::unordered_map<const btCollisionShape*, std::shared_ptr<const Partner>> all_;
};

}  // namespace encage::bullet

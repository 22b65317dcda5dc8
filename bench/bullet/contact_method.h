// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/bullet/scene_body.h"

#include <btBulletDynamicsCommon.h>
#include <nlohmann/json.hpp>

#include <memory>
#include <string>
#include <vector>

namespace encage::bullet_bench {

/// A collision shape of one body, and what it is made of.
class MethodShape {
 public:
  virtual ~MethodShape() = default;
  virtual btCollisionShape& shape() = 0;
  /// Returns what the report says of the shape, or null.
  virtual nlohmann::ordered_json details() const { return nullptr; }
};

/// A way to give Bullet contacts of concave bodies that move.
class ContactMethod {
 public:
  virtual ~ContactMethod() = default;
  virtual std::string name() const = 0;
  virtual std::string description() const = 0;
  virtual std::unique_ptr<MethodShape> make_shape(const SceneBodyModel& body) const = 0;
  /// Registers the method's algorithms; they stay as long as the result lives, which the dispatcher outlives.
  virtual std::shared_ptr<void> attach(btCollisionDispatcher& dispatcher) const = 0;
};

std::vector<std::string> all_method_names();
/// Those that this build has.
std::vector<std::string> method_names();
/// Throws Error that names the methods there are, or the reason why this build lacks one.
std::unique_ptr<ContactMethod> make_contact_method(const std::string& name);

/// Null where the build lacks HACD.
std::unique_ptr<ContactMethod> make_hull_method();

}  // namespace encage::bullet_bench

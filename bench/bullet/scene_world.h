// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/bullet/contact_method.h"
#include "bench/bullet/scene_body.h"
#include "bench/bullet/scenes.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace encage::bullet_bench {

/// Costs of one step, in CPU milliseconds.
struct StepCost {
  double detect_ms = 0;  ///< of the dispatcher over all pairs: the narrow phase
  double step_ms = 0;    ///< whole
};

/// Contacts that the solver was given in the last step: of pairs with a contact point.
struct StepContacts {
  std::int64_t points = 0, pairs = 0;
};

/// Mean squares over the bodies that move.
struct StepMotion {
  double linear = 0, angular = 0;
};

/// A scene in a btDiscreteDynamicsWorld with Bullet's default solver settings. Bodies do not sleep: what moves is seen.
class SceneWorld {
 public:
  /// `models` and `shapes` belong to the scene's meshes and outlive the world.
  SceneWorld(const Scene& scene, const std::vector<SceneBody>& bodies, const std::vector<SceneBodyModel>& models,
             const ContactMethod& method, const std::vector<std::unique_ptr<MethodShape>>& shapes);
  ~SceneWorld();
  SceneWorld(const SceneWorld&) = delete;
  SceneWorld& operator=(const SceneWorld&) = delete;

  StepCost step();
  StepContacts contacts() const;
  StepMotion motion() const;
  /// By body: frame of the mesh -> world.
  std::vector<Eigen::Isometry3d> poses() const;

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace encage::bullet_bench

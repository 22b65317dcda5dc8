// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/bullet/scene_body.h"
#include "bench/bullet/scene_world.h"
#include "bench/bullet/scenes.h"

#include <memory>
#include <string>
#include <vector>

namespace encage::jolt_bench {

/// Settings of Jolt that a run changes.
struct JoltSettings {
  std::string name;
  std::string description;
  double penetration_slop = 0.02;  ///< metres; Jolt's default
  bool reduces = false;            ///< Jolt merges manifolds that face one way
};

/// A scene of contacts in a JPH::PhysicsSystem, on one thread. Bodies do not sleep: what moves is seen.
class JoltWorld {
 public:
  JoltWorld(const bullet_bench::Scene& scene, const std::vector<bullet_bench::SceneBody>& bodies,
            const JoltSettings& settings);
  ~JoltWorld();
  JoltWorld(const JoltWorld&) = delete;
  JoltWorld& operator=(const JoltWorld&) = delete;

  /// Throws Error if a pair has no contacts for a reason that the adapter states.
  bullet_bench::StepCost step();
  bullet_bench::StepContacts contacts() const;
  bullet_bench::StepMotion motion() const;
  /// By body: frame of the mesh -> world.
  std::vector<Eigen::Isometry3d> poses() const;

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace encage::jolt_bench

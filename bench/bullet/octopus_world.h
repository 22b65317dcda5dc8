// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "oracles/bullet_contact_points.h"

#include <encage/bullet.h>
#include <encage/mesh.h>

#include <cstdint>
#include <memory>
#include <set>
#include <utility>
#include <vector>

namespace encage::bullet_bench {

/// Bodies of one mesh, about 1 in radius, that tumble in a cube of six static planes.
struct BulletScene {
  int bodies = 64;
  double width = 10;   ///< side of the cube
  double speed = 1;    ///< at the start, per body, in a random direction
  double spin = 1;     ///< radians per second, likewise
  double gravity = 0;  ///< downwards
  double margin = 0;   ///< collision margin of the mesh
  double dt = 1.0 / 240;
  unsigned seed = 1;
};

/// Who stands in front of the collision algorithms.
enum class Guard {
  none,
  adapter,
  oracle,  ///< knows which pairs will have contacts, at no cost
};

/// A Bullet world of such a scene. Bodies are numbered, planes come after meshes.
class OctopusWorld {
 public:
  OctopusWorld(const TriangleMesh& mesh, const ShapePtr& shape, const BulletScene& scene, Guard guard,
               BulletContacts contacts = BulletContacts::all);
  ~OctopusWorld();
  OctopusWorld(const OctopusWorld&) = delete;
  OctopusWorld& operator=(const OctopusWorld&) = delete;

  /// One step of the simulation; CPU milliseconds of performDiscreteCollisionDetection(). An oracle is told `touching`.
  double step(const std::set<TouchingPair>& touching = {});

  std::vector<ContactPoint> contacts() const;
  std::set<TouchingPair> pairs_in_touch() const;  ///< with a contact point
  std::vector<float> transforms() const;
  std::pair<std::int64_t, std::int64_t> pairs() const;  ///< overlapping boxes: two meshes; mesh and plane
  BulletStatistics statistics() const;

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace encage::bullet_bench

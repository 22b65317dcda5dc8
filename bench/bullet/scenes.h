// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The contact scenes. Lengths are metres, z is up, gravity 9.81 m/s^2.

#include <encage/mesh.h>
#include <encage/motion.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace encage::bullet_bench {

inline constexpr int steps_per_second = 60;

struct SceneBody {
  int mesh = 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< frame of the mesh -> world
  bool moves = true;
};

/// Holds the poses of all bodies of a run, at the start and after every step.
struct SceneHistory {
  std::vector<std::vector<Eigen::Isometry3d>> poses;
  double end_penetration = 0;  ///< after the last step
};

struct Verdict {
  bool holds = false;
  std::string figure;  ///< what was measured, in words
  double value = 0;    ///< the number in it
};

struct Scene {
  std::string name;
  std::vector<TriangleMesh> meshes;
  std::vector<HalfSpace> planes;
  double friction = 0.5;  ///< coefficient of a pair
  double seconds = 10;
  std::vector<std::uint64_t> seeds;  ///< unless others are asked for
  std::function<std::vector<SceneBody>(std::uint64_t seed)> place;
  std::function<Verdict(const SceneHistory&)> judge;
};

std::vector<std::string> scene_names();

/// Throws Error naming the scenes there are. `octopus_triangles` is for the heap.
Scene make_contact_scene(const std::string& name, std::int64_t octopus_triangles = 50'000);

/// Distance of the centres of two links that pull at each other, turned by 90 degrees: of the meshes, so that what
/// facets take is subtracted.
double taut_pitch(const TriangleMesh& link);
/// Height of a bowl above an equal one in which it stands upright, facets in line.
double nested_pitch(const TriangleMesh& bowl);

}  // namespace encage::bullet_bench

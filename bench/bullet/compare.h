// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/bullet/octopus_world.h"

#include <nlohmann/json.hpp>

#include <iosfwd>
#include <string>
#include <vector>

namespace encage::bullet_bench {

/// One of the worlds that take turns step by step, all of the same scene.
struct WorldResult {
  std::string name;
  double ms_per_step = 0;      ///< collision detection, the median of the runs
  std::vector<double> ratios;  ///< by run: time of the world without adapter / this one's
  double ratio = 0;            ///< their median
  std::int64_t asked = 0, rejected = 0;
  std::int64_t different_contacts = 0;    ///< steps whose contacts are not those of the world without adapter
  std::int64_t different_transforms = 0;  ///< likewise
};

struct BulletComparison {
  BulletScene scene;
  int steps = 0, runs = 0;
  std::int64_t mesh_pairs = 0, plane_pairs = 0;           ///< overlapping boxes, over all steps
  std::int64_t touching_meshes = 0, touching_planes = 0;  ///< of these, with contact points
  std::vector<WorldResult> contestants;                   ///< without adapter; with it, both kinds of contacts; oracle

  bool same() const;  ///< all worlds behaved alike in every step
};

/// Simulates the scene `runs` times.
BulletComparison compare(const TriangleMesh& mesh, const ShapePtr& shape, const BulletScene& scene, int steps,
                         int runs);

void print(std::ostream& out, const BulletComparison& comparison);
nlohmann::ordered_json to_json(const BulletComparison& comparison);

}  // namespace encage::bullet_bench

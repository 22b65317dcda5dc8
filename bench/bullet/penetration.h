// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/flow/signed_distance.h"

#include <encage/mesh.h>
#include <encage/motion.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace encage::bullet_bench {

/// How deep bodies are in each other, by their meshes: the largest distance to the other's surface of a sample of
/// either surface that is inside the other. Nothing of it is shared with the contacts that are judged. Samples are the
/// vertices, and where edges are longer than 2 % of the size the middles of edges and faces.
class PenetrationProbe {
 public:
  /// The mesh is closed, embedded and oriented outward.
  explicit PenetrationProbe(const TriangleMesh& mesh);

  /// 0 if no sample of one is inside the other.
  friend double penetration(const PenetrationProbe& a, const Eigen::Isometry3d& pose_a, const PenetrationProbe& b,
                            const Eigen::Isometry3d& pose_b);
  double below(const Eigen::Isometry3d& pose, const HalfSpace& solid) const;

 private:
  /// A ball that holds the samples [first, last).
  struct Node {
    Eigen::Vector3d centre;
    double radius = 0;
    std::int32_t first = 0, last = 0;
    std::int32_t right = 0;  ///< second child, the first one follows; 0: a leaf
  };
  std::int32_t build(std::int32_t first, std::int32_t last);
  /// The largest depth(sample) if it exceeds `least`, else `least`. Depth must not grow by more than the length of a
  /// path.
  template <class Depth>
  double deepest(double least, const Depth& depth) const;
  double deepest_in(const PenetrationProbe& other, const Eigen::Isometry3d& to_other, double least) const;

  makers::SignedDistance distance_;
  std::vector<Eigen::Vector3d> samples_;
  std::vector<Node> nodes_;
};

double penetration(const PenetrationProbe& a, const Eigen::Isometry3d& pose_a, const PenetrationProbe& b,
                   const Eigen::Isometry3d& pose_b);

}  // namespace encage::bullet_bench

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace encage::octopus {

/// Value and gradient of an implicit function; negative inside.
struct Sample {
  double value = 0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// A union of spheres along a segment whose radii change linearly.
class Rod {
 public:
  Rod(const Eigen::Vector3d& start, const Eigen::Vector3d& end, double start_radius, double end_radius);

  double length() const { return length_; }
  const Eigen::Vector3d& middle() const { return middle_; }
  /// Radius of a ball about the middle that holds all spheres.
  double reach() const { return reach_; }
  /// Signed distance (exact outside).
  double value(const Eigen::Vector3d& p) const;
  Sample sample(const Eigen::Vector3d& p) const;

 private:
  double along(const Eigen::Vector3d& p) const;

  Eigen::Vector3d start_, direction_, middle_;
  double length_, start_radius_;
  double slope_;  // of the radii, along the segment
  double lean_;   // how far the nearest sphere lies ahead of the foot, per distance from the axis
  double reach_;
};

/// Tubes, united smoothly. Each tube is the plain union of its rods; its surface blends into what stands before it in
/// the list over the width `blend`. The function changes by at most the distance between two points (it is
/// 1-Lipschitz).
class ImplicitSurface {
 public:
  struct Tube {
    std::vector<Rod> rods;
    double blend = 0;
  };
  /// The rods that matter inside some ball: indices into all rods, grouped by tube.
  struct Parts {
    struct Group {
      std::int32_t tube;
      std::vector<std::int32_t> rods;
    };
    std::vector<Group> groups;
  };

  explicit ImplicitSurface(std::vector<Tube> tubes);

  Parts all_parts() const;
  /// The subset of `parts` that decides the function within `radius` of `centre`.
  Parts relevant(const Parts& parts, const Eigen::Vector3d& centre, double radius) const;
  double value(const Eigen::Vector3d& p, const Parts& parts) const;
  Sample sample(const Eigen::Vector3d& p, const Parts& parts) const;

 private:
  std::vector<Tube> tubes_;
  double widest_blend_ = 0;
};

}  // namespace encage::octopus

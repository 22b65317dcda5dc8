// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Brute force in exact arithmetic: the truth against which rejects are tested.

#include <encage/mesh.h>

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <memory>

namespace encage::test {

/// A mesh in a pose: every vertex is the exact image of `scale (origin + vertex)` under the pose, all entries being
/// taken as the rational numbers they are.
class ExactBody {
 public:
  ExactBody(const Eigen::Vector3d& origin, const TriangleMesh& mesh, const Eigen::Isometry3d& pose, double scale = 1);
  ~ExactBody();
  ExactBody(ExactBody&&) noexcept;

  struct Data;
  const Data& data() const { return *data_; }

 private:
  std::unique_ptr<Data> data_;
};

/// True if some triangles have a common point or, for distance > 0, are at most `distance` apart.
bool surfaces_meet(const ExactBody& a, const ExactBody& b, double distance);

/// The same for one triangle of each.
bool triangles_meet(const ExactBody& a, std::int64_t i, const ExactBody& b, std::int64_t j, double distance);

/// True if all vertices of triangles are farther than `distance` >= 0 from the half-space n.x <= offset; n may have any
/// length.
bool all_beyond(const ExactBody& body, const Eigen::Vector3d& n, double offset, double distance);

/// Winding number of a closed mesh about a point that is not on it.
int winding_number(const ExactBody& body, const Eigen::Vector3d& point);

/// For bodies whose surfaces do not meet: true if a vertex of some component of `guest` has a non-zero winding number
/// in `host`, which is closed.
bool holds_component(const ExactBody& host, const ExactBody& guest);

/// The ray origin + t direction with t between `low` and `high`, which may be infinite; direction is not 0.
struct ExactRay {
  Eigen::Vector3d origin, direction;
  double low, high;
};

/// True if a ray has a point in common with triangle i, which may be degenerate.
bool ray_meets(const ExactBody& body, std::int64_t i, const ExactRay& ray);

using Corners = std::array<Eigen::Vector3d, 3>;
/// True if the distance of two triangles is at most `distance` >= 0, exactly.
bool triangles_meet(const Corners& a, const Corners& b, double distance);

}  // namespace encage::test

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/render/render.h"

#include <encage/mesh.h>

#include <embree3/rtcore.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace encage::render {

/// Unit normals, three a triangle: each is the mean over the triangles around the corner's point that bend by less than
/// 40 degrees. Corners at the same position count as one. Flat normals if `smooth` is false.
std::vector<Eigen::Vector3f> corner_normals(const TriangleMesh& mesh, bool smooth);

struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  ///< of unit length
  double near = 0;
  double far = 0;
};

struct Hit {
  std::uint32_t item = 0;  ///< index into the items the scene was made of
  std::uint32_t triangle = 0;
  double distance = 0;
  float u = 0, v = 0;
};

/// Triangles of several items in one Embree scene; vertices in float32 relative to `centre`. Queries are re-entrant.
class Scene {
 public:
  /// Holds the items that `chosen` names.
  Scene(std::span<const Item> items, const std::vector<std::uint32_t>& chosen, const Eigen::Vector3d& centre);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  std::optional<Hit> nearest(const Ray& ray) const;
  bool blocked(const Ray& ray) const;

 private:
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  Eigen::Vector3d centre_;
};

}  // namespace encage::render

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/decimate/self_contact.h"

#include <encage/mesh.h>

#include <cstdint>
#include <span>
#include <vector>

namespace encage::makers {

/// Follows the edge collapses of a mesh and tells which would bring it into contact with itself.
class EmbeddingGuard {
 public:
  EmbeddingGuard(const TriangleMesh& mesh, double gap) : mesh_(mesh), tree_(mesh_), gap_(gap) {}
  EmbeddingGuard(const EmbeddingGuard&) = delete;
  EmbeddingGuard& operator=(const EmbeddingGuard&) = delete;

  /// May all triangles around the edge (from, to) be replaced by those around one vertex at `position`? `star`: the
  /// triangles with exactly one of the edge's vertices; `lost`: those with both.
  bool allows(std::int32_t from, std::int32_t to, std::span<const std::int32_t> star,
              std::span<const std::int32_t> lost, const Point& position);
  /// The edge has been collapsed to its vertex `kept`.
  void collapsed(std::int32_t gone, std::int32_t kept, std::span<const std::int32_t> star,
                 std::span<const std::int32_t> lost, const Point& position);

 private:
  TriangleMesh mesh_;  ///< removed triangles have negative indices
  SurfaceTree tree_;
  double gap_;
  std::int64_t changes_ = 0;
  std::int64_t live_ = mesh_.triangles.rows();
};

}  // namespace encage::makers

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/shape/on_demand.h"
#include "broadphase/shape/outline.h"
#include "src/asset/view.h"
#include "src/tree/mesh_arrays.h"

#include <encage/shape.h>

#include <deque>
#include <optional>
#include <vector>

namespace encage {

/// Of places, sizes and margins: larger ones could overflow where bounds are added up.
inline constexpr double largest_length = 1e150;

/// A surface in the local frame of its hierarchy, ready for queries. Its arrays live in the Shape.
struct Surface : MeshArraysView {
  Surface() = default;
  explicit Surface(const MeshArraysView& arrays);

  bool closed = false;                              ///< has no boundary: winding numbers mean something
  double radius = 0;                                ///< largest distance of a vertex from the local origin, rounded up
  Eigen::Vector3f lower = Eigen::Vector3f::Zero();  ///< of all vertices of triangles
  Eigen::Vector3f upper = Eigen::Vector3f::Zero();

  bool empty() const { return tree.leaves.empty(); }
  Eigen::Vector3d vertex(std::int32_t v) const {
    return Eigen::Map<const Eigen::Vector3f>(mesh.vertices[v].data()).cast<double>();
  }
};

/// A surface at the size that it has in the world: coordinates are `scale` times the stored ones. The surface
/// must outlive it.
class ScaledSurface {
 public:
  ScaledSurface(const Surface& surface, double scale = 1) : surface_(&surface), scale_(scale) {}  // NOLINT: a view

  const Surface& operator*() const { return *surface_; }
  const Surface* operator->() const { return surface_; }
  double scale() const { return scale_; }
  double radius() const { return scale_ * surface_->radius; }
  Eigen::Vector3d vertex(std::int32_t v) const { return scale_ * surface_->vertex(v); }

 private:
  const Surface* surface_;
  double scale_;
};

/// One part of a compound: itself no compound.
struct ShapePart {
  ShapePtr shape;
  Eigen::Isometry3d pose;
  double scale;
  Eigen::AlignedBox3d box;      ///< in the compound's frame
  double reach;                 ///< sum of the sizes that its place is computed from
  int nesting;                  ///< compounds that it was taken out of
  std::int32_t first_triangle;  ///< of all parts' fine meshes
  std::int32_t first_vertex;
};

struct PartNode {
  Eigen::AlignedBox3d box;  ///< in the compound's frame
  std::array<std::int32_t, 2> children = {-1, -1};
  std::int32_t part = -1;  ///< of a leaf
};

/// Simple, or a compound: that has parts and none of its own surfaces. Public headers
/// have only its name.
class ENCAGE_HIDDEN Shape {
 public:
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< body frame = origin + local frame
  Solid solid = Solid::closed;
  bool hollow = false;         ///< the body is its surface alone
  double fine_error = 0;       ///< distance of a source vertex from its fine vertex, at most
  double radius = 0;           ///< largest of all surfaces
  std::vector<Surface> cages;  ///< fine to coarse; each closed
  Surface fine;                ///< may be empty; of a mesh on demand only while a FineLease is held
  std::size_t fine_triangles = 0, fine_vertices = 0;  ///< in memory or not
  Outline outline;            ///< few points that hold the body, for its world boxes; may be empty
  double outline_radius = 0;  ///< largest norm of these

  std::vector<ShapePart> parts;
  std::vector<PartNode> part_nodes;  ///< a tree, the root first

  bool has_fine() const { return on_demand || !fine.empty(); }
  /// The surface whose box bounds the body, and the error of that; always in memory.
  const Surface& outer() const { return on_demand || fine.empty() ? cages.front() : fine; }
  double outer_error() const { return has_fine() ? fine_error : 0; }

  // What the surfaces refer to.
  std::deque<MeshArrays> owned_arrays;
  std::optional<AssetView> asset;
  std::unique_ptr<OnDemandMesh> on_demand;  ///< of a shape of a ShapeCache that has a fine mesh
};

/// The shape of an asset, its fine mesh on demand.
ShapePtr load_cages(const std::filesystem::path& file, const ShapeOptions& options, LoadMode mode,
                    std::shared_ptr<MeshBudget> budget);

}  // namespace encage

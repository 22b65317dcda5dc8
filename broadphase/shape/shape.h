// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/motion/pair_frame.h"
#include "broadphase/shape/on_demand.h"
#include "broadphase/shape/outline.h"
#include "broadphase/shape/surface_features.h"
#include "src/asset/view.h"
#include "src/mesh/moments.h"
#include "src/tree/mesh_arrays.h"

#include <encage/shape.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace encage {

/// A surface in the local frame of its hierarchy, ready for queries. The Shape owns its arrays.
struct Surface : MeshArraysView {
  Surface() = default;
  explicit Surface(const MeshArraysView& arrays);

  bool closed = false;                              ///< has no boundary, so that winding numbers are defined
  double radius = 0;                                ///< largest distance of a vertex from the local origin, rounded up
  Eigen::Vector3f lower = Eigen::Vector3f::Zero();  ///< bounds of all vertices of triangles
  Eigen::Vector3f upper = Eigen::Vector3f::Zero();
  /// The mesh with the triangles around it, where it is a tile of a larger surface. Those follow the mesh's own, and
  /// are in no tree. Otherwise the mesh.
  MeshView surroundings;
  /// For each vertex of the surroundings of a tile, 1 if a triangle of another tile owns it; otherwise empty.
  std::span<const std::uint8_t> foreign;

  bool is_foreign(std::int32_t v) const { return !foreign.empty() && foreign[static_cast<std::size_t>(v)] != 0; }
  bool empty() const { return tree.leaves.empty(); }
  Eigen::Vector3d vertex(std::int32_t v) const {
    return Eigen::Map<const Eigen::Vector3f>(mesh.vertices[v].data()).cast<double>();
  }
};

/// A surface at the size that it has in the world: coordinates are `scale` times the stored ones. The surface must
/// outlive it.
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

class SimpleShape;
class CompoundShape;

/// A simple shape or a compound. Public headers only declare its name.
class ENCAGE_HIDDEN Shape {
 public:
  Shape(const Shape&) = delete;
  Shape& operator=(const Shape&) = delete;

  bool is_compound() const { return is_compound_; }
  const SimpleShape& simple() const;      ///< requires a simple shape
  const CompoundShape& compound() const;  ///< requires a compound

 protected:
  explicit Shape(bool is_compound) : is_compound_(is_compound) {}
  ~Shape() = default;  // only ShapePtr deletes shapes, by their own type

 private:
  bool is_compound_;
};

/// Surfaces of one rigid body in its own frame: cages, the fine mesh, or both.
class ENCAGE_HIDDEN SimpleShape final : public Shape {
 public:
  SimpleShape();

  const std::uint64_t number;  ///< > 0, of no other shape of the process
  LocalFrame frame;            ///< of all surfaces; its radius is the largest of theirs
  Solid solid = Solid::closed;
  bool hollow = false;     ///< the body is its surface alone
  double fine_error = 0;   ///< largest distance of a source vertex from its fine vertex
  bool primitive = false;  ///< of <encage/primitives.h>: convex, without cages, and a hollow core if it has no volume
  /// Of a primitive: the body is all points within it of the fine mesh, its core, and of what that encloses.
  double convex_radius = 0;
  std::vector<Surface> cages;  ///< fine to coarse; each closed
  Surface fine;                ///< may be empty; for a mesh on demand valid only while a FineLease exists
  std::size_t fine_triangles = 0, fine_vertices = 0;  ///< also while the fine mesh is not in memory
  Outline outline;            ///< few points whose hull contains the body, for its world boxes; may be empty
  double outline_radius = 0;  ///< largest norm of the outline's points

  bool has_fine() const { return on_demand || !fine.empty(); }
  /// Returns the surface whose box bounds the body; it is always in memory.
  const Surface& outer() const { return on_demand || fine.empty() ? cages.front() : fine; }
  /// Returns how far the body may reach beyond outer() in the world. A usable pose stretches it by less than 1e-9.
  double error_in_world(double scale) const {
    return has_fine() ? (1 + 1e-8) * scale * (fine_error + convex_radius) : 0;
  }
  /// The same of a primitive's core, as if the radius were 0.
  double core_error_in_world(double scale) const { return has_fine() ? (1 + 1e-8) * scale * fine_error : 0; }
  /// Returns how much of the radius the body has in the world at least, beyond the core as it was given.
  double least_radius(double scale) const { return (1 - 1e-8) * scale * convex_radius; }
  /// Returns the distance from the fine mesh, in the world, that counts as contact of the body.
  double contact_margin(double scale) const { return primitive ? error_in_world(scale) : 0; }
  /// Returns what stands for cage `k`, or the coarsest: a primitive stands for itself. Null if there is none.
  const Surface* level(int k) const {
    if (cages.empty()) return primitive ? &fine : nullptr;
    return &cages[std::min(static_cast<std::size_t>(k), cages.size() - 1)];
  }
  /// Returns how far the body may reach beyond what level() returns, in the world.
  double beyond_level(double scale) const { return cages.empty() ? error_in_world(scale) : 0; }
  /// Returns the features of the fine mesh, which must be in memory. The first call makes them; they are kept, unless
  /// forget_features() is called. Thread safe.
  const SurfaceFeatures& features() const {
    std::call_once(features_->made, [this] {
      features_->features = make_surface_features(fine.surroundings, fine.parts, std::move(known_twin));
      if (!drops_features) feature_bytes_.store(features_->features.bytes(), std::memory_order_release);
    });
    return features_->features;
  }
  /// Nothing may use the features.
  void forget_features() { features_.emplace(); }
  /// Returns 0 until the features have been made. Thread safe.
  std::int64_t feature_bytes() const noexcept { return feature_bytes_.load(std::memory_order_acquire); }

  /// Returns the part of the fine mesh, which must be in memory, that each vertex belongs to; -1 where no triangle has
  /// it. The first call finds them. Thread safe.
  const std::shared_ptr<const std::vector<std::int32_t>>& part_of_vertex() const;
  /// Returns Certificate::clearance of each cage. Reads the description of an asset that is mapped or was read; throws
  /// Error if it is damaged. Thread safe.
  std::vector<double> clearances() const;
  void set_clearances(std::vector<double> all) { clearances_ = std::move(all); }  ///< unless the asset has them

  /// Moments of a primitive, exact, about a point of the local frame.
  struct KnownMoments {
    Moments moments;
    Eigen::Vector3d apex = Eigen::Vector3d::Zero();
  };
  std::optional<KnownMoments> known_moments;

  // These hold what a shape of the same triangles knows already; they may be empty.
  mutable std::vector<std::int32_t> known_twin;
  mutable std::shared_ptr<const std::vector<std::int32_t>> known_parts;

  // The memory that the surfaces refer to.
  std::vector<MeshArrays> owned_arrays;
  std::optional<AssetView> asset;
  std::unique_ptr<OnDemandMesh> on_demand;  ///< set for a shape whose fine mesh comes and goes
  bool drops_features = false;              ///< with the fine mesh, whose bytes include theirs

 private:
  struct Features {
    std::once_flag made;
    SurfaceFeatures features;
  };
  mutable std::optional<Features> features_{std::in_place};
  mutable std::once_flag parts_known_;
  mutable std::atomic<std::int64_t> feature_bytes_{0};
  std::vector<double> clearances_;
};

/// One part of a compound.
struct ENCAGE_HIDDEN ShapePart {
  std::shared_ptr<const SimpleShape> shape;
  Eigen::Isometry3d pose;  ///< in the compound's frame
  double scale;
  Eigen::AlignedBox3d box;      ///< in the compound's frame
  double reach;                 ///< sum of the magnitudes from which its position is computed
  int nesting;                  ///< number of compounds that contained it
  std::int32_t first_triangle;  ///< in the numbering of all parts' fine meshes
  std::int32_t first_vertex;
};

/// A node of a binary tree of parts.
struct PartNode {
  Eigen::AlignedBox3d box;  ///< in the compound's frame
  std::array<std::int32_t, 2> children = {-1, -1};
  std::int32_t part = -1;  ///< used in leaves only
};

/// The union of parts, none of which is a compound.
class ENCAGE_HIDDEN CompoundShape final : public Shape {
 public:
  CompoundShape() : Shape(true) {}

  std::vector<ShapePart> parts;
  std::vector<PartNode> nodes;  ///< the root first
  double reach = 0;             ///< the largest of the parts
  bool has_fine = true;         ///< all parts have
};

inline const SimpleShape& Shape::simple() const {
  assert(!is_compound_);
  return static_cast<const SimpleShape&>(*this);
}
inline const CompoundShape& Shape::compound() const {
  assert(is_compound_);
  return static_cast<const CompoundShape&>(*this);
}

/// Makes a primitive of its core, as make_shape() makes a shape. `error` bounds how far the core that was meant is from
/// the mesh, in both directions; `flat` says that the mesh encloses no volume. Throws Error as make_shape() does.
std::shared_ptr<SimpleShape> make_primitive(const TriangleMesh& core, double error, double convex_radius, bool flat);

/// Loads the shape of an asset with its fine mesh on demand.
ShapePtr load_cages(const std::filesystem::path& file, const ShapeOptions& options, LoadMode mode,
                    std::shared_ptr<MeshBudget> budget);

}  // namespace encage

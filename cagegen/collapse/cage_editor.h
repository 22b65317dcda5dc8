// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/geometry/obstacle.h"
#include "cagegen/geometry/qp3.h"
#include "cagegen/geometry/triangle_tree.h"

#include <encage/mesh.h>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace encage::makers {

struct EditorOptions {
  double clearance = 0;       ///< to the obstacle, length
  double self_clearance = 0;  ///< between triangles that share no vertex, length
  bool keep_cones = true;     ///< every vertex keeps a direction that all its triangles face
  double quadric_weight = 1;  ///< weight of the quadric error against the added volume
};

/// A position that a vertex may take, and the volume that this adds.
struct VertexPlacement {
  Point position;
  double cost = 0;
};

/// A cage being edited: a closed, embedded manifold around an obstacle that it never touches. Every edit is planned
/// against obstacle and cage, then applied, and keeps that. Vertices are always exact in float32. One thread at a time
/// may use it.
class CageEditor {
 public:
  /// `cage` must be closed, oriented, embedded and clear of the obstacle. Refers to the obstacle.
  CageEditor(const Obstacle& obstacle, const TriangleMesh& cage, const EditorOptions& options);

  std::int64_t face_count() const { return face_count_; }
  std::int32_t vertex_capacity() const { return static_cast<std::int32_t>(position_.size()); }
  bool alive(std::int32_t vertex) const { return !incident_[vertex].empty(); }
  const Point& position(std::int32_t vertex) const { return position_[vertex]; }
  void neighbours(std::int32_t vertex, std::vector<std::int32_t>& found) const;
  void set_options(const EditorOptions& options) { options_ = options; }
  const EditorOptions& options() const { return options_; }

  /// A cheap lower estimate of what merging the ends of an edge costs, without regard to the obstacle.
  double estimate_collapse(std::int32_t u, std::int32_t v) const;
  /// Plans merging u and v into one vertex; no value if it cannot be done.
  std::optional<VertexPlacement> plan_collapse(std::int32_t u, std::int32_t v);
  /// Merges v into u at a planned position.
  void apply_collapse(std::int32_t u, std::int32_t v, const Point& position);

  /// Plans the move of a vertex that encloses less volume. `reach` limits its length.
  std::optional<VertexPlacement> plan_tightening(std::int32_t vertex, double reach);
  void apply_move(std::int32_t vertex, const Point& position);

  /// Plans a new vertex on an edge, moved to where the cage encloses less: two triangles more. `reach` limits the move.
  std::optional<VertexPlacement> plan_split(std::int32_t u, std::int32_t v, double reach);
  /// Returns the new vertex.
  std::int32_t apply_split(std::int32_t u, std::int32_t v, const Point& position);

  /// The cage with unused vertices dropped, in a fixed order.
  TriangleMesh extract() const;

 private:
  struct RingEdge {
    std::int32_t a;
    std::int32_t b;
    std::int32_t triangle;  ///< takes the corners (p, a, b)
  };
  /// One vertex p fanned to ring edges, in place of the triangles of a patch.
  struct Patch {
    std::vector<RingEdge> ring;
    std::vector<std::int32_t> old_triangles;
    std::array<Point, 2> replaced;  ///< vertices, or the middle of an edge, in whose place p comes
    int replaced_count = 0;
  };
  /// Buffers that one plan leaves to the next, so that plans do not allocate.
  struct Scratch {
    Patch patch;
    std::array<std::vector<std::int32_t>, 2> neighbours;
    std::vector<LinearConstraint> planes;  ///< one a ring edge
    std::vector<LinearConstraint> active;
    std::vector<std::int32_t> hits;
    std::vector<Point> fan;  ///< normals of the new triangles
    std::vector<Point> normals;
    std::vector<Point> representatives;
  };
  struct Objective {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
    Point vector = Point::Zero();
    Point centre = Point::Zero();  ///< origin of the problem
    double constant = 0;
    double cost(const Point& p) const;
  };

  bool make_collapse_patch(std::int32_t u, std::int32_t v, Patch& patch) const;
  void make_vertex_patch(std::int32_t vertex, Patch& patch) const;
  bool make_split_patch(std::int32_t u, std::int32_t v, Patch& patch) const;
  std::optional<VertexPlacement> plan_inward(const Patch& patch, double reach);
  Objective objective(const Patch& patch, double quadric_weight) const;
  std::optional<Point> place(const Patch& patch, const Eigen::Matrix3d& a, const Point& b, const Point& centre);
  bool acceptable(const Patch& patch, const Point& p) const;
  bool well_shaped(const Patch& patch, const Point& p) const;
  bool cones_hold(const Patch& patch, const Point& p) const;
  bool clear_of_itself(const Patch& patch, const Point& p) const;
  bool keeps_representatives(const Patch& patch, const Point& p) const;
  Corners corners(std::int32_t t) const {
    return {position_[triangle_[t][0]], position_[triangle_[t][1]], position_[triangle_[t][2]]};
  }
  void rebuild_tree();
  void update_box(std::int32_t t);

  const Obstacle& obstacle_;
  EditorOptions options_;
  std::vector<Point> position_;
  std::vector<std::array<std::int32_t, 3>> triangle_;  ///< first corner -1: removed
  std::vector<std::vector<std::int32_t>> incident_;    ///< triangles of each vertex
  std::int64_t face_count_ = 0;
  TriangleTree tree_;
  std::int64_t built_for_ = 0;
  std::size_t used_ = 0;  ///< of triangle_; those behind are spare, for splits
  std::int64_t edits_ = 0;
  double rounding_ = 0;  ///< error of rounding a vertex to float32
  mutable Scratch scratch_;
  mutable std::vector<std::int32_t> mark_;
  mutable std::int32_t stamp_ = 0;
};

}  // namespace encage::makers

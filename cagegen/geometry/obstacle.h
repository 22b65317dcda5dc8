// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/geometry/separation.h"
#include "cagegen/geometry/triangle_tree.h"

#include <encage/mesh.h>

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace encage::makers {

/// Accepts boxes that may meet a set of half-spaces and a box; for TriangleTree::traverse. Works in float with slack
/// for its own rounding: it only prunes.
class BoxFilter {
 public:
  /// `magnitude` bounds the coordinates of all boxes that will be tested.
  BoxFilter(const Eigen::AlignedBox3d& box, double magnitude);

  /// Keep boxes with a point where normal . x <= offset.
  void below(const Point& normal, double offset);
  /// Replaces the half-space added as number `index`.
  void set_below(int index, const Point& normal, double offset);

  Mask4 operator()(const Float4 (&low)[3], const Float4 (&high)[3]) const;
  /// How deep boxes reach into the half-space added first.
  Float4 depth(const Float4 (&low)[3], const Float4 (&high)[3]) const;

 private:
  struct Plane {
    float normal[3];
    float reach[3];  ///< |normal| / 2
    float offset;

    Float4 least(const Float4 (&sum)[3], const Float4 (&size)[3]) const;
  };
  float low_[3];
  float high_[3];
  double slack_;
  int count_ = 0;
  Plane planes_[5];
};

/// The part of space over a triangle: its plane and the three planes through its edges along the normal.
struct Prism {
  Corners corner;
  Point normal;        ///< unit
  Point side[3];       ///< unit, outward, through the edge corner[k] -> corner[k+1]
  bool valid = false;  ///< the triangle is not degenerate

  explicit Prism(const Corners& corners);
  double height(const Point& x) const { return normal.dot(x - corner[0]); }
};

/// What a cage must not touch: triangles with a tree, and one point of each component.
class Obstacle {
 public:
  explicit Obstacle(const TriangleMesh& mesh);

  /// Moves the mesh's vertices; triangles keep their numbers, and the trees their shape.
  void move(const Vertices& vertices);

  /// The largest coordinate, by amount.
  double magnitude() const { return magnitude_; }
  /// Triangles are numbered in the order of the tree's leaves.
  const Corners& corners(std::int32_t triangle) const { return corners_[triangle]; }
  std::size_t size() const { return corners_.size(); }

  /// Appends the obstacle triangles not proven farther than `clearance` from the prism's triangle, at most `limit` in
  /// all, in no useful but a fixed order.
  void hits(const Prism& prism, double clearance, std::size_t limit, std::vector<std::int32_t>& found) const;
  /// The same, those that reach highest over the triangle first, as far as boxes tell.
  void highest_hits(const Prism& prism, double clearance, std::size_t limit, std::vector<std::int32_t>& found) const;
  /// Boxes that may come within `clearance` of the prism's triangle; an invalid prism's are all those near its box.
  /// `magnitude` bounds the coordinates of boxes other than the obstacle's.
  BoxFilter near(const Prism& prism, double clearance, double magnitude = 0) const;
  bool hit(const Prism& prism, double clearance) const;

  /// How far the plane of the prism's triangle must turn about its edge corner[1] -> corner[2] so that the obstacle in
  /// the prism, lifted by `lift` and up to `ceiling` above the triangle, lies under it: the largest height / distance
  /// from the edge, at least `slope`.
  double steepest(const Prism& prism, double lift, double ceiling, double slope) const;
  /// The same for one obstacle triangle.
  static double steepest(const Prism& prism, const Corners& t, double lift, double ceiling, double slope);

  /// Height above the prism's triangle of the highest corner of the obstacle over it, at most `ceiling` (higher ones
  /// belong to other parts) and at least `height`.
  double highest(const Prism& prism, double ceiling, double height) const;

  /// Points, one a component.
  const std::vector<Point>& representatives() const { return representative_; }
  /// Those within a box.
  void representatives(const Eigen::AlignedBox3d& box, std::vector<Point>& found) const;

  /// Number of triangles tested so far by this thread's queries: the unit of work budgets.
  static std::uint64_t& work();

 private:
  void set_vertices(const Vertices& vertices);

  std::vector<std::array<std::int32_t, 3>> triangle_;  ///< vertices
  std::vector<Corners> corners_;
  double magnitude_ = 0;
  TriangleTree tree_;
  std::vector<std::int32_t> representative_vertex_;
  std::vector<Point> representative_;
  TriangleTree representative_tree_;
};

}  // namespace encage::makers

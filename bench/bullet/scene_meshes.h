// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Bodies of the contact scenes: closed, oriented outward, free of self-intersection, the same bytes on every machine.

#include <encage/mesh.h>

#include <Eigen/Core>

#include <vector>

namespace encage::bullet_bench {

/// A ring about z, its centre at 0, of 2 * around * across triangles.
struct Torus {
  double ring_radius = 0.24;  ///< from the centre to the middle of the tube
  double tube_radius = 0.07;
  int around = 50, across = 20;
};
TriangleMesh make_torus(const Torus& torus = {});

/// A bowl of even thickness about z with a flat foot at z = 0, a parabolic wall and a rounded rim. The wall is steeper
/// than the floor and hence thicker along z, so that bowls of a stack rest on each other's walls just below the rims.
struct Bowl {
  double radius = 0.55;  ///< of the outer surface at the rim
  double foot = 0.2;     ///< radius of the foot
  double depth = 0.25;   ///< height of the outer surface at the rim
  double thickness = 0.06;
  int around = 50, along = 22, rim = 7;  ///< 2 * around * (2 * along + rim - 1) triangles: 5,000
};
TriangleMesh make_bowl(const Bowl& bowl = {});

/// A right-handed single-start thread about z: in a cut through the axis a trapezoid, crest and root a quarter of the
/// pitch wide each.
struct Thread {
  double pitch = 0.2;
  double root_radius = 0.24, crest_radius = 0.3;  ///< of the bolt
  double clearance = 0.0045;                      ///< by which the nut's radii are larger
};

/// A threaded rod from z = 0 to z = turns * pitch; the thread runs out within half a pitch of both ends.
TriangleMesh make_bolt(const Thread& thread, int turns, int around, int rows_per_pitch);

/// A hexagonal nut from z = 0 to z = half_turns * pitch / 2, in whose middle the bolt's thread fits in the same
/// orientation. `flat_radius`: distance of the flats from the axis.
TriangleMesh make_nut(const Thread& thread, int half_turns, int around, int rows_per_pitch, double flat_radius);

/// A bottle crate, its lowest point at z = 0: a box open at the top, whose floor and dividers form cells, with a grip
/// hole through each of two walls. Its foot is narrower than the opening and enters that of the crate below, whose rim
/// carries it. Sides are those of the outer box.
struct Crate {
  double length = 0.8, width = 0.6, height = 0.5;  ///< along x, y and z, the foot included
  double wall = 0.04, floor = 0.03, divider = 0.02;
  double foot = 0.04;       ///< height of the foot
  double clearance = 0.01;  ///< between the foot and the opening, on each side
  int cells_x = 4, cells_y = 3;
  double divider_top = 0.35;

  double pitch() const { return height - foot; }  ///< from a crate to the one on top
};
TriangleMesh make_crate(const Crate& crate = {});

/// Adds the faces of grids to a mesh.
class MeshBuilder {
 public:
  std::int32_t add_vertex(const Eigen::Vector3d& p);
  void add_triangle(std::int32_t a, std::int32_t b, std::int32_t c);
  void add_quad(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d);
  /// Equal vertices become one, triangles that then have two equal corners are left out.
  TriangleMesh mesh() const;

 private:
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<Eigen::Vector3i> triangles_;
};

}  // namespace encage::bullet_bench

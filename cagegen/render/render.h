// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/render/png.h"

#include <encage/mesh.h>

#include <optional>
#include <span>

namespace encage::render {

/// Red, green, blue in [0,1], as displayed.
using Color = Eigen::Vector3f;

enum class Style {
  solid,        ///< opaque, shaded
  translucent,  ///< the surface nearest to the eye tints what is behind it
  section,      ///< drawn in the plane of the cut only
};

struct Item {
  const TriangleMesh* mesh = nullptr;  ///< owned by the caller; may be open or not a manifold
  Color color = {0.8F, 0.8F, 0.8F};
  Style style = Style::solid;
  /// Draw triangle edges; they fade where triangles are only few pixels wide.
  bool edges = false;
  /// Interpolate normals, except across creases of more than 40 degrees.
  bool smooth = true;
};

enum class Axis { x = 0, y = 1, z = 2 };

/// Where to look from. The distance is chosen so that everything visible fits at zoom 1.
struct Camera {
  double azimuth =
      35;  ///< degrees about `up`; 0 looks along +y if z is up (along -z if y is up), positive: eye moves to the right
  double elevation = 20;  ///< degrees above the horizon, in [-90, 90]
  double zoom = 1;        ///< > 0; magnifies about the middle of the picture
  Axis up = Axis::z;
  std::optional<Eigen::Vector3d> focus;  ///< point shown in the middle of the picture
};

/// Only what lies beyond this plane, seen from the eye, is drawn. In the plane itself, each mesh is drawn as a contour;
/// where it is closed, its inside is tinted.
struct Cut {
  Axis axis = Axis::x;
  double offset = 0;
};

struct Options {
  int width = 1200;  ///< pixels, 16 to 8192
  int height = 900;
  std::optional<Camera> camera;  ///< unset: three-quarter view, or along the axis of the cut
  Axis up = Axis::z;             ///< of the automatic camera
  std::optional<Cut> cut;
};

/// Renders with four samples a pixel on white. Items are listed from the inside out (fine to coarse): finer ones are
/// drawn over coarser ones in a section. Uses all threads; the picture does not depend on their number. Throws Error
/// for a bad size, zoom or elevation, nothing to draw, a cut outside the bounds of the meshes, or an eye in the plane
/// of the cut.
Image render(std::span<const Item> items, const Options& options);

}  // namespace encage::render

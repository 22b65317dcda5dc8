// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/render/camera.h"

#include <cstdint>
#include <vector>

namespace encage::render {

struct Segment {
  Eigen::Vector3d start, end;
};

/// Where the plane x[axis] = offset meets a mesh. Vertices in the plane count as above it, so that the section of a
/// closed mesh is closed.
std::vector<Segment> slice(const TriangleMesh& mesh, const Cut& cut);

/// A section drawn in pixels.
class Section {
 public:
  /// `fill`: whether the segments bound a region. `samples` sub-samples a pixel in x and in y.
  Section(const std::vector<Segment>& segments, bool fill, const View& view, int width, int height, int samples);

  /// Whether sub-sample (x,y) of the finer grid lies inside (non-zero winding).
  bool inside(int x, int y) const { return inside_[static_cast<std::size_t>(y) * sample_width_ + x] != 0; }
  /// How much of pixel (x,y) the contour covers, in [0,1].
  float contour(int x, int y) const { return contour_[static_cast<std::size_t>(y) * width_ + x]; }

 private:
  struct Line {
    Eigen::Vector2d start, end;
  };
  void fill_inside(const std::vector<Line>& lines, int height, int samples);
  void draw_line(const Line& line, int height);

  int width_ = 0;
  int sample_width_ = 0;
  std::vector<std::uint8_t> inside_;
  std::vector<float> contour_;
};

}  // namespace encage::render

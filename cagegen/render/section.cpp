// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/render/section.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace encage::render {
namespace {

constexpr double half_line = 1.0;  // half the width of a contour, in pixels

double distance_to_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d d = b - a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(d) / length2, 0.0, 1.0) : 0;
  return (p - a - t * d).norm();
}

}  // namespace

std::vector<Segment> slice(const TriangleMesh& mesh, const Cut& cut) {
  const int axis = static_cast<int>(cut.axis);
  const auto height = [&](std::int32_t v) { return mesh.vertices(v, axis) - cut.offset; };
  // From the lower index to the higher: both triangles of an edge get the same point.
  const auto crossing = [&](std::int32_t a, std::int32_t b) -> Eigen::Vector3d {
    if (b < a) std::swap(a, b);
    const double t = height(a) / (height(a) - height(b));
    Eigen::Vector3d p = mesh.vertex(a) + t * (mesh.vertex(b) - mesh.vertex(a));
    p[axis] = cut.offset;
    return p;
  };
  std::vector<Segment> segments;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    Segment segment;
    int found = 0;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = mesh.triangles(t, k), b = mesh.triangles(t, (k + 1) % 3);
      const bool above_a = height(a) >= 0, above_b = height(b) >= 0;
      if (above_a == above_b) continue;
      (above_a ? segment.start : segment.end) = crossing(a, b);
      ++found;
    }
    if (found == 2) segments.push_back(segment);
  }
  return segments;
}

Section::Section(const std::vector<Segment>& segments, bool fill, const View& view, int width, int height, int samples)
    : width_(width),
      sample_width_(width * samples),
      inside_(static_cast<std::size_t>(width) * samples * height * samples),
      contour_(static_cast<std::size_t>(width) * height) {
  std::vector<Line> lines;
  lines.reserve(segments.size());
  for (const Segment& s : segments) lines.push_back({view.project(s.start), view.project(s.end)});
  if (fill) fill_inside(lines, height, samples);
  for (const Line& line : lines) draw_line(line, height);
}

void Section::fill_inside(const std::vector<Line>& lines, int height, int samples) {
  struct Crossing {
    double x;
    int winding;
  };
  std::vector<std::vector<Crossing>> rows(static_cast<std::size_t>(height) * samples);
  const double row_count = static_cast<double>(rows.size());
  for (const Line& line : lines) {
    const double y0 = line.start.y() * samples - 0.5, y1 = line.end.y() * samples - 0.5;
    const int winding = y0 < y1 ? 1 : -1;
    const double first = std::ceil(std::clamp(std::min(y0, y1), 0.0, row_count));
    const double last = std::ceil(std::clamp(std::max(y0, y1), 0.0, row_count));
    for (double y = first; y < last; ++y) {
      const double t = (y - y0) / (y1 - y0);
      const double x = (line.start.x() + t * (line.end.x() - line.start.x())) * samples - 0.5;
      rows[static_cast<std::size_t>(y)].push_back({x, winding});
    }
  }
  for (std::size_t y = 0; y < rows.size(); ++y) {
    std::sort(rows[y].begin(), rows[y].end(), [](const Crossing& a, const Crossing& b) {
      return std::pair(a.x, a.winding) < std::pair(b.x, b.winding);
    });
    int winding = 0;
    for (std::size_t i = 0; i + 1 < rows[y].size(); ++i) {
      winding += rows[y][i].winding;
      if (winding == 0) continue;
      const int first = static_cast<int>(std::ceil(std::clamp(rows[y][i].x, 0.0, 1.0 * sample_width_)));
      const int last = static_cast<int>(std::ceil(std::clamp(rows[y][i + 1].x, 0.0, 1.0 * sample_width_)));
      std::fill(inside_.begin() + static_cast<std::ptrdiff_t>(y) * sample_width_ + first,
                inside_.begin() + static_cast<std::ptrdiff_t>(y) * sample_width_ + last, std::uint8_t{1});
    }
  }
}

void Section::draw_line(const Line& line, int height) {
  const double reach = half_line + 1;
  const Eigen::Vector2d low = line.start.cwiseMin(line.end), high = line.start.cwiseMax(line.end);
  const int x0 = static_cast<int>(std::clamp(low.x() - reach, 0.0, 1.0 * width_));
  const int x1 = static_cast<int>(std::clamp(high.x() + reach, 0.0, 1.0 * width_));
  const int y0 = static_cast<int>(std::clamp(low.y() - reach, 0.0, 1.0 * height));
  const int y1 = static_cast<int>(std::clamp(high.y() + reach, 0.0, 1.0 * height));
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const double d = distance_to_segment({x + 0.5, y + 0.5}, line.start, line.end);
      float& coverage = contour_[static_cast<std::size_t>(y) * width_ + x];
      coverage = std::max(coverage, static_cast<float>(std::clamp(half_line + 0.5 - d, 0.0, 1.0)));
    }
  }
}

}  // namespace encage::render

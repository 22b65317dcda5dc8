// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/scene_meshes.h"
#include "src/mesh/portable_trig.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace encage::bullet_bench {
namespace {

/// Rows of vertices along helices, so that crests and roots are edges of the mesh and every turn is like the others.
/// Rows that leave the range of heights end on its edge.
class ThreadSurface {
 public:
  /// At the ends the radius is `end_radius`; `clearance` is added to the thread's.
  ThreadSurface(const Thread& thread, double length, int around, int rows, double clearance, double end_radius)
      : thread_(thread),
        length_(length),
        around_(around),
        rows_(rows),
        clearance_(clearance),
        end_radius_(end_radius) {}

  /// Outward, or towards the axis for a bore.
  void add_to(MeshBuilder& builder, bool towards_axis) const {
    const int last = static_cast<int>(std::ceil(length_ / thread_.pitch)) * rows_;
    for (int i = 0; i < around_; ++i) {
      for (int j = -rows_; j < last; ++j) {
        const std::int32_t a = builder.add_vertex(point(i, j)), b = builder.add_vertex(point(i + 1, j)),
                           c = builder.add_vertex(point(i + 1, j + 1)), d = builder.add_vertex(point(i, j + 1));
        towards_axis ? builder.add_quad(a, d, c, b) : builder.add_quad(a, b, c, d);
      }
    }
  }

 private:
  /// Column `around_` is column 0, one pitch further.
  Eigen::Vector3d point(int i, int j) const {
    const double turns = static_cast<double>(j * around_ + i * rows_) / (around_ * rows_);
    const double height = std::clamp(turns * thread_.pitch, 0.0, length_);
    const double full = std::min(1.0, std::min(height, length_ - height) / (thread_.pitch / 2));
    const double share = static_cast<double>((j + rows_) % rows_) / rows_;
    const double rise = std::clamp(share < 0.625 ? 4 * share - 1 : 4 - 4 * share, 0.0, 1.0);
    const double thread = thread_.root_radius + rise * (thread_.crest_radius - thread_.root_radius) + clearance_;
    const double radius = end_radius_ + full * (thread - end_radius_);
    const SinCos turn = sincos_turns(static_cast<double>(i) / around_);
    return {radius * turn.cos, radius * turn.sin, height};
  }

  const Thread& thread_;
  double length_;
  int around_, rows_;
  double clearance_, end_radius_;
};

/// Calls edge(i's turn, the next one's) around a circle.
template <class Edge>
void around_circle(int around, const Edge& edge) {
  for (int i = 0; i < around; ++i) {
    edge(static_cast<double>(i) / around, static_cast<double>(i + 1) / around);
  }
}

Eigen::Vector3d on_circle(double turns, double radius, double height) {
  const SinCos turn = sincos_turns(turns);
  return {radius * turn.cos, radius * turn.sin, height};
}

/// On a hexagon with flats at this distance from the axis.
Eigen::Vector3d on_hexagon(double turns, double flat_radius, double height) {
  const double from_flat = turns - std::floor(6 * turns + 0.5) / 6;
  return on_circle(turns, flat_radius / sincos_turns(from_flat).cos, height);
}

}  // namespace

TriangleMesh make_bolt(const Thread& thread, int turns, int around, int rows_per_pitch) {
  const double length = turns * thread.pitch;
  MeshBuilder builder;
  ThreadSurface(thread, length, around, rows_per_pitch, 0, thread.root_radius).add_to(builder, false);
  const std::int32_t bottom = builder.add_vertex({0, 0, 0}), top = builder.add_vertex({0, 0, length});
  around_circle(around, [&](double from, double to) {
    const auto add = [&](double turn, double height) {
      return builder.add_vertex(on_circle(turn, thread.root_radius, height));
    };
    builder.add_triangle(bottom, add(to, 0), add(from, 0));
    builder.add_triangle(top, add(from, length), add(to, length));
  });
  return builder.mesh();
}

TriangleMesh make_nut(const Thread& thread, int half_turns, int around, int rows_per_pitch, double flat_radius) {
  const double length = half_turns * thread.pitch / 2, opening = thread.crest_radius + thread.clearance;
  MeshBuilder builder;
  ThreadSurface(thread, length, around, rows_per_pitch, thread.clearance, opening).add_to(builder, true);
  around_circle(around, [&](double from, double to) {
    const auto inner = [&](double turn, double height) { return builder.add_vertex(on_circle(turn, opening, height)); };
    const auto outer = [&](double turn, double height) {
      return builder.add_vertex(on_hexagon(turn, flat_radius, height));
    };
    builder.add_quad(inner(from, 0), inner(to, 0), outer(to, 0), outer(from, 0));
    builder.add_quad(inner(from, length), outer(from, length), outer(to, length), inner(to, length));
    builder.add_quad(outer(from, 0), outer(to, 0), outer(to, length), outer(from, length));
  });
  return builder.mesh();
}

}  // namespace encage::bullet_bench

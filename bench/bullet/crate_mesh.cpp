// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/scene_meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace encage::bullet_bench {
namespace {

constexpr double grip_half_width = 0.1, grip_bottom = 0.39, grip_top = 0.45;

/// Which points of the box are material. It changes at the lines only.
class CrateSolid {
 public:
  explicit CrateSolid(const Crate& crate) : crate_(crate), outer_{crate.length / 2, crate.width / 2} {
    const std::array<int, 2> cells = {crate.cells_x, crate.cells_y};
    for (int axis = 0; axis < 2; ++axis) {
      const double inner = outer_[axis] - crate.wall;
      for (const double x : {outer_[axis], inner, inner - crate.clearance}) {
        lines[axis].push_back(x);
        lines[axis].push_back(-x);
      }
      for (int k = 1; k < cells[axis]; ++k) {
        const double middle = 2 * inner * k / cells[axis] - inner;
        dividers_[axis].push_back(middle);
        for (const double side : {-0.5, 0.5}) lines[axis].push_back(middle + side * crate.divider);
      }
    }
    lines[1].insert(lines[1].end(), {-grip_half_width, grip_half_width});
    lines[2] = {0, crate.foot, crate.foot + crate.floor, crate.divider_top, grip_bottom, grip_top, crate.height};
    for (std::vector<double>& line : lines) {
      std::sort(line.begin(), line.end());
      line.erase(std::unique(line.begin(), line.end()), line.end());
    }
  }

  bool holds(const Eigen::Vector3d& p) const {
    const std::array<double, 2> far = {std::abs(p.x()), std::abs(p.y())};
    if (far[0] > outer_[0] || far[1] > outer_[1] || p.z() < 0 || p.z() > crate_.height) return false;
    const auto within = [&](double inset) { return far[0] < outer_[0] - inset && far[1] < outer_[1] - inset; };
    if (p.z() < crate_.foot) return within(crate_.wall + crate_.clearance);
    if (p.z() < crate_.foot + crate_.floor) return true;
    if (!within(crate_.wall)) {
      const bool long_wall = far[0] < outer_[0] - crate_.wall;
      return long_wall || far[1] > grip_half_width || p.z() < grip_bottom || p.z() > grip_top;
    }
    return p.z() < crate_.divider_top && (in_divider(p.x(), 0) || in_divider(p.y(), 1));
  }

  std::array<std::vector<double>, 3> lines;

 private:
  bool in_divider(double x, int axis) const {
    return std::any_of(dividers_[axis].begin(), dividers_[axis].end(),
                       [&](double middle) { return std::abs(x - middle) < crate_.divider / 2; });
  }

  const Crate& crate_;
  std::array<double, 2> outer_;
  std::array<std::vector<double>, 2> dividers_;
};

}  // namespace

TriangleMesh make_crate(const Crate& crate) {
  const CrateSolid solid(crate);
  const auto& lines = solid.lines;
  using Cell = std::array<int, 3>;
  const auto filled = [&](const Cell& cell) {
    Eigen::Vector3d middle;
    for (int k = 0; k < 3; ++k) {
      if (cell[k] < 0 || cell[k] + 1 >= static_cast<int>(lines[k].size())) return false;
      middle[k] = (lines[k][cell[k]] + lines[k][cell[k] + 1]) / 2;
    }
    return solid.holds(middle);
  };
  MeshBuilder builder;
  // The side of a cell across `axis`, seen from outside counter-clockwise.
  const auto add_side = [&](const Cell& cell, int axis, bool upper) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto corner = [&](int du, int dv) {
      Eigen::Vector3d p;
      p[axis] = lines[axis][cell[axis] + (upper ? 1 : 0)];
      p[u] = lines[u][cell[u] + du];
      p[v] = lines[v][cell[v] + dv];
      return builder.add_vertex(p);
    };
    const std::int32_t a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
    upper ? builder.add_quad(a, b, c, d) : builder.add_quad(a, d, c, b);
  };
  for (int x = 0; x + 1 < static_cast<int>(lines[0].size()); ++x) {
    for (int y = 0; y + 1 < static_cast<int>(lines[1].size()); ++y) {
      for (int z = 0; z + 1 < static_cast<int>(lines[2].size()); ++z) {
        const Cell cell = {x, y, z};
        if (!filled(cell)) continue;
        for (int axis = 0; axis < 3; ++axis) {
          for (const bool upper : {false, true}) {
            Cell next = cell;
            next[axis] += upper ? 1 : -1;
            if (!filled(next)) add_side(cell, axis, upper);
          }
        }
      }
    }
  }
  return builder.mesh();
}

}  // namespace encage::bullet_bench

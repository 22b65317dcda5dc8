// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/handmade/shapes.h"

#include "bench/suite/handmade/solid_mesh.h"
#include "src/mesh/portable_trig.h"

#include <Eigen/Geometry>

#include <cmath>
#include <cstdint>

namespace encage::handmade {
namespace {

using Point2 = Eigen::Vector2d;

/// What a person leaves between cage and shape: a millimetre on a metre.
constexpr double gap = 1e-3;
/// Edges of the inputs are at most so long.
constexpr double edge = 0.12;

constexpr const char* one_surface = "one surface";
constexpr const char* boxes = "overlapping boxes";

Point2 direction(double turn) {
  const SinCos d = sincos_turns(turn);
  return {d.cos, d.sin};
}

TriangleMesh turned(TriangleMesh mesh, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& move) {
  mesh.vertices = (mesh.vertices * rotation.transpose()).eval();
  mesh.vertices.rowwise() += move.transpose();
  return mesh;
}

TriangleMesh refined_boxes(const std::vector<TriangleMesh>& parts) { return refined(together(parts), edge); }

/// Three compartments, a back, and two doors that stand open; z points to the front.
Subject cabinet() {
  constexpr double width = 0.8, height = 1, depth = 0.4, wall = 0.02, door = 0.016, reach = 0.3;
  std::vector<TriangleMesh> parts = {
      box({0, 0, 0}, {wall, height, depth}),
      box({width - wall, 0, 0}, {width, height, depth}),
      box({0, 0, 0}, {width, height, wall}),  // the back
      box({0.002, 0, depth}, {0.002 + door, height, depth + reach}),
      box({width - 0.002 - door, 0, depth}, {width - 0.002, height, depth + reach}),
  };
  const double boards[] = {0, 0.3, 0.65, height - wall};
  for (const double y : boards) parts.push_back(box({0, y, 0}, {width, y + wall, depth}));
  // Doors meet the carcass: the cage has them as legs on its front.
  std::vector<Recess> recesses;
  for (int i = 0; i < 3; ++i) {
    recesses.push_back(
        {rectangle(wall + gap, boards[i] + wall + gap, width - wall - gap, boards[i + 1] - gap), wall + gap});
  }
  for (const double x : {0.002, width - 0.002 - door}) {
    recesses.push_back({rectangle(x - gap, -gap / 2, x + door + gap, height + gap / 2), depth + reach + gap});
  }
  return {"cabinet", boxes, refined_boxes(parts),
          plate(rectangle(-gap, -gap, width + gap, height + gap), -gap, depth + gap, recesses)};
}

/// Five boards on side walls, open to the front and to the back.
Subject shelf() {
  constexpr double width = 0.8, height = 1.2, depth = 0.3, wall = 0.02;
  std::vector<TriangleMesh> parts = {box({0, 0, 0}, {wall, height, depth}),
                                     box({width - wall, 0, 0}, {width, height, depth})};
  const double boards[] = {0.001, 0.295, 0.59, 0.885, height - wall - 0.001};
  for (const double y : boards) parts.push_back(box({0.005, y, 0.002}, {width - 0.005, y + wall, depth - 0.002}));
  std::vector<Recess> holes;
  for (int i = 0; i < 4; ++i) {
    holes.push_back({rectangle(wall + gap, boards[i] + wall + gap, width - wall - gap, boards[i + 1] - gap), -gap});
  }
  return {"shelf", boxes, refined_boxes(parts),
          plate(rectangle(-gap, -gap, width + gap, height + gap), -gap, depth + gap, holes)};
}

/// Six arms with two pairs of branches each.
Subject snow_flake() {
  constexpr double half = 0.018, thickness = 0.03;
  Loop outline, around;
  for (int arm = 0; arm < 6; ++arm) {
    const double turn = arm / 6.0;
    const Point2 along = direction(turn), across = direction(turn + 0.25);
    const auto at = [&](double x, double y) { return Point2(x * along + y * across); };
    const Point2 up = direction(turn + 1 / 6.0), down = direction(turn - 1 / 6.0);
    const Point2 up_normal = direction(turn + 1 / 6.0 + 0.25), down_normal = direction(turn - 1 / 6.0 + 0.25);
    // Along the lower side to the tip, and back along the upper one.
    const double from[] = {0.2, 0.34}, reach[] = {0.14, 0.11};
    constexpr double cosine = 0.5, sine = 0.86602540378443865;
    const auto root = [&](double x, double sign, double side) {  // where the side of a branch leaves that of the arm
      return at(x + side * half / sine + half * cosine / sine, sign * half);
    };
    for (int b = 0; b < 2; ++b) {
      outline.push_back(root(from[b], -1, -1));
      outline.push_back(at(from[b], 0) + reach[b] * down - half * down_normal);
      outline.push_back(at(from[b], 0) + (reach[b] + half / 2) * down);
      outline.push_back(at(from[b], 0) + reach[b] * down + half * down_normal);
      outline.push_back(root(from[b], -1, 1));
    }
    outline.push_back(at(0.48, -half));
    outline.push_back(at(0.5, 0));
    outline.push_back(at(0.48, half));
    for (int b = 1; b >= 0; --b) {
      outline.push_back(root(from[b], 1, 1));
      outline.push_back(at(from[b], 0) + reach[b] * up - half * up_normal);
      outline.push_back(at(from[b], 0) + (reach[b] + half / 2) * up);
      outline.push_back(at(from[b], 0) + reach[b] * up + half * up_normal);
      outline.push_back(root(from[b], 1, -1));
    }
    outline.emplace_back(2 * half * direction(turn + 1 / 12.0));
    // An arrow head around the branches, with a notch between the arms.
    around.push_back(at(0.33, -0.18));
    around.push_back(at(0.535, 0));
    around.push_back(at(0.33, 0.18));
    around.push_back(direction(turn + 1 / 12.0) * 0.05);
  }
  return {"snow flake", one_surface, refined(plate(outline, 0, thickness), edge / 2),
          plate(around, -gap, thickness + gap)};
}

/// A tube around a square with round corners, in the plane z = 0.
TriangleMesh link(double half, double radius, double corner) {
  Loop path, out;
  constexpr int steps = 6, sides = 10;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const Point2 centre = (half - corner) * (direction(quarter / 4.0) + direction((quarter + 1) / 4.0));
    for (int i = 0; i <= steps; ++i) {
      out.push_back(direction((quarter + i / static_cast<double>(steps)) / 4));
      path.push_back(centre + corner * out.back());
    }
  }
  TriangleMesh mesh;
  const auto count = static_cast<std::int32_t>(path.size());
  mesh.vertices.resize(count * sides, 3);
  mesh.triangles.resize(2 * count * sides, 3);
  for (std::int32_t i = 0; i < count; ++i) {
    for (std::int32_t j = 0; j < sides; ++j) {
      const Point2 round = radius * direction(j / static_cast<double>(sides));
      const Point2 p = path[i] + round.x() * out[i];
      const auto id = [&](std::int32_t a, std::int32_t b) { return a % count * sides + b % sides; };
      mesh.vertices.row(id(i, j)) << p.x(), p.y(), round.y();
      mesh.triangles.row(2 * id(i, j)) << id(i, j), id(i + 1, j), id(i + 1, j + 1);
      mesh.triangles.row(2 * id(i, j) + 1) << id(i, j), id(i + 1, j + 1), id(i, j + 1);
    }
  }
  return mesh;
}

/// Three links, each through the next.
Subject chain() {
  constexpr double half = 0.15, radius = 0.025, corner = 0.05, step = 0.2;
  const double outer = half + radius + gap,
               inner = half - radius - gap - 0.3 * (corner - radius);  // inside of the round corners
  const TriangleMesh ring = plate(rectangle(-outer, -outer, outer, outer), -radius - gap, radius + gap,
                                  {{rectangle(-inner, -inner, inner, inner), -radius - gap}});
  std::vector<TriangleMesh> links, rings;
  for (int i = 0; i < 3; ++i) {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    if (i == 1) rotation << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    const Eigen::Vector3d move(step * i, 0, 0);
    links.push_back(turned(link(half, radius, corner), rotation, move));
    rings.push_back(turned(ring, rotation, move));
  }
  return {"chain", one_surface, refined(together(links), edge), together(rings)};
}

/// Six teeth on a back.
Subject comb() {
  constexpr int teeth = 6;
  constexpr double pitch = 0.16, tooth = 0.08, length = 0.5, back = 0.15, thickness = 0.04;
  Loop outline, around;
  const double right = (teeth - 1) * pitch + tooth;
  outline.insert(outline.end(), {{0, 0.02}, {0.02, 0}, {right - 0.02, 0}, {right, 0.02}});
  around.insert(around.end(), {{-gap, -gap}, {right + gap, -gap}});
  for (int i = teeth - 1; i >= 0; --i) {
    const double x = i * pitch;
    outline.insert(outline.end(), {{x + tooth, back},
                                   {x + tooth, back + length - 0.03},
                                   {x + 0.6 * tooth, back + length},
                                   {x + 0.4 * tooth, back + length},
                                   {x, back + length - 0.03}});
    if (i > 0) outline.emplace_back(x, back);
    around.emplace_back(x + tooth + gap, back + length + gap);
    around.emplace_back(x - gap, back + length + gap);
    if (i > 0) around.insert(around.end(), {{x - gap, back + gap}, {x - pitch + tooth + gap, back + gap}});
  }

  return {"comb", one_surface, refined(plate(outline, 0, thickness), edge / 2), plate(around, -gap, thickness + gap)};
}

/// A plate with rounded corners and four round holes.
Subject holes() {
  constexpr double thickness = 0.03, radius = 0.17, round = 0.05;
  Loop outline;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const Point2 centre =
        Point2(0.5, 0.5) + (0.5 - round) * (direction(quarter / 4.0) + direction((quarter + 1) / 4.0));
    for (int i = 0; i <= 4; ++i) outline.emplace_back(centre + round * direction((quarter + i / 4.0) / 4));
  }
  std::vector<Recess> circles, squares;
  for (int i = 0; i < 4; ++i) {
    const Point2 centre(i & 1 ? 0.73 : 0.27, i & 2 ? 0.73 : 0.27);
    circles.push_back({regular(24, radius, centre), 0});
    squares.push_back({regular(4, radius * 0.98 - gap, centre, 0.125), -gap});
  }
  return {"plate with holes", one_surface, refined(plate(outline, 0, thickness, circles), edge),
          plate(rectangle(-gap, -gap, 1 + gap, 1 + gap), -gap, thickness + gap, squares)};
}

/// Two by three pockets; z points up.
Subject crate() {
  constexpr double width = 0.62, depth = 0.42, height = 0.3, wall = 0.02, pitch = 0.2;
  std::vector<Recess> pockets, cage_pockets;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 2; ++j) {
      const double x = wall + pitch * i, y = wall + pitch * j, side = pitch - wall;
      pockets.push_back({rectangle(x, y, x + side, y + side), wall});
      cage_pockets.push_back({rectangle(x + gap, y + gap, x + side - gap, y + side - gap), wall + gap});
    }
  }
  return {"bottle crate", one_surface, refined(plate(rectangle(0, 0, width, depth), 0, height, pockets), 0.8 * edge),
          plate(rectangle(-gap, -gap, width + gap, depth + gap), -gap, height + gap, cage_pockets)};
}

Subject open_box() {
  constexpr double width = 0.8, depth = 0.5, height = 0.4, wall = 0.01;
  return {"open box", one_surface,
          refined(plate(rectangle(0, 0, width, depth), 0, height,
                        {{rectangle(wall, wall, width - wall, depth - wall), wall}}),
                  0.8 * edge),
          plate(rectangle(-gap, -gap, width + gap, depth + gap), -gap, height + gap,
                {{rectangle(wall + gap, wall + gap, width - wall - gap, depth - wall - gap), wall + gap}})};
}

/// A top, and four legs that reach into it; z points down.
Subject table() {
  constexpr double width = 1, depth = 0.6, top = 0.03, height = 0.7, leg = 0.05, inset = 0.04;
  std::vector<TriangleMesh> parts = {box({0, 0, 0}, {width, depth, top})};
  std::vector<Recess> legs;
  for (const double x : {inset, width - inset - leg}) {
    for (const double y : {inset, depth - inset - leg}) {
      parts.push_back(box({x, y, top / 2}, {x + leg, y + leg, height}));
      legs.push_back({rectangle(x - gap, y - gap, x + leg + gap, y + leg + gap), height + gap});
    }
  }
  return {"table", boxes, refined_boxes(parts),
          plate(rectangle(-gap, -gap, width + gap, depth + gap), -gap, top + gap, legs)};
}

/// A rim, a hub and four spokes.
Subject wheel() {
  constexpr double radius = 0.5, inner = 0.42, hub = 0.1, spoke = 0.02, thickness = 0.06;
  constexpr int steps = 12;
  std::vector<Recess> sectors, kites;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const auto turned_by = [&](const Point2& p) {
      const Point2 x = direction(quarter / 4.0), y = direction(quarter / 4.0 + 0.25);
      return Point2(p.x() * x + p.y() * y);
    };
    const auto arc = [&](double r) {  // between two spokes, from the first to the second
      Loop loop = {{std::sqrt(r * r - spoke * spoke), spoke}};
      for (int i = 1; i < steps; ++i) {
        const Point2 p = r * direction(i / static_cast<double>(steps) / 4);
        if (p.x() > 1.3 * spoke && p.y() > 1.3 * spoke) loop.push_back(p);
      }
      loop.emplace_back(spoke, std::sqrt(r * r - spoke * spoke));
      return loop;
    };
    Loop sector = arc(inner), back = arc(hub);
    sector.insert(sector.end(), back.rbegin(), back.rend());
    for (Point2& p : sector) p = turned_by(p);
    sectors.push_back({sector, 0});
    const double far = 0.405, near = spoke + gap;
    Loop kite = {{far, near}, {0.29, 0.29}, {near, far}, {0.073, 0.073}};
    for (Point2& p : kite) p = turned_by(p);
    kites.push_back({kite, -gap});
  }
  return {"spoked wheel", one_surface,
          refined(plate(regular(48, radius, Point2::Zero()), 0, thickness, sectors), 0.7 * edge),
          plate(regular(8, radius * 1.083 + gap, Point2::Zero()), -gap, thickness + gap, kites)};
}

/// Three hundred leaves of two triangles each on a ball-shaped crown, no two connected.
Subject leaf_cards() {
  std::uint32_t state = 12345;
  const auto random = [&state] {  // in [-1,1)
    state = state * 1664525U + 1013904223U;
    return static_cast<double>(state >> 8) / (1 << 23) - 1;
  };
  std::vector<TriangleMesh> leaves;
  while (leaves.size() < 300) {
    const Eigen::Vector3d centre(random(), random(), random());
    if (centre.norm() > 1 || centre.norm() < 0.3) continue;
    const Eigen::Vector3d u = Eigen::Vector3d(random(), random(), random()).normalized();
    const Eigen::Vector3d v = u.cross(Eigen::Vector3d(random(), random(), random())).normalized();
    TriangleMesh leaf;
    leaf.vertices.resize(4, 3);
    leaf.vertices << (centre - 0.08 * u - 0.04 * v).transpose(), (centre + 0.08 * u - 0.04 * v).transpose(),
        (centre + 0.08 * u + 0.04 * v).transpose(), (centre - 0.08 * u + 0.04 * v).transpose();
    leaf.vertices *= 0.5;
    leaf.triangles.resize(2, 3);
    leaf.triangles << 0, 1, 2, 0, 2, 3;
    leaves.push_back(leaf);
  }
  return {"leaf cards", "quads, no solid", together(leaves), {}};
}

}  // namespace

std::vector<Subject> subjects() {
  return {cabinet(), shelf(),    snow_flake(), chain(), comb(),      holes(),
          crate(),   open_box(), table(),      wheel(), leaf_cards()};
}

}  // namespace encage::handmade

// SPDX-License-Identifier: Apache-2.0
#include "broadphase/shape/compound.h"

#include "broadphase/motion/pose.h"
#include "broadphase/motion/turned_box.h"
#include "broadphase/shape/assemble.h"
#include "src/files/number_text.h"
#include "src/limits.h"

#include <encage/error.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace encage {
namespace {

// Far below the departure from rigid that a pose of the compound may have: the product of both stays usable.
constexpr double most_departure = 1e-12, most_departure_in_nests = 1e-10;

std::string name(std::size_t part) { return "part " + std::to_string(part) + ": "; }

// Messages start with `part`.

void check_scale(double scale, const std::string& part) {
  if (scale >= smallest_scale && scale <= largest_scale) return;
  throw Error(part + "the scale is " + number_text(scale) + ", not between 1e-50 and 1e50");
}

void check_pose(const Eigen::Isometry3d& pose, double departure, const std::string& part, const char* which) {
  if (is_usable(pose) && departure_from_rigid(pose.linear()) <= departure) return;
  if (is_mirrored(pose)) throw Error(part + which + " mirrors it");
  throw Error(part + which + " is not finite, beyond 1e150 or farther than " + number_text(departure) + " from rigid");
}

void check(const CompoundPart& part, std::size_t i) {
  if (!part.shape) throw Error(name(i) + "no shape");
  check_pose(part.pose, most_departure, name(i), "the pose");
  check_scale(part.scale, name(i));
}

/// Checks the part's pose and scale relative to the compound, after all nested compounds around it.
void check(const ShapePart& shape, const std::string& part) {
  check_scale(shape.scale, part);
  check_pose(shape.pose, most_departure_in_nests, part, "the pose in the whole");
  if (!(shape.reach <= largest_length)) {
    throw Error(part + "it reaches " + number_text(shape.reach) + " from the origin, farther than 1e150");
  }
}

/// Returns x -> outer(inner(x)), rounded.
Eigen::Isometry3d placed(const Eigen::Isometry3d& outer, double outer_scale, const Eigen::Isometry3d& inner) {
  Eigen::Isometry3d pose;
  pose.linear() = outer.linear() * inner.linear();
  pose.translation() = outer.linear() * (outer_scale * inner.translation()) + outer.translation();
  pose.makeAffine();
  return pose;
}

/// Builds the tree of the parts: it halves them along the longest extent of the centres of their boxes.
class TreeBuilder {
 public:
  explicit TreeBuilder(CompoundShape& shape) : shape_(shape) {
    for (std::size_t i = 0; i < shape.parts.size(); ++i) order_.push_back(static_cast<std::int32_t>(i));
    shape_.nodes.reserve(2 * order_.size());
    add(order_);
  }

 private:
  std::int32_t add(std::span<std::int32_t> parts) {
    const auto n = static_cast<std::int32_t>(shape_.nodes.size());
    shape_.nodes.emplace_back();
    if (parts.size() == 1) {
      shape_.nodes[n].box = box(parts[0]);
      shape_.nodes[n].part = parts[0];
      return n;
    }
    Eigen::AlignedBox3d all, middles;
    for (const std::int32_t p : parts) {
      all.extend(box(p));
      middles.extend(Eigen::Vector3d(box(p).center()));
    }
    int axis = 0;
    middles.sizes().maxCoeff(&axis);
    const std::size_t half = parts.size() / 2;
    std::nth_element(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(half), parts.end(),
                     [&](std::int32_t x, std::int32_t y) {
                       const double at_x = box(x).center()[axis], at_y = box(y).center()[axis];
                       return at_x != at_y ? at_x < at_y : x < y;
                     });
    const std::int32_t first = add(parts.first(half)), second = add(parts.subspan(half));
    shape_.nodes[n].box = all;
    shape_.nodes[n].children = {first, second};
    return n;
  }

  const Eigen::AlignedBox3d& box(std::int32_t part) const { return shape_.parts[static_cast<std::size_t>(part)].box; }

  CompoundShape& shape_;
  std::vector<std::int32_t> order_;
};

std::int32_t add_count(std::int64_t before, std::size_t more, const char* what) {
  const std::int64_t sum = before + static_cast<std::int64_t>(more);
  if (sum > std::numeric_limits<std::int32_t>::max()) throw Error(std::string("compound: too many ") + what);
  return static_cast<std::int32_t>(sum);
}

/// Adds a simple shape. Its box covers the rounding of placed() for each compound around it.
void add_part(CompoundShape& compound, ShapePart part, const std::string& name, std::int32_t& triangles,
              std::int32_t& vertices) {
  check(part, name);
  const Eigen::Vector3d slack = Eigen::Vector3d::Constant(32 * eps * part.nesting * part.reach);
  part.box = world_box(*part.shape, Motion::resting(part.pose, part.scale));
  part.box = {part.box.min() - slack, part.box.max() + slack};
  assert(part.box.min().allFinite() && part.box.max().allFinite());
  part.first_triangle = triangles;
  part.first_vertex = vertices;
  triangles = add_count(triangles, part.shape->fine_triangles, "triangles");
  vertices = add_count(vertices, part.shape->fine_vertices, "vertices");
  compound.reach = std::max(compound.reach, part.reach);
  compound.has_fine = compound.has_fine && part.shape->has_fine();
  compound.parts.push_back(std::move(part));
}

/// Adds part `i`, or the parts of a nested compound.
void flatten(CompoundShape& compound, const CompoundPart& part, std::size_t i, std::int32_t& triangles,
             std::int32_t& vertices) {
  const double offset = part.pose.translation().norm();
  if (!part.shape->is_compound()) {
    std::shared_ptr<const SimpleShape> shape(part.shape, &part.shape->simple());
    const double reach = offset + part.scale * shape->frame.reach();
    add_part(compound, {std::move(shape), part.pose, part.scale, {}, reach, 0, 0, 0}, name(i), triangles, vertices);
    return;
  }
  const std::vector<ShapePart>& parts = part.shape->compound().parts;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const ShapePart& inner = parts[k];
    add_part(compound,
             {inner.shape,
              placed(part.pose, part.scale, inner.pose),
              part.scale * inner.scale,
              {},
              offset + part.scale * inner.reach,  // also where positions cancel
              inner.nesting + 1,
              0,
              0},
             name(i) + "its " + name(k), triangles, vertices);
  }
}

/// Visits the parts whose boxes are not proven apart from `other`, until a visitor returns false.
template <class Visit>
bool visit_near_parts(const Shape& shape, const Motion& motion, const Eigen::AlignedBox3d& other, double margin,
                      Visit&& visit) {
  if (!shape.is_compound()) return visit(MovingPart{&shape.simple(), motion});
  const CompoundShape& compound = shape.compound();
  std::array<std::int32_t, 66> stack;  // the tree is balanced
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const PartNode& node = compound.nodes[static_cast<std::size_t>(stack[--size])];
    if (boxes_apart(swept_box(node.box, motion), other, margin)) continue;
    if (node.part >= 0) {
      if (!visit(moving_part(compound, static_cast<std::size_t>(node.part), motion))) return false;
    } else {
      stack[size++] = node.children[1];
      stack[size++] = node.children[0];
    }
  }
  return true;
}

}  // namespace

ShapePtr make_compound(std::span<const CompoundPart> parts) {
  if (parts.empty()) throw Error("compound: no parts");
  const auto shape = std::make_shared<CompoundShape>();
  shape->parts.reserve(parts.size());
  std::int32_t triangles = 0, vertices = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    check(parts[i], i);
    flatten(*shape, parts[i], i, triangles, vertices);
  }
  const TreeBuilder tree(*shape);
  return shape;
}

namespace {

/// Returns the map of a part's own frame that becomes `factors` of the compound's frame after the part's pose. It is
/// exact where the pose only exchanges axes or the factors are equal.
Stretch stretch_of_part(const Eigen::Matrix3d& turn, const Eigen::Vector3d& factors) {
  const Eigen::Vector3d sizes = factors.cwiseAbs();
  const double departure = departure_from_rigid(turn);
  Stretch stretch;
  stretch.shortest = sizes.minCoeff() * (1 - 3 * departure);
  stretch.longest = sizes.maxCoeff() * (1 + 3 * departure);
  stretch.mirrors = factors.prod() < 0;
  const bool exchanges_axes = (turn.array() == turn.array().cube()).all();
  if ((factors.array() == factors[0]).all()) {
    stretch.linear = factors.asDiagonal();
  } else {
    stretch.linear = turn.transpose() * factors.asDiagonal() * turn;
    // docs/guarantee.md, "Stretched bodies", derives this bound.
    if (!exchanges_axes) stretch.off = sizes.maxCoeff() * (1.01 * departure + 16 * eps);
  }
  return stretch;
}

}  // namespace

ShapePtr stretched_compound(const CompoundShape& source, const Eigen::Vector3d& factors) {
  struct Made {
    const SimpleShape* of;
    Eigen::Matrix3d linear;
    std::shared_ptr<const SimpleShape> shape;
  };
  std::vector<Made> all;
  const auto result = std::make_shared<CompoundShape>();
  std::int32_t triangles = 0, vertices = 0;
  for (std::size_t i = 0; i < source.parts.size(); ++i) {
    const ShapePart& part = source.parts[i];
    const std::string part_name = "scale: " + name(i);
    const Stretch stretch = stretch_of_part(part.pose.linear(), factors);
    auto made = std::find_if(all.begin(), all.end(), [&](const Made& before) {
      return before.of == part.shape.get() && before.linear == stretch.linear;
    });
    if (made == all.end()) {
      all.push_back({part.shape.get(), stretch.linear, stretched(*part.shape, stretch, part_name)});
      made = std::prev(all.end());
    }
    Eigen::Isometry3d pose = part.pose;
    pose.translation() = factors.cwiseProduct(part.pose.translation());
    // Errors of positions grow with the factors.
    const double reach = std::max(pose.translation().norm() + part.scale * made->shape->frame.reach(),
                                  factors.cwiseAbs().maxCoeff() * part.reach);
    add_part(*result, {made->shape, pose, part.scale, {}, reach, part.nesting + 1, 0, 0}, part_name, triangles,
             vertices);
  }
  const TreeBuilder tree(*result);
  return result;
}

std::int64_t part_count(const Shape& shape) noexcept {
  return shape.is_compound() ? static_cast<std::int64_t>(shape.compound().parts.size()) : 1;
}

int level_count(const Shape& shape) noexcept {
  if (!shape.is_compound()) return static_cast<int>(shape.simple().cages.size());
  int count = 0;
  for (const ShapePart& part : shape.compound().parts) count = std::max(count, level_count(*part.shape));
  return count;
}

std::int64_t level_triangles(const Shape& shape, int level) noexcept {
  if (!shape.is_compound()) return static_cast<std::int64_t>(shape.simple().cages[level].mesh.triangles.size());
  std::int64_t count = 0;
  for (const ShapePart& part : shape.compound().parts) {
    const int levels = level_count(*part.shape);
    if (levels > 0) count += level_triangles(*part.shape, std::min(level, levels - 1));
  }
  return count;
}

PartTriangle part_triangle(const Shape& shape, std::int32_t triangle) noexcept {
  if (!shape.is_compound()) return {0, triangle};
  const CompoundShape& compound = shape.compound();
  const std::size_t part = part_of_triangle(compound, triangle);
  return {static_cast<std::int32_t>(part), triangle - compound.parts[part].first_triangle};
}

std::size_t part_of_triangle(const CompoundShape& compound, std::int32_t triangle) noexcept {
  const auto after = std::upper_bound(compound.parts.begin(), compound.parts.end(), triangle,
                                      [](std::int32_t t, const ShapePart& part) { return t < part.first_triangle; });
  return static_cast<std::size_t>(after - compound.parts.begin()) - 1;
}

MovingPart moving_part(const CompoundShape& compound, std::size_t index, const Motion& motion) noexcept {
  const ShapePart& part = compound.parts[index];
  MovingPart moving;
  moving.shape = part.shape.get();
  moving.motion.start = placed(motion.start, motion.scale, part.pose);
  moving.motion.end = motion.at_rest() ? moving.motion.start : placed(motion.end, motion.scale, part.pose);
  moving.motion.scale = motion.scale * part.scale;
  const double far = std::max(motion.start.translation().norm(), motion.end.translation().norm());
  // docs/guarantee.md, "Compounds", derives this bound.
  moving.slack = 32 * eps * (1 + part.nesting) * (motion.scale * part.reach + far);
  moving.first_triangle = part.first_triangle;
  moving.first_vertex = part.first_vertex;
  return moving;
}

double size_in_world(const Shape& shape, const Motion& motion) noexcept {
  const double reach = shape.is_compound() ? shape.compound().reach : shape.simple().frame.reach();
  return motion.scale * reach + std::max(motion.start.translation().norm(), motion.end.translation().norm());
}

MovingPart near_part(const Shape& shape, const Motion& motion, const Eigen::AlignedBox3d& box) noexcept {
  if (!shape.is_compound()) return MovingPart{&shape.simple(), motion};
  const CompoundShape& compound = shape.compound();
  const auto apart = [&](std::int32_t node) {
    return swept_box(compound.nodes[static_cast<std::size_t>(node)].box, motion).squaredExteriorDistance(box);
  };
  const PartNode* node = compound.nodes.data();
  while (node->part < 0) {
    const auto [first, second] = node->children;
    node = &compound.nodes[static_cast<std::size_t>(apart(second) < apart(first) ? second : first)];
  }
  return moving_part(compound, static_cast<std::size_t>(node->part), motion);
}

bool visit_parts(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b, double margin,
                 VisitParts visit, void* context) {
  return visit_near_parts(a, motion_a, world_box(b, motion_b), margin, [&](const MovingPart& part_a) {
    const Eigen::AlignedBox3d box = world_box(*part_a.shape, part_a.motion);
    return visit_near_parts(b, motion_b, box, margin + part_a.slack,
                            [&](const MovingPart& part_b) { return visit(context, part_a, part_b); });
  });
}

}  // namespace encage

// SPDX-License-Identifier: Apache-2.0
// Changes of a world. A change that is refused leaves the world unchanged.
#include "broadphase/motion/pose.h"
#include "broadphase/shape/shape.h"
#include "broadphase/world/room.h"
#include "broadphase/world/state.h"
#include "src/files/number_text.h"
#include "src/limits.h"

#include <encage/rigid_pose.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace encage {
namespace {

template <WorldId Id>
[[noreturn]] void refuse(Id id, const std::string& reason) {
  throw Error(name(id) + ": " + reason);
}

[[noreturn]] void refuse_pose(BodyId body, const char* which, const std::string& defect) {
  refuse(body, std::string(which) + " " + defect);
}

template <WorldId Id>
void check_length(Id id, const char* what, double length) {
  if (!(length >= 0 && length <= largest_length)) refuse(id, length_defect(what, length));
}

/// True if the body has these poses already.
bool has_motion(const auto& body, const Motion& motion, double deviation) {
  return motion.start.matrix() == body.motion.start.matrix() && motion.end.matrix() == body.motion.end.matrix() &&
         deviation == body.deviation;
}

/// Throws an Error that names `asking` if the table does not contain `asked`.
template <WorldId Id, WorldId Of>
void check_known(const IdTable<Of>& table, Of asked, Id asking) {
  if (!table.contains(asked)) refuse(asking, name(asked) + " " + table.defect(asked));
}

/// Sets an element, or appends it where there is room.
template <class T>
void put(std::vector<T>& v, std::size_t i, T value) {
  if (i == v.size()) {
    v.push_back(std::move(value));
  } else {
    v[i] = std::move(value);
  }
}

template <class T>
void prepare_put(std::vector<T>& v) {
  make_room(v, v.size() + 1);
}

}  // namespace

std::string length_defect(const char* what, double length) {
  const std::string subject = std::string("the ") + what + " " + number_text(length);
  if (std::isnan(length)) return subject + " is not a number";
  if (length < 0) return subject + " is negative";
  return length > largest_length ? subject + " is larger than 1e150" : "";
}

void World::State::check_unlocked() const {
  if (scratch_.searching) throw Error("the world cannot be changed while it visits candidates");
}

World::State::State(const WorldOptions& options) : options_(options) {
  if (const double tolerance = options.pose_tolerance; !(tolerance >= 0 && tolerance <= 0.1)) {
    throw Error("world options: the pose tolerance " + number_text(tolerance) + " is not between 0 and 0.1");
  }
}

// ---- Shapes and half-spaces ----------------------------------------------

ShapeId World::State::add_shape(ShapePtr shape, double margin) {
  check_unlocked();
  const ShapeId id = shape_ids_.next();
  if (!shape) refuse(id, "null");
  check_length(id, "margin", margin);
  const Eigen::AlignedBox3d box = world_box(*shape, Motion::resting(Eigen::Isometry3d::Identity()));
  prepare_put(shapes_);
  shape_ids_.prepare_add();
  put(shapes_, index(id), SharedShape{std::move(shape), box, margin});
  return shape_ids_.add();
}

void World::State::set_shape(ShapeId id, ShapePtr replacement) {
  check_unlocked();
  shape(id);
  if (!replacement) refuse(id, "null");
  SharedShape& known = shapes_[index(id)];
  known.box = world_box(*replacement, Motion::resting(Eigen::Isometry3d::Identity()));
  known.shape = std::move(replacement);
  for (std::uint32_t n = 0; n < body_ids_.slots(); ++n) {
    if (body_ids_.is_used(n) && bodies_[n].shape == id) update(n);
  }
}

void World::State::remove(ShapeId id) {
  check_unlocked();
  if (shape(id).bodies > 0) {
    std::uint32_t user = 0;
    while (!body_ids_.is_used(user) || bodies_[user].shape != id) ++user;
    refuse(id, name(body_ids_.at(user)) + " has it");
  }
  shapes_[index(id)] = {};
  shape_ids_.remove(id);
}

HalfSpaceId World::State::add_half_space(const HalfSpace& half_space, const Filter& filter) {
  check_unlocked();
  const HalfSpaceId id = plane_ids_.next();
  if (!half_space.normal.allFinite()) refuse(id, "the normal is not finite");
  if (const double length = half_space.normal.norm(); !(std::abs(length - 1) <= rigid_tolerance)) {
    refuse(id, "the normal's length is " + number_text(length) + ", not 1");
  }
  if (!(std::abs(half_space.offset) <= largest_length)) {
    refuse(id, "the offset " + number_text(half_space.offset) + " is not finite or beyond 1e150");
  }
  if (plane_ids_.slots() >= half_space_bit / 2) refuse(id, "too many half-spaces");
  prepare_put(planes_);
  prepare_put(outdated_planes_);
  prepare_put(collected_planes_);
  plane_ids_.prepare_add();
  put(planes_, index(id), {half_space, filter, ++clock_});
  put(outdated_planes_, index(id), outdated);
  if (index(id) == collected_planes_.size()) collected_planes_.push_back(HalfSpaceId::none);
  has_outdated_planes_ = has_stirred_ = true;
  return plane_ids_.add();
}

void World::State::remove(HalfSpaceId id) {
  check_unlocked();
  half_space(id);
  plane_ids_.remove(id);
  outdated_planes_[index(id)] = outdated;
  has_outdated_planes_ = true;
}

// ---- Bodies --------------------------------------------------------------

void World::State::check_options(BodyId id, const BodyOptions& options) const {
  check_length(id, "margin", options.margin);
  if (const double scale = options.scale; !(scale >= smallest_scale && scale <= largest_scale)) {
    refuse(id, "the scale " + number_text(scale) + " is not between 1e-50 and 1e50");
  }
  if (!(options.pivot.array().abs() <= largest_length).all()) {
    refuse(id, "the pivot is not finite or beyond 1e150");
  }
}

double World::State::correct(Eigen::Isometry3d& pose, BodyId body, const char* which) const {
  if (is_usable(pose)) return 0;
  const std::string defect = pose_defect(pose);
  if (options_.pose_tolerance == 0) refuse_pose(body, which, defect);
  RigidPose nearest;
  try {
    nearest = nearest_rigid(pose.matrix());
  } catch (const Error&) {
    refuse_pose(body, which, defect);
  }
  if (!(nearest.deviation <= options_.pose_tolerance)) {
    refuse_pose(body, which,
                "deviates by " + number_text(nearest.deviation, 3) + " from a rigid one, more than the tolerance " +
                    number_text(options_.pose_tolerance));
  }
  pose = nearest.pose;
  return nearest.deviation;
}

BodyId World::State::add_body(ShapeId shape, const Eigen::Isometry3d& pose, const BodyOptions& options) {
  check_unlocked();
  const BodyId id = body_ids_.next();
  check_known(shape_ids_, shape, id);
  Eigen::Isometry3d rigid = pose;
  const double deviation = correct(rigid, id, "the pose");
  check_options(id, options);
  if (body_ids_.slots() >= half_space_bit / 2) refuse(id, "too many bodies");

  Body body;
  body.motion = Motion::resting(rigid, options.scale);
  body.deviation = deviation;
  body.options = options;
  body.awake = options.kind != BodyKind::static_;
  body.shape = shape;
  const Bounds bounds{world_box(*shapes_[index(shape)].shape, body.motion), own_margin(body), 0};
  prepare_put(bodies_);
  prepare_put(bounds_);
  prepare_put(traits_);
  prepare_put(outdated_);
  prepare_put(collected_);
  make_room(removed_, bodies_.size() + 1);
  body_ids_.prepare_add();
  body.leaf = tree_.insert(tree_box(bounds), index(id));
  put(bodies_, index(id), body);
  put(bounds_, index(id), bounds);
  put(traits_, index(id), std::uint8_t{0});
  if (index(id) == outdated_.size()) {
    outdated_.push_back(0);
    collected_.push_back(BodyId::none);
  }
  ++shapes_[index(shape)].bodies;
  update(index(id));
  return body_ids_.add();
}

void World::State::remove(BodyId id) {
  check_unlocked();
  --shapes_[index(body(id).shape)].bodies;
  const std::uint32_t n = index(id);
  tree_.remove(bodies_[n].leaf);
  bodies_[n].leaf = -1;
  if ((outdated_[n] & listed_as_removed) == 0) removed_.push_back(n);
  outdated_[n] = outdated | listed_as_removed;
  has_stale_pairs_ = true;
  body_ids_.remove(id);
}

void World::State::set_pose(BodyId id, const Eigen::Isometry3d& pose) {
  check_unlocked();
  body(id);
  Eigen::Isometry3d rigid = pose;
  const double deviation = correct(rigid, id, "the pose");
  move(id, Motion::resting(rigid), deviation);
}

void World::State::set_motion(BodyId id, const Motion& motion) {
  check_unlocked();
  const Body& known = body(id);
  const double scale = known.options.scale;
  if (motion.scale != 1 && motion.scale != scale) {
    refuse(id, "the motion's scale " + number_text(motion.scale) + " is not the body's, " + number_text(scale));
  }
  if (has_motion(known, motion, 0)) return;
  if (is_usable(motion)) return move(id, motion, 0);
  Motion rigid = motion;
  const double at_start = correct(rigid.start, id, "the start pose");
  const double deviation = std::max(at_start, correct(rigid.end, id, "the end pose"));
  if (const std::string defect = motion_defect(rigid); !defect.empty()) refuse(id, defect);
  move(id, rigid, deviation);
}

/// Sets a usable motion.
void World::State::move(BodyId id, const Motion& motion, double deviation) {
  Body& body = bodies_[index(id)];
  if (has_motion(body, motion, deviation)) return;
  if (body.options.kind == BodyKind::static_ && !motion.at_rest()) {
    refuse(id, "a static body cannot move within a step");
  }
  body.motion = {motion.start, motion.end, body.options.scale};
  body.deviation = deviation;
  update(index(id));
}

void World::State::set_shape(BodyId id, ShapeId shape) {
  check_unlocked();
  const ShapeId before = body(id).shape;
  check_known(shape_ids_, shape, id);
  if (shape == before) return;
  --shapes_[index(before)].bodies;
  ++shapes_[index(shape)].bodies;
  bodies_[index(id)].shape = shape;
  update(index(id));
}

void World::State::set_options(BodyId id, const BodyOptions& options) {
  check_unlocked();
  const Body& known = body(id);
  check_options(id, options);
  if (options.kind == BodyKind::static_ && !known.motion.at_rest()) {
    refuse(id, "a body that moves within a step cannot become static");
  }
  if (options == known.options) return;
  Body& body = bodies_[index(id)];
  if (options.kind == BodyKind::static_ || body.options.kind == BodyKind::static_) {
    body.awake = options.kind != BodyKind::static_;
  }
  body.options = options;
  body.motion.scale = options.scale;
  update(index(id));
}

void World::State::set_awake(BodyId id, bool awake) {
  check_unlocked();
  if (body(id).options.kind == BodyKind::static_ || body(id).awake == awake) return;
  const std::uint32_t n = index(id);
  bodies_[n].awake = awake;
  traits_[n] ^= is_awake;
  if (awake) {
    tree_.touch(bodies_[n].leaf);
    outdated_[n] |= outdated;
  } else {
    has_stale_pairs_ = true;
    has_stirred_ = has_stirred_ || bounds_[n].changed_at > searched_at_;
  }
}

void World::State::set_deformation(BodyId id, double bound) {
  check_unlocked();
  const Body& known = body(id);
  check_length(id, "deformation", bound);
  if (bound == known.deformation) return;
  bodies_[index(id)].deformation = bound;
  update(index(id));
}

void World::State::set_user_data(BodyId id, std::uint64_t data) {
  check_unlocked();
  body(id);
  bodies_[index(id)].user_data = data;
}

/// Updates all derived data after a change of the body.
void World::State::update(std::uint32_t n) noexcept {
  const Body& body = bodies_[n];
  bounds_[n].margin = own_margin(body);
  bounds_[n].changed_at = ++clock_;
  const BodyOptions& o = body.options;
  const bool plain = o.kind == BodyKind::dynamic && o.group == 0 && o.filter.category != 0 && ~o.filter.mask == 0;
  traits_[n] = static_cast<std::uint8_t>((body.awake ? is_awake : 0) | (plain ? is_plain : 0) |
                                         (shape_of(body)->is_compound() ? is_compound : 0));
  tree_.touch(body.leaf);
  outdated_[n] |= outdated;
  if (!body.awake) has_stirred_ = true;
}

// ---- Boxes ---------------------------------------------------------------

double World::State::own_margin(const Body& body) const noexcept {
  const SharedShape& shape = shapes_[index(body.shape)];
  double margin = body.options.margin + shape.margin + body.deformation;
  if (body.deviation > 0) margin += correction_margin(*shape.shape, body.deviation, body.options.scale);
  if (options_.arcs) margin += arc_margin(*shape.shape, body.motion, body.options.pivot);
  return margin;
}

FloatBox World::State::tree_box(const Bounds& bounds) const noexcept {
  // The excess covers the rounding of sums of margins.
  return FloatBox::around(bounds.box, bounds.margin * (1 + 1e-12));
}

// ---- Questions -----------------------------------------------------------

const World::State::Body& World::State::body(BodyId id) const {
  if (!body_ids_.contains(id)) refuse(id, body_ids_.defect(id));
  return bodies_[index(id)];
}

BodyCounts World::State::body_counts() const noexcept {
  BodyCounts counts;
  for (std::uint32_t n = 0; n < bodies_.size(); ++n) {
    if (!body_ids_.is_used(n)) continue;
    const Body& body = bodies_[n];
    switch (body.options.kind) {
      case BodyKind::dynamic: ++counts.dynamic; break;
      case BodyKind::kinematic: ++counts.kinematic; break;
      case BodyKind::static_: ++counts.static_; break;
    }
    counts.awake += body.awake ? 1 : 0;
    counts.sensors += body.options.sensor ? 1 : 0;
    counts.corrected += body.deviation > 0 ? 1 : 0;
  }
  return counts;
}

const World::State::SharedShape& World::State::shape(ShapeId id) const {
  if (!shape_ids_.contains(id)) refuse(id, shape_ids_.defect(id));
  return shapes_[index(id)];
}

const World::State::Plane& World::State::half_space(HalfSpaceId id) const {
  if (!plane_ids_.contains(id)) refuse(id, plane_ids_.defect(id));
  return planes_[index(id)];
}

}  // namespace encage

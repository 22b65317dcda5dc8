// SPDX-License-Identifier: Apache-2.0
#include <encage/world.h>

#include "broadphase/body_box.h"
#include "broadphase/frame.h"
#include "broadphase/world_state.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace encage {
namespace {

template <class Id>
std::uint32_t number(Id id) {
  return static_cast<std::uint32_t>(id);
}

// Larger ones could overflow where bounds are added up.
constexpr double largest_length = 1e150;

std::string name(std::size_t body) { return "body " + std::to_string(body) + ": "; }

// Why something is refused, or null: messages are put together only where they are needed.

const char* length_defect(double length) {
  if (!(length >= 0)) return "is negative or not a number";
  return length > largest_length ? "is larger than 1e150" : nullptr;
}

const char* pose_defect(const Eigen::Isometry3d& pose) {
  if (!pose.matrix().topRows<3>().allFinite()) return "is not finite";
  if (pose.translation().cwiseAbs().maxCoeff() > largest_length) return "is farther than 1e150 away";
  return is_usable(pose) ? nullptr : "is farther than 1e-9 from rigid";
}

void check_pose(const Eigen::Isometry3d& pose, std::size_t body, const char* which) {
  if (const char* defect = pose_defect(pose)) throw Error(name(body) + which + " " + defect);
}

/// Room for one more, so that adding it cannot throw.
template <class T>
void make_room(std::vector<T>& v) {
  if (v.size() == v.capacity()) v.reserve(2 * v.size() + 1);
}

Eigen::Vector3d displacement(const Eigen::AlignedBox3d& box, const Motion& motion) {
  const Eigen::Vector3d centre = box.center();
  return motion.end * centre - motion.start * centre;
}

}  // namespace

// ---- Changes -------------------------------------------------------------

void World::State::check_unlocked() const {
  if (searching_) throw Error("the world cannot be changed while it visits candidates");
}

ShapeId World::State::add_shape(ShapePtr shape) {
  check_unlocked();
  if (!shape) throw Error("shape " + std::to_string(shapes_.size()) + ": null");
  const Eigen::AlignedBox3d box = world_box(*shape, Motion::resting(Eigen::Isometry3d::Identity()));
  shapes_.push_back({std::move(shape), box});
  return static_cast<ShapeId>(shapes_.size() - 1);
}

BodyId World::State::add_body(ShapeId shape, const Eigen::Isometry3d& pose, const BodyOptions& options) {
  check_unlocked();
  const std::size_t n = bodies_.size();
  if (number(shape) >= shapes_.size()) {
    throw Error(name(n) + "there is no shape " + std::to_string(number(shape)));
  }
  check_pose(pose, n, "the pose");
  if (const char* defect = length_defect(options.margin)) throw Error(name(n) + "the margin " + defect);
  if (n >= half_space_bit / 2) throw Error(name(n) + "too many bodies");

  Body body;
  body.motion = Motion::resting(pose);
  body.options = options;
  body.shape = shape;
  const Eigen::AlignedBox3d loose = loose_box(shape, body.motion);
  make_room(bodies_);
  make_room(bounds_);
  make_room(outdated_);
  body.leaf = tree_.insert(tree_boxes(shape, body.motion, options, loose).fat, static_cast<std::uint32_t>(n));
  bodies_.push_back(body);
  bounds_.push_back({loose, options.margin, ++clock_});
  outdated_.push_back(1);
  return static_cast<BodyId>(n);
}

HalfSpaceId World::State::add_half_space(const HalfSpace& half_space, const Filter& filter) {
  check_unlocked();
  const std::string who = "half-space " + std::to_string(planes_.size()) + ": ";
  if (!half_space.normal.allFinite()) throw Error(who + "the normal is not finite");
  if (!(std::abs(half_space.normal.norm() - 1) <= 1e-9)) throw Error(who + "the normal's length is not 1");
  if (!(std::abs(half_space.offset) <= largest_length)) throw Error(who + "the offset is not finite");
  planes_.push_back({half_space, filter});
  return static_cast<HalfSpaceId>(planes_.size() - 1);
}

void World::State::remove_body(BodyId id) {
  check_unlocked();
  body(id);
  Body& removed = bodies_[number(id)];
  tree_.remove(removed.leaf);
  removed.leaf = -1;
  outdated_[number(id)] = 1;
  has_stale_pairs_ = true;
}

void World::State::set_pose(BodyId id, const Eigen::Isometry3d& pose) {
  check_unlocked();
  body(id);
  check_pose(pose, number(id), "the pose");
  set_motion(id, Motion::resting(pose, bodies_[number(id)].motion.scale));
}

void World::State::set_motion(BodyId id, const Motion& motion) {
  check_unlocked();
  const Body& known = body(id);
  const std::uint32_t n = number(id);
  if (motion.start.matrix() == known.motion.start.matrix() && motion.end.matrix() == known.motion.end.matrix() &&
      motion.scale == known.motion.scale) {
    return;
  }
  check_pose(motion.start, n, "the start pose");
  check_pose(motion.end, n, "the end pose");
  if (!is_usable(motion)) throw Error(name(n) + "the rotation within the step reaches 180 degrees");
  if (known.options.is_static && !motion.at_rest()) throw Error(name(n) + "a static body cannot move within a step");

  const Eigen::AlignedBox3d loose = loose_box(known.shape, motion);
  const TreeBoxes boxes = tree_boxes(known.shape, motion, known.options, loose);
  if (tree_.update(known.leaf, boxes.tight, boxes.fat)) outdated_[n] = 1;
  bodies_[n].motion = motion;
  bounds_[n].loose = loose;
  bounds_[n].changed_at = ++clock_;
}

Eigen::AlignedBox3d World::State::loose_box(ShapeId shape, const Motion& motion) const {
  const Eigen::AlignedBox3d& box = shapes_[number(shape)].box;
  const Eigen::AlignedBox3d start = turned_box(box, motion.start, motion.scale);
  return motion.at_rest() ? start : start.merged(turned_box(box, motion.end, motion.scale));
}

World::State::TreeBoxes World::State::tree_boxes(ShapeId shape, const Motion& motion, const BodyOptions& options,
                                                 const Eigen::AlignedBox3d& loose) const {
  // The excess hides the rounding of sums of margins.
  const double margin = options.margin * (1 + 1e-12);
  const FloatBox tight = FloatBox::around(loose, margin);
  if (options.is_static) return {tight, tight};
  // A body is expected to go on as it does now.
  constexpr double steps_ahead = 4, slack = 0.1;
  const Eigen::AlignedBox3d& box = shapes_[number(shape)].box;
  const Eigen::Vector3d ahead = steps_ahead * displacement(box, motion);
  Eigen::AlignedBox3d predicted = loose;
  predicted.extend(loose.min() + ahead).extend(loose.max() + ahead);
  return {tight, FloatBox::around(predicted, margin + slack * box.sizes().mean())};
}

// ---- Questions -----------------------------------------------------------

bool World::State::contains(BodyId id) const noexcept {
  return number(id) < bodies_.size() && bodies_[number(id)].leaf >= 0;
}

const World::State::Body& World::State::body(BodyId id) const {
  if (number(id) >= bodies_.size()) throw Error(name(number(id)) + "there is no such body");
  if (!contains(id)) throw Error(name(number(id)) + "was removed");
  return bodies_[number(id)];
}

const HalfSpace& World::State::half_space(HalfSpaceId id) const {
  if (number(id) >= planes_.size())
    throw Error("half-space " + std::to_string(number(id)) + ": there is no such half-space");
  return planes_[number(id)].half_space;
}

// ---- World ---------------------------------------------------------------

World::World() : state_(std::make_unique<State>()) {}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

ShapeId World::add_shape(ShapePtr shape) { return state_->add_shape(std::move(shape)); }

BodyId World::add_body(ShapeId shape, const Eigen::Isometry3d& pose, const BodyOptions& options) {
  return state_->add_body(shape, pose, options);
}

HalfSpaceId World::add_half_space(const HalfSpace& half_space, const Filter& filter) {
  return state_->add_half_space(half_space, filter);
}

void World::remove_body(BodyId body) { state_->remove_body(body); }
void World::set_pose(BodyId body, const Eigen::Isometry3d& pose) { state_->set_pose(body, pose); }
void World::set_motion(BodyId body, const Motion& motion) { state_->set_motion(body, motion); }

const Motion& World::motion(BodyId body) const { return state_->body(body).motion; }
const BodyOptions& World::options(BodyId body) const { return state_->body(body).options; }
const ShapePtr& World::shape(BodyId body) const { return state_->shape(body); }
const HalfSpace& World::half_space(HalfSpaceId half_space) const { return state_->half_space(half_space); }

bool World::contains(BodyId body) const noexcept { return state_->contains(body); }
std::int64_t World::shape_count() const noexcept { return state_->shape_count(); }
std::int64_t World::body_count() const noexcept { return state_->body_count(); }
std::int64_t World::half_space_count() const noexcept { return state_->half_space_count(); }

CandidateStatistics World::visit_candidates(const CandidateOptions& options,
                                            void (*visit)(void* context, const CandidatePair& pair), void* context) {
  return state_->search(options, visit, context);
}

}  // namespace encage

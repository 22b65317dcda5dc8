// SPDX-License-Identifier: Apache-2.0
#include "broadphase/world/state.h"

#include <encage/world.h>

#include <utility>

namespace encage {

World::World() : state_(std::make_unique<State>()) {}
World::World(const WorldOptions& options) : state_(std::make_unique<State>(options)) {}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

// ---- Changes -------------------------------------------------------------

ShapeId World::add_shape(ShapePtr shape, double margin) { return state_->add_shape(std::move(shape), margin); }
BodyId World::add_body(ShapeId shape, const Eigen::Isometry3d& pose, const BodyOptions& options) {
  return state_->add_body(shape, pose, options);
}
HalfSpaceId World::add_half_space(const HalfSpace& half_space, const Filter& filter) {
  return state_->add_half_space(half_space, filter);
}

void World::remove_shape(ShapeId shape) { state_->remove(shape); }
void World::remove_body(BodyId body) { state_->remove(body); }
void World::remove_half_space(HalfSpaceId half_space) { state_->remove(half_space); }

void World::set_pose(BodyId body, const Eigen::Isometry3d& pose) { state_->set_pose(body, pose); }
void World::set_motion(BodyId body, const Motion& motion) { state_->set_motion(body, motion); }
void World::set_shape(BodyId body, ShapeId shape) { state_->set_shape(body, shape); }
void World::set_shape(ShapeId id, ShapePtr shape) { state_->set_shape(id, std::move(shape)); }
void World::set_options(BodyId body, const BodyOptions& options) { state_->set_options(body, options); }
void World::set_filter(BodyId body, const Filter& filter) {
  BodyOptions changed = options(body);
  changed.filter = filter;
  state_->set_options(body, changed);
}
void World::set_scale(BodyId body, double scale) {
  BodyOptions changed = options(body);
  changed.scale = scale;
  state_->set_options(body, changed);
}
void World::set_awake(BodyId body, bool awake) { state_->set_awake(body, awake); }
void World::set_deformation(BodyId body, double bound) { state_->set_deformation(body, bound); }
void World::set_user_data(BodyId body, std::uint64_t data) { state_->set_user_data(body, data); }

void World::update_boxes(const Executor& executor) { state_->update_boxes(executor); }

// ---- Questions -----------------------------------------------------------

const Motion& World::motion(BodyId body) const { return state_->body(body).motion; }
double World::pose_deviation(BodyId body) const { return state_->body(body).deviation; }
double World::pair_margin(BodyId body) const { return state_->pair_margin(body); }
std::uint64_t World::user_data(BodyId body) const { return state_->body(body).user_data; }
const BodyOptions& World::options(BodyId body) const { return state_->body(body).options; }
const ShapePtr& World::shape(BodyId body) const { return shape(shape_id(body)); }
ShapeId World::shape_id(BodyId body) const { return state_->body(body).shape; }
bool World::is_awake(BodyId body) const { return state_->body(body).awake; }
double World::deformation(BodyId body) const { return state_->body(body).deformation; }
const ShapePtr& World::shape(ShapeId shape) const { return state_->shape(shape).shape; }
double World::margin(ShapeId shape) const { return state_->shape(shape).margin; }
const HalfSpace& World::half_space(HalfSpaceId half_space) const { return state_->half_space(half_space).half_space; }
const WorldOptions& World::options() const noexcept { return state_->options(); }

bool World::contains(ShapeId shape) const noexcept { return state_->shape_ids().contains(shape); }
bool World::contains(BodyId body) const noexcept { return state_->body_ids().contains(body); }
bool World::contains(HalfSpaceId half_space) const noexcept { return state_->plane_ids().contains(half_space); }
std::int64_t World::shape_count() const noexcept { return state_->shape_ids().size(); }
std::int64_t World::body_count() const noexcept { return state_->body_ids().size(); }
std::int64_t World::half_space_count() const noexcept { return state_->plane_ids().size(); }
BodyCounts World::body_counts() const noexcept { return state_->body_counts(); }
std::vector<ShapeId> World::shapes() const { return state_->shape_ids().all(); }
std::vector<BodyId> World::bodies() const { return state_->body_ids().all(); }
std::vector<HalfSpaceId> World::half_spaces() const { return state_->plane_ids().all(); }

CandidateStatistics World::visit_candidates(const CandidateOptions& options,
                                            void (*visit)(void* context, const CandidatePair& pair), void* context) {
  return state_->search(options, visit, context);
}

}  // namespace encage

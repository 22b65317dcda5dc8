// SPDX-License-Identifier: Apache-2.0
#include "broadphase/world/room.h"
#include "broadphase/world/state.h"

namespace encage {

void World::State::assign(const State& other) {
  shape_ids_.make_room_for(other.shape_ids_);
  body_ids_.make_room_for(other.body_ids_);
  plane_ids_.make_room_for(other.plane_ids_);
  make_room(shapes_, other.shapes_.size());
  make_room(planes_, other.planes_.size());
  make_room(bodies_, other.bodies_.size());
  make_room(bounds_, other.bounds_.size());
  make_room(traits_, other.traits_.size());
  make_room(outdated_, other.outdated_.size());
  make_room(outdated_planes_, other.outdated_planes_.size());
  make_room(collected_, other.collected_.size());
  make_room(collected_planes_, other.collected_planes_.size());
  make_room(removed_, other.bodies_.size());
  make_room(pairs_, other.pairs_.size());
  make_room(ended_, other.ended_.size());
  sleeping_.make_room_for(other.sleeping_);
  tree_.make_room_for(other.tree_);
  // The vectors have enough capacity, so nothing throws any more.
  *this = other;
}

WorldSnapshot::WorldSnapshot() = default;
WorldSnapshot::~WorldSnapshot() = default;
WorldSnapshot::WorldSnapshot(WorldSnapshot&&) noexcept = default;
WorldSnapshot& WorldSnapshot::operator=(WorldSnapshot&&) noexcept = default;

WorldSnapshot World::snapshot() const {
  WorldSnapshot taken;
  snapshot(taken);
  return taken;
}

void World::snapshot(WorldSnapshot& reused) const {
  state_->check_unlocked();
  if (reused.state_) return reused.state_->assign(*state_);
  auto taken = std::make_unique<State>();
  taken->assign(*state_);
  reused.state_ = std::move(taken);
}

void World::restore(const WorldSnapshot& snapshot) {
  state_->check_unlocked();
  if (!snapshot.state_) throw Error("the snapshot holds nothing");
  state_->assign(*snapshot.state_);
}

}  // namespace encage

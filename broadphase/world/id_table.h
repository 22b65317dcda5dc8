// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/world/room.h"

#include <encage/world.h>

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace encage {

/// "body 7 (generation 2)"; the first generation is not printed.
template <WorldId Id>
std::string name(Id id) {
  const char* kind = "half-space ";
  if constexpr (std::same_as<Id, ShapeId>) kind = "shape ";
  if constexpr (std::same_as<Id, BodyId>) kind = "body ";
  if (~static_cast<std::uint64_t>(id) == 0) return kind + std::string("none");
  const std::string text = kind + std::to_string(index(id));
  return generation(id) == 0 ? text : text + " (generation " + std::to_string(generation(id)) + ")";
}

/// Assigns ids and records which of them are in use.
template <WorldId Id>
class IdTable {
 public:
  /// Reserves capacity for one more id, so that add() and remove() cannot throw.
  void prepare_add() {
    make_room(slots_, slots_.size() + 1);
    make_room(free_, slots_.size() + 1);
  }
  /// Reserves capacity for the content of `other`, and for its removal.
  void make_room_for(const IdTable& other) {
    make_room(slots_, other.slots_.size());
    make_room(free_, other.slots_.size());
  }

  /// Returns the id that add() will return.
  Id next() const noexcept {
    return free_.empty() ? id(static_cast<std::uint32_t>(slots_.size()), 0)
                         : id(free_.back(), slots_[free_.back()].generation);
  }
  Id add() noexcept {
    const Id added = next();
    if (free_.empty()) {
      slots_.push_back({0, true});
    } else {
      slots_[free_.back()].used = true;
      free_.pop_back();
    }
    return added;
  }
  void remove(Id removed) noexcept {
    assert(contains(removed));
    Slot& slot = slots_[index(removed)];
    slot.used = false;
    // The last generation is never assigned: its last id is that of `none`.
    if (++slot.generation == last_generation) {
      ++retired_;
    } else {
      free_.push_back(index(removed));
    }
  }

  bool contains(Id asked) const noexcept {
    return index(asked) < slots_.size() && slots_[index(asked)].used &&
           slots_[index(asked)].generation == generation(asked);
  }
  bool is_used(std::uint32_t i) const noexcept { return slots_[i].used; }
  /// Returns the id that an index has, or that it gets next.
  Id at(std::uint32_t i) const noexcept { return id(i, slots_[i].generation); }

  /// Returns the number of indices assigned so far.
  std::uint32_t slots() const noexcept { return static_cast<std::uint32_t>(slots_.size()); }
  std::int64_t size() const noexcept { return static_cast<std::int64_t>(slots_.size() - free_.size()) - retired_; }

  /// Returns the ids in use, by increasing index.
  std::vector<Id> all() const {
    std::vector<Id> ids;
    ids.reserve(static_cast<std::size_t>(size()));
    for (std::uint32_t i = 0; i < slots(); ++i) {
      if (is_used(i)) ids.push_back(at(i));
    }
    return ids;
  }

  /// Explains why there is no object with this id.
  const char* defect(Id asked) const noexcept {
    const bool known = index(asked) < slots_.size() && generation(asked) < slots_[index(asked)].generation;
    return known ? "was removed" : "does not exist";
  }

 private:
  struct Slot {
    std::uint32_t generation = 0;
    bool used = false;
  };
  static constexpr std::uint32_t last_generation = std::numeric_limits<std::uint32_t>::max();
  static Id id(std::uint32_t i, std::uint32_t generation) noexcept {
    return static_cast<Id>(std::uint64_t{generation} << 32 | i);
  }

  std::vector<Slot> slots_;
  std::vector<std::uint32_t> free_;
  std::int64_t retired_ = 0;  // number of indices that have no generation left
};

}  // namespace encage

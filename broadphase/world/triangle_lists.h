// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/separated.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace encage {

/// Lists of pairs of triangles that several threads write at once, in blocks of a pool
/// of fixed size: no locks, and no allocation but the pool's. A list that the pool has no room for is incomplete.
class TriangleLists {
 public:
  static constexpr int block_size = 64, block_count = 4096;

  struct List {
    std::int32_t first_block = -1;
    std::int32_t size = 0;  ///< -1: incomplete
    bool complete() const noexcept { return size >= 0; }
  };

  /// Writes one list; by one thread.
  class Writer {
   public:
    explicit Writer(TriangleLists& lists) noexcept : lists_(lists) {}
    /// False if there is no room.
    bool push(TrianglePair pair) noexcept;
    const List& list() const noexcept { return list_; }

   private:
    TriangleLists& lists_;
    List list_;
    std::int32_t block_ = -1;
  };

  /// Forgets all lists. Allocates the pool at the first call.
  void clear();

  /// The content of a complete list, valid while neither the list nor `room` changes: copied into `room`
  /// if it is scattered.
  std::span<const TrianglePair> read(const List& list, std::vector<TrianglePair>& room) const;

 private:
  struct Block {
    std::array<TrianglePair, block_size> pairs;
    std::int32_t next = -1;
  };
  std::int32_t take_block() noexcept;

  std::unique_ptr<Block[]> blocks_;
  std::atomic<std::int32_t> used_{0};
};

}  // namespace encage

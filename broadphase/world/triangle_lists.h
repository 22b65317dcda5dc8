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

/// Lists of pairs of triangles that several threads write at once, in blocks of a pool of fixed size: no locks, and no
/// allocation but the pool's. A list for which the pool has no room is incomplete.
class TriangleLists {
 public:
  static constexpr int block_size = 64, block_count = 4096;

  struct List {
    std::int32_t first_block = -1;
    std::int32_t size = 0;  ///< -1 if incomplete
    bool complete() const noexcept { return size >= 0; }
  };

  /// Writes one list; for one thread.
  class Writer {
   public:
    explicit Writer(TriangleLists& lists) noexcept : lists_(lists) {}
    /// Returns false if there is no room.
    bool push(TrianglePair pair) noexcept;
    const List& list() const noexcept { return list_; }

   private:
    TriangleLists& lists_;
    List list_;
    std::int32_t block_ = -1;
  };

  /// Clears all lists. The first call allocates the pool.
  void clear();

  /// Returns the content of a complete list, valid while neither the list nor `room` changes. A list that is scattered
  /// over several blocks is copied into `room`.
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

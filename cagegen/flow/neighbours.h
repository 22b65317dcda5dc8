// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace encage::makers {

/// The triangles at each vertex, ascending.
class Neighbours {
 public:
  explicit Neighbours(const TriangleMesh& mesh)
      : first_(static_cast<std::size_t>(mesh.vertices.rows()) + 1),
        around_(static_cast<std::size_t>(mesh.triangles.size())) {
    const auto count = static_cast<std::int32_t>(mesh.triangles.rows());
    for (std::int32_t t = 0; t < count; ++t) {
      for (int k = 0; k < 3; ++k) ++first_[mesh.triangles(t, k) + 1];
    }
    for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
    std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
    for (std::int32_t t = 0; t < count; ++t) {
      for (int k = 0; k < 3; ++k) around_[next[mesh.triangles(t, k)]++] = t;
    }
  }

  /// A triangle that has the vertex twice occurs twice.
  std::span<const std::int32_t> operator()(std::int32_t vertex) const {
    return {around_.data() + first_[vertex], around_.data() + first_[vertex + 1]};
  }

 private:
  std::vector<std::int32_t> first_;
  std::vector<std::int32_t> around_;
};

/// Collects indices, each once.
class IndexSet {
 public:
  explicit IndexSet(std::size_t count) : has_(count) {}

  void add(std::int32_t i) {
    if (has_[i]) return;
    has_[i] = 1;
    members_.push_back(i);
  }
  /// Empties the set. The result ascends.
  std::vector<std::int32_t> take() {
    for (const std::int32_t i : members_) has_[i] = 0;
    std::sort(members_.begin(), members_.end());
    return std::exchange(members_, {});
  }

 private:
  std::vector<char> has_;
  std::vector<std::int32_t> members_;
};

}  // namespace encage::makers

// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/sanitize/weld.h"

#include <bit>

namespace encage::io {
namespace {

std::uint64_t mix(std::uint64_t h) {
  h ^= h >> 32;
  h *= 0x9e3779b97f4a7c15u;
  return h ^ h >> 29;
}

std::uint64_t hash(const double* p) {
  std::uint64_t h = 0;
  for (int k = 0; k < 3; ++k) h = mix(h + std::bit_cast<std::uint64_t>(p[k] + 0.0));  // -0 + 0 = +0
  return h;
}

}  // namespace

std::vector<std::int32_t> weld(std::span<const double> coordinates) {
  const std::size_t count = coordinates.size() / 3;
  // Open addressing; a slot holds the first vertex at its position. The result does not depend on the hash, only on the
  // order of the vertices.
  const std::size_t mask = std::bit_ceil(2 * count + 1) - 1;
  std::vector<std::int32_t> slots(mask + 1, -1);
  std::vector<std::int32_t> same(count);
  for (std::size_t v = 0; v < count; ++v) {
    const double* const p = &coordinates[3 * v];
    std::size_t slot = hash(p) & mask;
    for (;; slot = (slot + 1) & mask) {
      if (slots[slot] < 0) slots[slot] = static_cast<std::int32_t>(v);
      const double* const q = &coordinates[3 * static_cast<std::size_t>(slots[slot])];
      if (p[0] == q[0] && p[1] == q[1] && p[2] == q[2]) break;
    }
    same[v] = slots[slot];
  }
  return same;
}

Eigen::Index drop_unused_vertices(TriangleMesh& mesh) {
  std::vector<std::int32_t> number(static_cast<std::size_t>(mesh.vertices.rows()), -1);
  for (const std::int32_t v : mesh.triangles.reshaped()) number[v] = 0;
  Eigen::Index kept = 0;
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    if (number[v] < 0) continue;
    mesh.vertices.row(kept) = mesh.vertices.row(v);
    number[v] = static_cast<std::int32_t>(kept++);
  }
  const Eigen::Index dropped = mesh.vertices.rows() - kept;
  if (dropped == 0) return 0;
  mesh.vertices.conservativeResize(kept, 3);
  for (std::int32_t& v : mesh.triangles.reshaped()) v = number[v];
  return dropped;
}

}  // namespace encage::io

// SPDX-License-Identifier: Apache-2.0
#include "src/files/hash.h"

#include <array>
#include <cstdint>
#include <string>

// The code is inlined, so that the run time does not depend on libxxhash.
#define XXH_INLINE_ALL
#include <xxhash.h>

namespace encage {
namespace {

Hash to_hash(XXH128_hash_t hash) { return {.low = hash.low64, .high = hash.high64}; }

}  // namespace

struct Hasher::State {
  XXH3_state_t xxh3;
};

Hasher::Hasher() : state_(std::make_unique<State>()) { XXH3_128bits_reset(&state_->xxh3); }
Hasher::~Hasher() = default;
Hasher::Hasher(Hasher&&) noexcept = default;
Hasher& Hasher::operator=(Hasher&&) noexcept = default;

void Hasher::add(std::span<const std::byte> bytes) {
  if (!bytes.empty()) XXH3_128bits_update(&state_->xxh3, bytes.data(), bytes.size());
}

Hash Hasher::digest() const { return to_hash(XXH3_128bits_digest(&state_->xxh3)); }

Hash hash_bytes(std::span<const std::byte> bytes) { return to_hash(XXH3_128bits(bytes.data(), bytes.size())); }

Hash hash_mesh(const TriangleMesh& mesh) {
  const std::array<std::int64_t, 2> sizes = {mesh.vertices.rows(), mesh.triangles.rows()};
  Hasher hasher;
  hasher.add(std::as_bytes(std::span(sizes)));
  hasher.add(std::as_bytes(std::span(mesh.vertices.data(), static_cast<std::size_t>(mesh.vertices.size()))));
  hasher.add(std::as_bytes(std::span(mesh.triangles.data(), static_cast<std::size_t>(mesh.triangles.size()))));
  return hasher.digest();
}

std::string to_string(const Hash& hash) {
  static constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint64_t word : {hash.high, hash.low}) {
    for (int shift = 60; shift >= 0; shift -= 4) text += digits[word >> shift & 15];
  }
  return text;
}

}  // namespace encage

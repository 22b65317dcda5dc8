// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/files/hash.h"

#include <gtest/gtest.h>

#include <span>
#include <string>
#include <string_view>

namespace encage {
namespace {

std::span<const std::byte> bytes(std::string_view text) { return std::as_bytes(std::span(text.data(), text.size())); }

TEST(Hash, MatchesPublishedValueOfXxh3) {
  // The output of `printf '' | xxhsum -H2`.
  EXPECT_EQ(to_string(hash_bytes({})), "99aa06d3014798d86001c324468d497f");
}

TEST(Hash, PrintsLeadingZeros) {
  EXPECT_EQ(to_string(Hash{.low = 0xab, .high = 1}), "000000000000000100000000000000ab");
}

TEST(Hash, StreamEqualsWhole) {
  std::string text;
  for (int i = 0; i < 5000; ++i) text += static_cast<char>(i * 7 + i / 256);
  for (const std::size_t cut : {std::size_t{0}, std::size_t{1}, std::size_t{241}, std::size_t{4096}, text.size()}) {
    Hasher hasher;
    hasher.add(bytes(std::string_view(text).substr(0, cut)));
    hasher.add(bytes(std::string_view(text).substr(cut)));
    EXPECT_EQ(hasher.digest(), hash_bytes(bytes(text))) << cut;
  }
}

TEST(Hash, SeesEveryFlippedBit) {
  std::string text(64, 'x');
  const Hash original = hash_bytes(bytes(text));
  for (std::size_t bit = 0; bit < text.size() * 8; ++bit) {
    text[bit / 8] = static_cast<char>(text[bit / 8] ^ 1 << bit % 8);
    EXPECT_NE(hash_bytes(bytes(text)), original) << bit;
    text[bit / 8] = static_cast<char>(text[bit / 8] ^ 1 << bit % 8);
  }
}

}  // namespace
}  // namespace encage

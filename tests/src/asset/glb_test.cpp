// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/asset/glb.h"

#include "tests/src/asset/forge.h"

#include <encage/error.h>

#include <gtest/gtest.h>

namespace encage {
namespace {

std::string sample() { return glb_head(R"({"a":1})", 8, "f") + "01234567"; }

std::string parse_error(const std::string& bytes) {
  return error_of([&] { parse_glb(as_byte_span(bytes), "f.glb"); });
}

std::string with_word(std::string bytes, std::size_t offset, std::uint32_t value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
  return bytes;
}

TEST(AssetGlb, data_start_aligned_whatever_the_length_of_the_json) {
  for (std::size_t n = 0; n < 200; ++n) {
    const std::string json(n, 'x');
    const std::string bytes = glb_head(json, 4, "f") + "data";
    const Glb glb = parse_glb(as_byte_span(bytes), "f");
    EXPECT_EQ(glb.head.size() % 64, 0U);
    EXPECT_EQ(glb.json.substr(0, n), json);
    EXPECT_EQ(glb.json.substr(n).find_first_not_of(' '), std::string_view::npos);
    EXPECT_LT(glb.json.size(), n + 64);
    EXPECT_EQ(std::memcmp(glb.bin.data(), "data", 4), 0);
  }
}

TEST(AssetGlb, refuses_files_over_4_gib) {
  EXPECT_NO_THROW(glb_head("{}", (1ULL << 32) - 128, "f"));
  EXPECT_EQ(error_of([] { glb_head("{}", (1ULL << 32) - 64, "big.glb"); }),
            "big.glb: 4294967296 bytes exceed the 4 GiB that a GLB file can hold");
}

TEST(AssetGlb, refuses_malformed_containers) {
  const std::string good = sample();
  EXPECT_EQ(parse_error("glTF"), "f.glb: GLB header: the file has only 4 bytes");
  EXPECT_EQ(parse_error(with_word(good, 0, 1)), "f.glb: GLB header: not a binary glTF file");
  EXPECT_EQ(parse_error(with_word(good, 4, 1)), "f.glb: GLB header: glTF version 1 is not 2");
  EXPECT_EQ(parse_error(good + "x"), "f.glb: GLB header: the length 72 is not the file's 73 bytes");
  EXPECT_EQ(parse_error(with_word(good, 12, 37)), "f.glb: JSON chunk: its length 37 is no multiple of 4");
  EXPECT_EQ(parse_error(with_word(good, 12, 0xfffffffc)),
            "f.glb: JSON chunk: its length 4294967292 exceeds the 52 bytes left in the file");
  EXPECT_EQ(parse_error(with_word(good, 16, 7)), "f.glb: JSON chunk: missing: a chunk of another type is in its place");
  EXPECT_EQ(parse_error(with_word(good, 60, 7)), "f.glb: BIN chunk: missing: a chunk of another type is in its place");
  EXPECT_EQ(parse_error(with_word(good, 56, 4)), "f.glb: BIN chunk: data follow it");
  EXPECT_EQ(parse_error(with_word(good.substr(0, 56), 8, 56)), "f.glb: BIN chunk: missing: the file ends before it");
}

TEST(AssetGlb, never_reads_beyond_a_truncated_file) {
  const std::string good = sample();
  for (std::size_t n = 0; n < good.size(); ++n) {
    std::string cut = good.substr(0, n);
    if (n >= 12) cut = with_word(cut, 8, static_cast<std::uint32_t>(n));  // makes the reader test the chunks
    const AlignedBytes bytes(cut);
    EXPECT_THROW(parse_glb(bytes.span(), "f"), Error) << n;
  }
}

}  // namespace
}  // namespace encage

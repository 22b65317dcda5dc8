// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/asset/json.h"

#include "tests/src/asset/forge.h"

#include <encage/error.h>

#include <gtest/gtest.h>

namespace encage {
namespace {

TEST(AssetJson, reads_what_is_there) {
  const auto document = parse_json(R"({"i":[1,-2,18446744073709551615],"x":0.1,"b":true,"t":"word",
      "h":"00000000000000010000000000000abc"})",
                                   "f");
  const JsonNode root(document, "f");
  EXPECT_EQ(root.at("i").size(), 3);
  EXPECT_EQ(root.at("i").at(std::int64_t{1}).integer(-5), -2);
  EXPECT_EQ(root.at("x").number(), 0.1);
  EXPECT_TRUE(root.at("b").boolean());
  EXPECT_EQ(root.at("t").text(), "word");
  EXPECT_EQ(root.at("h").hash(), (Hash{.low = 0xabc, .high = 1}));
  EXPECT_FALSE(root.find("absent"));
}

TEST(AssetJson, names_the_place_and_the_reason) {
  const auto document = parse_json(R"({"i":[1,-2,18446744073709551615],"x":0.5,"t":"word",
      "h":"00000000000000010000000000000ABC"})",
                                   "f");
  const JsonNode root(document, "f");
  const auto element = [&](std::int64_t i) { return root.at("i").at(i); };
  EXPECT_EQ(error_of([&] { root.at("absent"); }), "f: has no \"absent\"");
  EXPECT_EQ(error_of([&] { element(3); }), "f.i: has no element 3, only 3");
  EXPECT_EQ(error_of([&] { element(-1); }), "f.i: has no element -1, only 3");
  EXPECT_EQ(error_of([&] { element(1).integer(); }), "f.i[1]: -2 is out of range");
  EXPECT_EQ(error_of([&] { element(2).integer(); }), "f.i[2]: 18446744073709551615 is out of range");
  EXPECT_EQ(error_of([&] { root.at("x").integer(); }), "f.x: not an integer");
  EXPECT_EQ(error_of([&] { root.at("t").number(); }), "f.t: not a number");
  EXPECT_EQ(error_of([&] { root.at("t").boolean(); }), "f.t: neither true nor false");
  EXPECT_EQ(error_of([&] { root.at("t").size(); }), "f.t: not an array");
  EXPECT_EQ(error_of([&] { root.at("t").at("x"); }), "f.t: not an object");
  EXPECT_EQ(error_of([&] { root.at("x").text(); }), "f.x: not a string");
  for (const char* key : {"t", "h"}) {
    EXPECT_EQ(error_of([&] { root.at(key).hash(); }),
              std::string("f.") + key + ": not a hash of 32 lower-case hexadecimal digits");
  }
}

TEST(AssetJson, refuses_what_is_no_json_or_too_deep) {
  for (const char* text : {"", "{", "{}x", "[1e999]", "\"\xff\"", "[NaN]"}) {
    EXPECT_THROW(parse_json(text, "f"), Error) << text;
  }
  const auto nested = [](std::size_t n) { return std::string(n, '[') + std::string(n, ']'); };
  EXPECT_NO_THROW(parse_json(nested(64), "f"));
  EXPECT_EQ(error_of([&] { parse_json(nested(1000000), "f"); }), "f: nested too deeply");
}

}  // namespace
}  // namespace encage

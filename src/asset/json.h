// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/cage.h>

#include <nlohmann/json.hpp>

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace encage {

/// Returns the depth of nesting of a JSON text: the levels of brackets outside strings.
int json_depth(std::string_view text);
/// Deeper texts are refused, because printing and copying JSON are recursive.
constexpr int max_json_depth = 64;

/// Parses JSON nested no deeper than max_json_depth. Throws Error, its message starting with `place`.
nlohmann::json parse_json(std::string_view text, const std::string& place);

/// A JSON value of a file together with its path in the document. Every access checks presence, type and range, and
/// throws Error naming file, path and reason. The node refers to the document, which must outlive it.
class JsonNode {
 public:
  /// `place` starts every message: "FILE: JSON".
  JsonNode(const nlohmann::json& value, std::string place) : value_(&value), place_(std::move(place)) {}

  JsonNode at(const char* key) const;                   ///< member of an object
  std::optional<JsonNode> find(const char* key) const;  ///< the same; no value if the key is absent
  std::int64_t size() const;                            ///< number of elements of an array
  JsonNode at(std::int64_t index) const;                ///< element of an array

  std::int64_t integer(std::int64_t low = 0, std::int64_t high = std::numeric_limits<std::int64_t>::max()) const;
  double number() const;  ///< always finite
  bool boolean() const;
  const std::string& text() const;
  Hash hash() const;  ///< 32 lower-case hexadecimal digits
  const nlohmann::json& object() const;

  [[noreturn]] void fail(const std::string& reason) const;

 private:
  const nlohmann::json* value_;
  std::string place_;
};

}  // namespace encage

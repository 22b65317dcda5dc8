// SPDX-License-Identifier: Apache-2.0
#include "src/asset/json.h"

#include <encage/error.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace encage {

int json_depth(std::string_view text) {
  int depth = 0, most = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') {
      quoted = !quoted;
    } else if (quoted) {
      i += c == '\\' ? 1 : 0;
    } else if (c == '[' || c == '{') {
      most = std::max(most, ++depth);
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return most;
}

nlohmann::json parse_json(std::string_view text, const std::string& place) {
  // The depth is tested before parsing, since a parser callback would make parsing a third slower. The limit is needed
  // because printing is recursive.
  if (json_depth(text) > max_json_depth + 1) throw Error(place + ": nested too deeply");
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& e) {
    throw Error(place + ": " + e.what());
  }
}

void JsonNode::fail(const std::string& reason) const { throw Error(place_ + ": " + reason); }

std::optional<JsonNode> JsonNode::find(const char* key) const {
  if (!value_->is_object()) fail("not an object");
  const auto member = value_->find(key);
  if (member == value_->end()) return std::nullopt;
  return JsonNode(*member, place_ + "." + key);
}

JsonNode JsonNode::at(const char* key) const {
  if (auto member = find(key)) return *std::move(member);
  fail(std::string("has no \"") + key + "\"");
}

std::int64_t JsonNode::size() const {
  if (!value_->is_array()) fail("not an array");
  return static_cast<std::int64_t>(value_->size());
}

JsonNode JsonNode::at(std::int64_t index) const {
  if (index < 0 || index >= size()) {
    fail("has no element " + std::to_string(index) + ", only " + std::to_string(size()));
  }
  return JsonNode((*value_)[static_cast<std::size_t>(index)], place_ + "[" + std::to_string(index) + "]");
}

std::int64_t JsonNode::integer(std::int64_t low, std::int64_t high) const {
  if (!value_->is_number_integer()) fail("not an integer");
  const bool huge = value_->is_number_unsigned() && value_->get<std::uint64_t>() > std::uint64_t{INT64_MAX};
  const std::int64_t value = huge ? INT64_MAX : value_->get<std::int64_t>();
  if (huge || value < low || value > high) fail(value_->dump() + " is out of range");
  return value;
}

double JsonNode::number() const {
  if (!value_->is_number()) fail("not a number");
  return value_->get<double>();  // the parser refuses numbers beyond double
}

bool JsonNode::boolean() const {
  if (!value_->is_boolean()) fail("neither true nor false");
  return value_->get<bool>();
}

const std::string& JsonNode::text() const {
  if (!value_->is_string()) fail("not a string");
  return value_->get_ref<const std::string&>();
}

Hash JsonNode::hash() const {
  const std::string& digits = text();
  Hash hash;
  if (digits.size() == 32) {
    std::from_chars(digits.data(), digits.data() + 16, hash.high, 16);
    std::from_chars(digits.data() + 16, digits.data() + 32, hash.low, 16);
  }
  if (to_string(hash) != digits) fail("not a hash of 32 lower-case hexadecimal digits");
  return hash;
}

const nlohmann::json& JsonNode::object() const {
  if (!value_->is_object()) fail("not an object");
  return *value_;
}

}  // namespace encage

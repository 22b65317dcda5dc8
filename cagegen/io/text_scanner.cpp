// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/text_scanner.h"

#include "cagegen/io/mesh_file.h"

#include <charconv>
#include <cmath>
#include <system_error>

namespace encage::io {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

std::string quoted(std::string_view token) {
  std::string text = "'";
  for (const char c : token.substr(0, 40)) text += c >= ' ' && c < 127 ? c : '?';
  return text + "'";
}

}  // namespace

std::string_view TextScanner::word() {
  const auto ends = [](char c) { return is_blank(c) || c == '\n' || c == '#' || c == '\\'; };
  const std::size_t begin = at_++;
  while (at_ < text_.size() && !ends(text_[at_])) ++at_;
  return text_.substr(begin, at_ - begin);
}

std::string_view TextScanner::token() {
  for (;;) {
    const std::string_view found = token_on_line();
    if (!found.empty() || at_ >= text_.size()) return found;
    skip_line();
  }
}

std::string_view TextScanner::token_on_line() {
  while (at_ < text_.size()) {
    const char c = text_[at_];
    if (is_blank(c)) {
      ++at_;
    } else if (c == '\\') {
      std::size_t next = at_ + 1;
      while (next < text_.size() && is_blank(text_[next])) ++next;
      if (next >= text_.size() || text_[next] != '\n') return word();
      at_ = next + 1;
      ++line_;
    } else if (c == '#') {
      while (at_ < text_.size() && text_[at_] != '\n') ++at_;
    } else if (c == '\n') {
      return {};
    } else {
      return word();
    }
  }
  return {};
}

void TextScanner::skip_line() {
  while (at_ < text_.size() && text_[at_] != '\n') ++at_;
  if (at_ < text_.size()) {
    ++at_;
    ++line_;
  }
}

double TextScanner::coordinate(std::string_view token, const char* element, std::int64_t number) const {
  double value = 0;
  if (token.empty()) fail(element, number, at_ >= text_.size() ? "the file ends early" : "too few coordinates");
  if (!parse_number(token, value)) fail(element, number, quoted(token) + " is not a number");
  if (!std::isfinite(value)) fail(element, number, "coordinate " + quoted(token) + " is not finite");
  return value;
}

std::int64_t TextScanner::integer(std::string_view token, const char* element, std::int64_t number) const {
  std::int64_t value = 0;
  if (token.empty()) fail(element, number, "the file ends early");
  if (!parse_integer(token, value)) fail(element, number, quoted(token) + " is not an integer");
  return value;
}

void TextScanner::fail(const std::string& reason) const {
  io::fail(file_, "line " + std::to_string(line_) + ": " + reason);
}

void TextScanner::fail(const char* element, std::int64_t number, const std::string& reason) const {
  io::fail(file_, element, number, "line " + std::to_string(line_) + ": " + reason);
}

bool parse_number(std::string_view token, double& value) {
  if (token.size() > 1 && token.front() == '+' && token[1] != '-') token.remove_prefix(1);
  const char* const end = token.data() + token.size();
  const auto [stop, error] = std::from_chars(token.data(), end, value);
  if (stop != end || token.empty() || error == std::errc::invalid_argument) return false;
  if (error == std::errc::result_out_of_range) {
    // from_chars does not tell too large from too small.
    const bool tiny = token.find("e-") != token.npos || token.find("E-") != token.npos;
    value = tiny ? 0 : HUGE_VAL;
  }
  return true;
}

bool parse_integer(std::string_view token, std::int64_t& value) {
  if (token.size() > 1 && token.front() == '+' && token[1] != '-') token.remove_prefix(1);
  const char* const end = token.data() + token.size();
  const auto [stop, error] = std::from_chars(token.data(), end, value);
  return stop == end && error == std::errc();
}

}  // namespace encage::io

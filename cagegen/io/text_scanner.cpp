// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/text_scanner.h"

#include "cagegen/io/mesh_file.h"

#include <charconv>
#include <cmath>
#include <system_error>

namespace encage::io {
namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool is_line_end(char c) { return c == '\n' || c == '\r'; }

}  // namespace

bool has_byte_order_mark(std::string_view text) { return text.starts_with(byte_order_mark); }

std::string quoted(std::string_view token) {
  std::string text = "'";
  for (const char c : token.substr(0, 40)) text += c >= ' ' && c < 127 ? c : '?';
  return text + "'";
}

std::string counted(std::int64_t count, const char* one, const char* many) {
  return std::to_string(count) + ' ' + (count == 1 ? one : many);
}

void require_utf8(const std::filesystem::path& file, std::string_view text) {
  using namespace std::string_view_literals;
  const std::string_view head = text.substr(0, 64);
  // Of plain text, only one byte in two, or in four, is other than zero.
  const auto has_one_in = [&](std::size_t step, std::size_t phase) {
    for (std::size_t i = 0; i < head.size(); ++i) {
      if ((head[i] != '\0') != (i % step == phase)) return false;
    }
    return head.size() >= 4;
  };
  const char* encoding = nullptr;
  if (head.starts_with("\xFF\xFE\0\0"sv) || head.starts_with("\0\0\xFE\xFF"sv)) {
    encoding = "UTF-32";
  } else if (head.starts_with("\xFF\xFE") || head.starts_with("\xFE\xFF")) {
    encoding = "UTF-16";
  } else if (has_one_in(2, 0)) {
    encoding = "UTF-16LE";
  } else if (has_one_in(2, 1)) {
    encoding = "UTF-16BE";
  } else if (has_one_in(4, 0)) {
    encoding = "UTF-32LE";
  } else if (has_one_in(4, 3)) {
    encoding = "UTF-32BE";
  }
  if (encoding == nullptr) return;
  fail(file, std::string("the text is ") + encoding + "; convert it: iconv -f " + encoding + " -t UTF-8 FILE > NEW");
}

std::size_t TextScanner::skip_blanks(std::size_t at) {
  for (;;) {
    if (at < text_.size() && is_blank(text_[at])) {
      ++at;
    } else if (at < text_.size() && text_[at] == byte_order_mark[0] && text_.substr(at).starts_with(byte_order_mark)) {
      at += byte_order_mark.size();
      found_byte_order_mark_ = true;
    } else {
      return at;
    }
  }
}

/// Behind the end of line that stands at `at`, or `at` if none does.
std::size_t TextScanner::line_end(std::size_t at) const {
  if (at >= text_.size() || !is_line_end(text_[at])) return at;
  return at + (text_.substr(at).starts_with("\r\n") ? 2 : 1);
}

std::string_view TextScanner::word() {
  const auto ends = [](char c) { return is_blank(c) || is_line_end(c) || c == '#' || c == '\\'; };
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
  for (;;) {
    at_ = skip_blanks(at_);
    if (at_ >= text_.size() || is_line_end(text_[at_])) return {};
    if (text_[at_] == '\\') {
      const std::size_t end = skip_blanks(at_ + 1), next = line_end(end);
      if (next == end) return word();
      at_ = next;
      ++line_;
    } else if (text_[at_] == '#') {
      while (at_ < text_.size() && !is_line_end(text_[at_])) ++at_;
    } else {
      return word();
    }
  }
}

void TextScanner::skip_line() {
  while (at_ < text_.size() && !is_line_end(text_[at_])) ++at_;
  if (at_ >= text_.size()) return;
  at_ = line_end(at_);
  ++line_;
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

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace encage::io {

/// Splits a text into tokens at blanks, skips comments from '#' to the end of the line, and knows the line it is at.
/// Independent of the locale.
class TextScanner {
 public:
  TextScanner(const std::filesystem::path& file, std::string_view text) : file_(file), text_(text) {}

  std::int64_t line() const { return line_; }  ///< of the last token, from 1
  /// The next token on this or a later line; empty at the end of the text.
  std::string_view token();
  /// The next token on this line (a backslash at its end joins it with the next); empty if there is none.
  std::string_view token_on_line();
  void skip_line();

  /// A finite coordinate of an element. Throws Error naming element and line.
  double coordinate(std::string_view token, const char* element, std::int64_t number) const;
  std::int64_t integer(std::string_view token, const char* element, std::int64_t number) const;

  [[noreturn]] void fail(const std::string& reason) const;
  [[noreturn]] void fail(const char* element, std::int64_t number, const std::string& reason) const;

 private:
  std::string_view word();

  const std::filesystem::path& file_;
  std::string_view text_;
  std::size_t at_ = 0;
  std::int64_t line_ = 1;
};

/// Any finite or non-finite number in decimal notation; false if the token is none.
bool parse_number(std::string_view token, double& value);
bool parse_integer(std::string_view token, std::int64_t& value);

}  // namespace encage::io

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace encage::io {

/// Splits a text into tokens at blanks, skips comments from '#' to the end of the line, and knows the line it is at.
/// Lines end in LF, CR LF or CR. Byte order marks are blanks wherever they stand, because files get concatenated.
/// Independent of the locale.
class TextScanner {
 public:
  TextScanner(const std::filesystem::path& file, std::string_view text) : file_(file), text_(text) {}

  std::int64_t line() const { return line_; }  ///< of the last token, from 1
  bool found_byte_order_mark() const { return found_byte_order_mark_; }
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
  std::size_t skip_blanks(std::size_t at);
  std::size_t line_end(std::size_t at) const;

  const std::filesystem::path& file_;
  std::string_view text_;
  std::size_t at_ = 0;
  std::int64_t line_ = 1;
  bool found_byte_order_mark_ = false;
};

/// Refuses text in UTF-16 or UTF-32 by its name.
void require_utf8(const std::filesystem::path& file, std::string_view text);

bool has_byte_order_mark(std::string_view text);
inline constexpr const char* byte_order_mark_note = "a byte order mark was skipped";

/// A token in quotes, cut and made printable for a message.
std::string quoted(std::string_view token);

/// "3 points", "1 point".
std::string counted(std::int64_t count, const char* one, const char* many);

/// Any finite or non-finite number in decimal notation; false if the token is none.
bool parse_number(std::string_view token, double& value);
bool parse_integer(std::string_view token, std::int64_t& value);

}  // namespace encage::io

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdio>
#include <ostream>
#include <string>
#include <vector>

namespace encage::bench {

/// snprintf() into a string of any length.
template <class... Values>
std::string format(const char* pattern, Values... values) {
  const int length = std::snprintf(nullptr, 0, pattern, values...);
  std::string text(static_cast<std::size_t>(length), '\0');
  std::snprintf(text.data(), text.size() + 1, pattern, values...);
  return text;
}

/// The text as a cell of a Markdown table.
std::string escaped(std::string cell);

/// A Markdown table that is written row by row: the first column aligned to the left, the others to the right.
class MarkdownTable {
 public:
  using Cells = std::vector<std::string>;

  /// Writes the head. Cells are padded to `first_width` and `width` characters, so that the text reads as a table, too.
  MarkdownTable(std::ostream& out, const Cells& head, std::size_t first_width = 0, std::size_t width = 0);
  void row(const Cells& cells);

 private:
  std::ostream& out_;
  std::size_t first_width_, width_;
};

}  // namespace encage::bench

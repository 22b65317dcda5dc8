// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/report.h"

#include <algorithm>

namespace encage::bench {

std::string escaped(std::string cell) {
  for (std::size_t i = 0; (i = cell.find('|', i)) != std::string::npos; i += 2) cell.insert(i, 1, '\\');
  std::replace(cell.begin(), cell.end(), '\n', ' ');
  return cell;
}

MarkdownTable::MarkdownTable(std::ostream& out, const Cells& head, std::size_t first_width, std::size_t width)
    : out_(out), first_width_(first_width), width_(width) {
  row(head);
  out_ << '|' << std::string(std::max<std::size_t>(3, first_width + 2), '-') << '|';
  for (std::size_t i = 1; i < head.size(); ++i) out_ << std::string(std::max<std::size_t>(2, width + 1), '-') << ":|";
  out_ << '\n';
}

void MarkdownTable::row(const Cells& cells) {
  out_ << '|';
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::size_t width = i == 0 ? first_width_ : width_;
    const std::string space(width > cells[i].size() ? width - cells[i].size() : 0, ' ');
    out_ << ' ' << (i == 0 ? cells[i] + space : space + cells[i]) << " |";
  }
  out_ << '\n';
}

}  // namespace encage::bench

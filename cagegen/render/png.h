// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace encage::render {

/// 8-bit RGB, rows from top to bottom, no padding.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;

  const std::uint8_t* pixel(int x, int y) const { return rgb.data() + 3 * (static_cast<std::size_t>(y) * width + x); }
};

/// Writes a PNG atomically (a temporary, then a rename). Throws Error naming the file.
void write_png(const std::filesystem::path& file, const Image& image);

}  // namespace encage::render

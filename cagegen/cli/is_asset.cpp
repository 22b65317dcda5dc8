// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/is_asset.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

namespace encage::tool {

bool is_asset(const std::filesystem::path& file) {
  // Header of the file, then of its first chunk, which holds JSON.
  std::ifstream in(file, std::ios::binary);
  std::array<char, 20> head{};
  if (!in.read(head.data(), head.size()) || std::string_view(head.data(), 4) != "glTF") return false;
  std::uintmax_t length = 0;  // of the JSON, little-endian
  for (int i = 3; i >= 0; --i) length = length << 8 | static_cast<unsigned char>(head[12 + i]);
  std::error_code unknown;
  std::string json(std::min(length, std::filesystem::file_size(file, unknown)), '\0');
  in.read(json.data(), static_cast<std::streamsize>(json.size()));
  return json.find("\"ENCAGE_cages\"") != std::string::npos;
}

}  // namespace encage::tool

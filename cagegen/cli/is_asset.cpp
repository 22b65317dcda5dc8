// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/is_asset.h"

#include "src/asset/glb.h"
#include "src/asset/view.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <span>
#include <string>
#include <system_error>

namespace encage::tool {

bool is_asset(const std::filesystem::path& file) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(file, none)) return false;  // reading a pipe would empty it
  std::ifstream in(file, std::ios::binary);
  std::string head(glb_start, '\0');
  if (!in.read(head.data(), static_cast<std::streamsize>(head.size())) || !head.starts_with("glTF")) return false;
  const std::uintmax_t wanted = glb_head_size(std::as_bytes(std::span(head)));
  head.resize(std::min(wanted, std::filesystem::file_size(file, none)), '\0');
  in.read(head.data() + glb_start, static_cast<std::streamsize>(head.size() - glb_start));
  return begins_like_asset(head);
}

}  // namespace encage::tool

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace encage::io {

enum class MeshoptMode { attributes, triangles, indices };

/// Decompresses `count` elements of `stride` bytes, as EXT_meshopt_compression and KHR_meshopt_compression define them.
/// No value if the data are damaged. `count` is above 0, for triangles a multiple of 3; `stride` is 2 or 4, for
/// attributes a multiple of 4 up to 256.
std::optional<std::vector<std::uint8_t>> decode_meshopt(MeshoptMode mode, std::span<const std::uint8_t> data,
                                                        std::size_t count, std::size_t stride);

/// Applies a filter to decompressed attributes, in place. Returns whether it knows the filter, and the filter goes with
/// the stride.
bool apply_meshopt_filter(std::string_view filter, std::vector<std::uint8_t>& elements, std::size_t stride);

}  // namespace encage::io

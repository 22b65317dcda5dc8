// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace encage::fuzz {

/// What glTF says beside the compressed data, which follow. Every value stands for a valid one.
struct MeshoptInput {
  std::uint8_t mode;    ///< attributes, triangles, indices
  std::uint8_t stride;  ///< in steps of four bytes from 4 on; of two from 2 on if these are no attributes
  std::uint8_t filter;
  std::uint8_t unused;
  std::uint16_t count;  ///< less one; of triangles or elements
};
static_assert(sizeof(MeshoptInput) == 6);

inline constexpr const char* meshopt_filters[] = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "ANOTHER"};

}  // namespace encage::fuzz

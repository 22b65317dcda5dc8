// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/render/render.h"

#include <string_view>

namespace encage::render {

// Text forms of the options, as command lines give them. Each throws Error that quotes the text and says what was
// expected.

struct Size {
  int width = 0;
  int height = 0;
};

Size parse_size(std::string_view text);  ///< "1200x900"

/// "x=0.5"; "x" alone is the middle of `bounds`.
Cut parse_cut(std::string_view text, const Eigen::AlignedBox3d& bounds);

Axis parse_axis(std::string_view text);  ///< "x", "y" or "z"

/// "azimuth,elevation[,zoom]", angles in degrees.
Camera parse_camera(std::string_view text);

Eigen::Vector3d parse_point(std::string_view text);  ///< "x,y,z"

}  // namespace encage::render

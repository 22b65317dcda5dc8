// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace encage {

/// Formats a number for messages, with as few digits as a reader needs to recognise the value.
inline std::string number_text(double value, int digits = 12) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.*g", digits, value);
  return text.data();
}

}  // namespace encage

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace encage::bench {

/// A positive number of seconds: a decimal number, or a fraction like 1/480. Throws Error that begins with `option`.
double parse_seconds(const std::string& option, const std::string& text);

}  // namespace encage::bench

// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/seconds.h"

#include <encage/error.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

namespace encage::bench {
namespace {

// NaN if it is no number.
double number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole ? value : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

double parse_seconds(const std::string& option, const std::string& text) {
  const std::string_view view(text);
  const std::size_t slash = view.find('/');
  const double seconds =
      slash == std::string_view::npos ? number(view) : number(view.substr(0, slash)) / number(view.substr(slash + 1));
  if (std::isnan(seconds)) throw Error(option + " " + text + ": not a number");
  if (!(seconds > 0) || std::isinf(seconds)) throw Error(option + " " + text + ": must be a time above 0");
  return seconds;
}

}  // namespace encage::bench

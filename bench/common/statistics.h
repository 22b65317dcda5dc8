// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace encage::bench {

/// The middle value; of an even number, the mean of the middle two; 0 of none.
double median(std::vector<double> values);

/// The mean of the medians, one for each list; a list without values counts as 0, and so does an empty argument.
double mean_of_medians(const std::vector<std::vector<double>>& lists);

/// a / b, or 0 if b is not positive: speed-ups of what was not timed.
double ratio(double a, double b);

/// e where y grows like x to the power of e, by least squares of the logarithms; 0 for fewer than two different x.
double growth_exponent(const std::vector<double>& x, const std::vector<double>& y);

/// `count` of the numbers 0 .. total - 1, as evenly spread as possible; all if there are not more.
std::vector<std::int64_t> evenly_spread(std::int64_t total, std::int64_t count);

}  // namespace encage::bench

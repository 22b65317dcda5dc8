// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace encage::bench {

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const std::size_t half = values.size() / 2;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(half);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*std::max_element(values.begin(), middle) + *middle) / 2;
}

double mean_of_medians(const std::vector<std::vector<double>>& lists) {
  double sum = 0;
  for (const std::vector<double>& values : lists) sum += median(values);
  return lists.empty() ? 0 : sum / static_cast<double>(lists.size());
}

double ratio(double a, double b) { return b > 0 ? a / b : 0; }

double growth_exponent(const std::vector<double>& x, const std::vector<double>& y) {
  const auto count = static_cast<double>(x.size());
  double u_sum = 0, v_sum = 0, uu_sum = 0, uv_sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double u = std::log(x[i]), v = std::log(y[i]);
    u_sum += u;
    v_sum += v;
    uu_sum += u * u;
    uv_sum += u * v;
  }
  const double spread = count * uu_sum - u_sum * u_sum;
  return spread > 0 ? (count * uv_sum - u_sum * v_sum) / spread : 0;
}

std::vector<std::int64_t> evenly_spread(std::int64_t total, std::int64_t count) {
  count = std::min(total, count);
  std::vector<std::int64_t> numbers;
  for (std::int64_t i = 0; i < count; ++i) numbers.push_back((2 * i + 1) * total / (2 * count));
  return numbers;
}

}  // namespace encage::bench

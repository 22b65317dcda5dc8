// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/usage.h"

#include <sys/resource.h>

namespace encage::tool {

Usage process_usage() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return {seconds(usage.ru_utime) + seconds(usage.ru_stime), usage.ru_maxrss * std::int64_t{1024}};
}

}  // namespace encage::tool

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace encage::tool {

/// What this process has used so far.
struct Usage {
  double cpu_seconds = 0;  ///< user and system, all threads
  std::int64_t peak_rss_bytes = 0;
};
Usage process_usage();

}  // namespace encage::tool

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

namespace encage {

/// Runs `work` on a thread of its own while this one calls `report`, about twelve times a second. If `report` throws,
/// `abandon` asks the work to end, and the exception passes through; otherwise that of `work` does. Throws Error if the
/// system starts no thread.
void run_reporting(const std::function<void()>& work, const std::function<void()>& report,
                   const std::function<void()>& abandon);

}  // namespace encage

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>

namespace encage::zoo {

/// How a child process ended.
struct ChildResult {
  std::string output;  ///< what `work` returned; empty if it did not end well
  std::string error;   ///< empty if it ended well
};

/// Runs `work` in a forked child and returns its string: neither a crash nor a
/// leak of it reaches the caller. What `work` throws becomes `error`. Call only
/// while this process has one thread.
ChildResult run_isolated(const std::function<std::string()>& work);

}  // namespace encage::zoo

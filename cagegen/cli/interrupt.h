// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <csignal>

namespace encage::tool {

/// Set by Ctrl-C while an InterruptScope lives; pass it on as BakeContext::cancel.
extern std::atomic<bool> interrupted;

/// Throws Cancelled if `interrupted` is set: for the steps that take no context.
void throw_if_interrupted();

/// While it lives, the first Ctrl-C sets `interrupted` instead of ending the process; a second one ends it at once. One
/// at a time.
class InterruptScope {
 public:
  InterruptScope();
  ~InterruptScope();
  InterruptScope(const InterruptScope&) = delete;
  InterruptScope& operator=(const InterruptScope&) = delete;

 private:
  struct sigaction before_ = {};
};

}  // namespace encage::tool

// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/interrupt.h"

#include <encage/error.h>

namespace encage::tool {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");

void throw_if_interrupted() {
  if (interrupted) throw Cancelled();
}

InterruptScope::InterruptScope() {
  struct sigaction action = {};
  action.sa_handler = [](int) { interrupted = true; };
  action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, &before_);
}

InterruptScope::~InterruptScope() { sigaction(SIGINT, &before_, nullptr); }

}  // namespace encage::tool

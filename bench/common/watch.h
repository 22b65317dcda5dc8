// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/cli/interrupt.h"
#include "cagegen/cli/progress.h"

#include <functional>
#include <string_view>

namespace encage::bench {

/// While it lives, progress is shown on standard error, and Ctrl-C ends the work at the next report.
class Watch {
 public:
  /// Throws Cancelled after Ctrl-C.
  void report(double fraction, std::string_view what);
  /// The same as a callback. This object has to outlive it.
  std::function<void(double fraction)> reporter(std::string_view what);
  /// For a bake. This object has to outlive it.
  BakeContext context() { return progress_.context(&tool::interrupted); }

 private:
  tool::InterruptScope scope_;
  tool::Progress progress_ = tool::Progress::on_stderr();
};

}  // namespace encage::bench

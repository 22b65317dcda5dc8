// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/bake.h>

#include <atomic>
#include <chrono>
#include <ostream>
#include <string>
#include <string_view>

namespace encage::tool {

/// Shows how far a bake is: a bar that redraws itself on a terminal, plain lines elsewhere. Not thread-safe; bake()
/// reports from the calling thread.
class Progress {
 public:
  enum class Style { bar, lines };
  using Clock = std::chrono::steady_clock;

  /// Draws at most once per `interval`. `out` has to outlive this object.
  Progress(std::ostream& out, Style style, Clock::duration interval);
  /// On standard error, as a bar if that is a terminal.
  static Progress on_stderr();

  /// Clears the bar.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(double fraction, std::string_view stage);
  /// A line of its own, above the bar.
  void note(std::string_view message);
  /// Wires both to a bake. This object has to outlive the context.
  BakeContext context(std::atomic<bool>* cancel);

 private:
  void clear();

  std::ostream& out_;
  Style style_;
  Clock::duration interval_;
  Clock::time_point last_draw_;
  std::string last_stage_;
  int last_percent_ = 0;
  bool bar_shown_ = false;
};

}  // namespace encage::tool

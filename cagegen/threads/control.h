// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/error.h>

#include <atomic>
#include <chrono>
#include <optional>

namespace encage::makers {

/// Shared by workers and the thread that called bake(): asks them to stop, and shows how far they are.
struct Control {
  const Control* whole = nullptr;  ///< of the work of which this is a part: what stops the whole stops the part
  const std::atomic<bool>* cancel = nullptr;
  std::optional<std::chrono::steady_clock::time_point> deadline;
  std::atomic<bool> out_of_time{false};
  std::atomic<double> fraction{0};     ///< of the work that is done
  std::atomic<bool> abandoned{false};  ///< stop, whatever has been reached

  bool cancelled() const {
    return abandoned.load(std::memory_order_relaxed) ||
           (cancel != nullptr && cancel->load(std::memory_order_relaxed)) || (whole != nullptr && whole->cancelled());
  }
  void throw_if_cancelled() const {
    if (cancelled()) throw Cancelled();
  }
  bool expired() {
    if (deadline && std::chrono::steady_clock::now() > *deadline) out_of_time = true;
    return out_of_time;
  }
};

}  // namespace encage::makers

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace encage {

/// Keeps the messages of workers until the thread that called bake() passes them on.
class Journal {
 public:
  /// From any thread.
  void add(std::string message) {
    const std::lock_guard lock(mutex_);
    messages_.push_back(std::move(message));
  }

  /// `log` may be empty.
  void pass_on(const std::function<void(std::string_view)>& log) {
    std::vector<std::string> messages;
    {
      const std::lock_guard lock(mutex_);
      messages.swap(messages_);
    }
    if (!log) return;
    for (const std::string& message : messages) log(message);
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> messages_;
};

}  // namespace encage

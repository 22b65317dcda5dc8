// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/threads/run_reporting.h"

#include <encage/error.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>

namespace encage {

void run_reporting(const std::function<void()>& work, const std::function<void()>& report,
                   const std::function<void()>& abandon) {
  std::mutex mutex;
  std::condition_variable changed;
  bool done = false;
  std::exception_ptr error;
  std::thread worker;
  try {
    worker = std::thread([&] {
      try {
        work();
      } catch (...) {
        error = std::current_exception();
      }
      const std::lock_guard lock(mutex);
      done = true;
      changed.notify_one();
    });
  } catch (const std::system_error& refused) {
    throw Error(std::string("bake: the system starts no thread: ") + refused.what() +
                "; a bake needs one beside the caller's");
  }
  try {
    std::unique_lock lock(mutex);
    while (!changed.wait_for(lock, std::chrono::milliseconds(80), [&] { return done; })) {
      lock.unlock();
      report();
      lock.lock();
    }
  } catch (...) {
    abandon();
    worker.join();
    throw;
  }
  worker.join();
  if (error) std::rethrow_exception(error);
}

}  // namespace encage

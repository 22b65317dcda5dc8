// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/executor.h>

#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace encage::test {

/// A plain job system: threads that take the tasks of one call at a time, together with the caller.
class ThreadPool {
 public:
  explicit ThreadPool(int threads) : size_(threads) {
    for (int i = 1; i < threads; ++i) threads_.emplace_back([this] { serve(); });
  }
  ~ThreadPool() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  Executor executor() {
    return {size_, [this](int count, TaskRef task) { run(count, task); }};
  }

 private:
  void run(int count, TaskRef task) {
    std::unique_lock lock(mutex_);
    task_ = task;
    left_ = unfinished_ = count;
    changed_.notify_all();
    take_tasks(lock);
    changed_.wait(lock, [this] { return unfinished_ == 0; });
    task_.reset();
  }
  void serve() {
    std::unique_lock lock(mutex_);
    while (!stopping_) {
      take_tasks(lock);
      changed_.wait(lock, [this] { return stopping_ || left_ > 0; });
    }
  }
  void take_tasks(std::unique_lock<std::mutex>& lock) {
    while (left_ > 0) {
      const int i = --left_;
      const TaskRef task = *task_;
      lock.unlock();
      task(i);
      lock.lock();
      if (--unfinished_ == 0) changed_.notify_all();
    }
  }

  int size_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<TaskRef> task_;
  int left_ = 0, unfinished_ = 0;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace encage::test

// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/progress.h"

#include <unistd.h>

#include <algorithm>
#include <iostream>

namespace encage::tool {

namespace {

constexpr int bar_width = 30;
constexpr int line_step = 10;  // percent between two plain lines of one stage

std::string bar(int percent) {
  const int filled = percent * bar_width / 100;
  return "[" + std::string(filled, '#') + std::string(bar_width - filled, '.') + "]";
}

}  // namespace

// The first drawing waits for an interval as well: short work shows nothing.
Progress::Progress(std::ostream& out, Style style, Clock::duration interval)
    : out_(out), style_(style), interval_(interval), last_draw_(Clock::now()) {}

Progress Progress::on_stderr() {
  using namespace std::chrono_literals;
  if (isatty(STDERR_FILENO) != 0) return Progress(std::cerr, Style::bar, 100ms);
  return Progress(std::cerr, Style::lines, 1s);
}

Progress::~Progress() { clear(); }

void Progress::update(double fraction, std::string_view stage) {
  const int percent = std::clamp(static_cast<int>(fraction * 100), 0, 100);
  const Clock::time_point now = Clock::now();
  if (now - last_draw_ < interval_) return;
  const bool new_stage = stage != last_stage_;
  if (style_ == Style::bar) {
    if (bar_shown_ && !new_stage && percent == last_percent_) return;
    // Carriage return, then erase to the end of the line.
    out_ << "\r\033[K" << bar(percent) << ' ' << percent << " % " << stage << std::flush;
    bar_shown_ = true;
  } else {
    if (!new_stage && percent < last_percent_ + line_step) return;
    out_ << percent << " % " << stage << std::endl;
  }
  last_draw_ = now;
  last_stage_ = stage;
  last_percent_ = percent;
}

void Progress::note(std::string_view message) {
  clear();
  out_ << "note: " << message << std::endl;
}

BakeContext Progress::context(std::atomic<bool>* cancel) {
  BakeContext context;
  context.progress = [this](double fraction, std::string_view stage) { update(fraction, stage); };
  context.log = [this](std::string_view message) { note(message); };
  context.cancel = cancel;
  return context;
}

void Progress::clear() {
  if (bar_shown_) out_ << "\r\033[K" << std::flush;
  bar_shown_ = false;
}

}  // namespace encage::tool

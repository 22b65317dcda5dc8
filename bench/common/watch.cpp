// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/watch.h"

namespace encage::bench {

void Watch::report(double fraction, std::string_view what) {
  progress_.update(fraction, what);
  tool::throw_if_interrupted();
}

std::function<void(double fraction)> Watch::reporter(std::string_view what) {
  return [this, what](double fraction) { report(fraction, what); };
}

}  // namespace encage::bench

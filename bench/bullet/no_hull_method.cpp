// SPDX-License-Identifier: GPL-3.0-or-later
// Stands in for hull_method.cpp where HACD is not found.
#include "bench/bullet/contact_method.h"

namespace encage::bullet_bench {

std::unique_ptr<ContactMethod> make_hull_method() { return nullptr; }

}  // namespace encage::bullet_bench

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>

// Counts what a test program allocates, and may stop it. A program that names one of these gets operators new and
// delete that do so.

extern std::atomic<long> allocations;       ///< so far
extern std::atomic<long> allocations_left;  ///< after so many more there is no memory; negative: always enough

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>

// Counts the allocations of a test program, and can make them fail. A program that uses one of these variables gets
// operators new and delete that do so.

extern std::atomic<long> allocations;       ///< so far
extern std::atomic<long> allocations_left;  ///< number of allocations until memory runs out; negative: unlimited

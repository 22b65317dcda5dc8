// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/stress/run.h"

#include <string>
#include <vector>

namespace encage::stress {

/// The stress runs of Nested Cages (figures 1, 9, 10, 13, 15, 21, 22), on the models of Debian's libcgal-demo and on
/// shapes made here.
std::vector<Job> all_jobs();

/// The names of the jobs, each once, in their order.
std::vector<std::string> job_names();

/// Moves every vertex along its normal, by a random share in [-1, 1] of `amplitude`. Always the same result.
TriangleMesh with_noise(const TriangleMesh& mesh, double amplitude);

}  // namespace encage::stress

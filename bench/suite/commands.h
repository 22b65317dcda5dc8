// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/common/command.h"

// The subcommands of encage-bench.

namespace encage::assets {
bench::Command command();
}
namespace encage::distances {
bench::Command command();
}
namespace encage::handmade {
bench::Command command();
}
namespace encage::queries {
bench::Command command();
}
namespace encage::scale {
bench::Command command();
}
namespace encage::threads {
bench::Command command();
}
namespace encage::twins {
bench::Command command();
}
namespace encage::zoo {
bench::Command triplets_command();
}

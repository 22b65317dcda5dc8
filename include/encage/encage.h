// SPDX-License-Identifier: Apache-2.0
#pragma once

// Run-time side of Encage. The offline side is <encage/bake.h>.

#include <encage/asset.h>
#include <encage/broadphase.h>
#include <encage/cage.h>
#include <encage/error.h>
#include <encage/executor.h>
#include <encage/mesh.h>
#include <encage/shape_cache.h>
#include <encage/version.h>
#include <encage/world.h>

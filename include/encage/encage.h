// SPDX-License-Identifier: Apache-2.0
#pragma once

// All of the run time. The offline side is <encage/bake.h>; adapters are <encage/bullet.h>, <encage/bullet_mesh.h>,
// <encage/fcl.h> and <encage/jolt.h>.

#include <encage/asset.h>
#include <encage/cage.h>
#include <encage/casts.h>
#include <encage/contact.h>
#include <encage/distance.h>
#include <encage/error.h>
#include <encage/executor.h>
#include <encage/fine_lease.h>
#include <encage/height_field.h>
#include <encage/manifold.h>
#include <encage/mass_properties.h>
#include <encage/mesh.h>
#include <encage/poses.h>
#include <encage/primitives.h>
#include <encage/queries.h>
#include <encage/rigid_pose.h>
#include <encage/self.h>
#include <encage/separated.h>
#include <encage/shape.h>
#include <encage/shape_cache.h>
#include <encage/shape_mesh.h>
#include <encage/split_motion.h>
#include <encage/version.h>
#include <encage/world.h>
#include <encage/world_contacts.h>
#include <encage/world_queries.h>

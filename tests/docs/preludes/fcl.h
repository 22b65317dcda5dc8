// SPDX-License-Identifier: GPL-3.0-or-later
// needs: fcl
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/broadphase/default_broadphase_callbacks.h>
#include <fcl/geometry/bvh/BVH_model.h>
fcl::DynamicAABBTreeCollisionManagerd manager;

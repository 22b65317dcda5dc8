// SPDX-License-Identifier: GPL-3.0-or-later
// needs: ode
// scope: namespace
#include <algorithm>
#include <array>
#include <span>
encage::ShapePtr shape;
encage::ManifoldCache cache;
const encage::Shape& shape_of(dGeomID) { return *shape; }
encage::Motion motion_of(dGeomID) { return {}; }
encage::ManifoldCache& cache_of(dGeomID, dGeomID) { return cache; }
int mesh_class = 0;

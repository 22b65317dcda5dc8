// SPDX-License-Identifier: GPL-3.0-or-later
// needs: ode
// scope: namespace
double rounding = 0;
encage::ShapePtr shape;
const encage::Shape& shape_of(dGeomID) { return *shape; }
encage::Motion motion_of(dGeomID) { return {}; }
void add_joints(void*, const dContactGeom*, int) {}

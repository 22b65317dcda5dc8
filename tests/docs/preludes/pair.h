// SPDX-License-Identifier: GPL-3.0-or-later
encage::ShapePtr shape_a, shape_b;
encage::Motion motion_a, motion_b;
double margin = 0;

// SPDX-License-Identifier: GPL-3.0-or-later
// needs: bullet
btTriangleIndexVertexArray arrays;
btSequentialImpulseConstraintSolver solver;

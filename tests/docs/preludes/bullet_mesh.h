// SPDX-License-Identifier: GPL-3.0-or-later
// needs: bullet
btScalar mass = 1;
btSequentialImpulseConstraintSolver solver;

// SPDX-License-Identifier: GPL-3.0-or-later
Eigen::Isometry3d pose_a, pose_b, next_pose_a;

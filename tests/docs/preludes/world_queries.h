// SPDX-License-Identifier: GPL-3.0-or-later
encage::World world;
encage::BodyId self = encage::BodyId::none;
auto hit_by_explosion = [](encage::BodyId body) { static_cast<void>(body); };

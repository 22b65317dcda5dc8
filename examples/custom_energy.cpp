// SPDX-License-Identifier: GPL-3.0-or-later
// Bakes a cage with an energy of its own: as little as possible of the cage shall reach below the floor on which the
// model stands.
#include <encage/bake.h>

#include <cstdio>
#include <memory>

namespace {

/// The volume, plus a penalty: the squared depth of every vertex below the floor.
class FloorEnergy : public encage::CageEnergy {
 public:
  FloorEnergy(double floor, double weight) : floor_(floor), weight_(weight) {}

  std::string name() const override { return "floor"; }

  double value(const encage::EnergyState& state) const override {
    return volume_->value(state) + weight_ * (state.cage.col(2).array() - floor_).min(0).square().sum();
  }

  encage::Vertices gradient(const encage::EnergyState& state) const override {
    encage::Vertices gradient = volume_->gradient(state);
    gradient.col(2).array() += 2 * weight_ * (state.cage.col(2).array() - floor_).min(0);
    return gradient;
  }

 private:
  double floor_;   // its z coordinate, in the frame of the cages
  double weight_;  // a length, as value() is a volume
  encage::EnergyPtr volume_ = encage::volume_energy();
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) return std::fprintf(stderr, "usage: custom_energy MODEL OUT.glb\n"), 2;
  const encage::SourceMesh source = encage::sanitize(encage::read_mesh(argv[1]));
  const double floor = encage::bounds(source.obstacle).min().z();

  encage::BakeOptions options;
  options.method = encage::BakeMethod::flow;
  options.faces = {60};
  for (const bool own : {false, true}) {
    if (own) options.energy_final = std::make_shared<FloorEnergy>(floor, 10 * source.diagonal);
    const encage::CageHierarchy cages = encage::bake(source, options, {});
    const double lowest = encage::bounds(cages.levels.front().mesh).min().z();
    std::printf("energy %s: reaches %.4f diagonals below the floor\n", own ? "floor" : "volume",
                (floor - lowest) / source.diagonal);
    if (own) encage::write_certified_asset(argv[2], cages);
  }
} catch (const encage::Error& error) {
  return std::fprintf(stderr, "custom_energy: %s\n", error.what()), 2;
}

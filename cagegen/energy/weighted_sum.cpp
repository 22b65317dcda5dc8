// SPDX-License-Identifier: GPL-3.0-or-later
#include <encage/energy.h>
#include <encage/error.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string>
#include <utility>

namespace encage {

namespace {

constexpr int unit_degree = 3;  // of a volume

std::string shortest(double number) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr};
}

double diagonal(const Vertices& vertices) {
  return (vertices.colwise().maxCoeff() - vertices.colwise().minCoeff()).norm();
}

class WeightedSum final : public CageEnergy {
 public:
  explicit WeightedSum(std::vector<WeightedEnergy> terms) : terms_(std::move(terms)) {}

  std::string name() const override {
    std::string result;
    for (const WeightedEnergy& term : terms_) {
      if (!result.empty()) result += '+';
      if (term.weight != 1) result += shortest(term.weight) + '*';
      result += term.energy->name();
    }
    return result;
  }
  int degree() const override { return unit_degree; }

  double value(const EnergyState& state) const override {
    double sum = 0;
    for (const WeightedEnergy& term : terms_) sum += factor(term, state) * term.energy->value(state);
    return sum;
  }

  Vertices gradient(const EnergyState& state) const override {
    Vertices sum = Vertices::Zero(state.cage.rows(), 3);
    for (const WeightedEnergy& term : terms_) sum += factor(term, state) * term.energy->gradient(state);
    return sum;
  }

 private:
  static double factor(const WeightedEnergy& term, const EnergyState& state) {
    return term.weight * std::pow(diagonal(state.rest.vertices), unit_degree - term.energy->degree());
  }

  std::vector<WeightedEnergy> terms_;
};

/// A term of find_energy(): a name, or a weight, an asterisk and a name.
WeightedEnergy find_term(std::string_view text) {
  const std::size_t times = text.find('*');
  if (times == std::string_view::npos) return {1, find_energy(text)};
  const std::string_view number = text.substr(0, times);
  double weight = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), weight);
  if (error != std::errc() || end != number.data() + number.size()) {
    throw Error("energy '" + std::string(text) + "': '" + std::string(number) + "' is not a number");
  }
  return {weight, find_energy(text.substr(times + 1))};
}

}  // namespace

EnergyPtr weighted_sum(std::vector<WeightedEnergy> terms) {
  if (terms.empty()) throw Error("weighted_sum: no energies");
  for (const WeightedEnergy& term : terms) {
    if (!term.energy) throw Error("weighted_sum: no energy for the weight " + shortest(term.weight));
    if (!(term.weight > 0) || std::isinf(term.weight)) {
      throw Error("energy '" + term.energy->name() + "': the weight " + shortest(term.weight) +
                  " is not positive and finite");
    }
  }
  if (terms.size() == 1 && terms[0].weight == 1) return terms[0].energy;
  return std::make_shared<WeightedSum>(std::move(terms));
}

EnergyPtr find_energy(std::string_view name) {
  if (name.find_first_of("+*") == std::string_view::npos) {
    std::string known;
    for (const EnergyPtr& energy : {start_energy(), step_energy(), volume_energy(), surface_arap_energy()}) {
      if (energy->name() == name) return energy;
      known += (known.empty() ? "" : ", ") + energy->name();
    }
    throw Error("no energy is called '" + std::string(name) + "'; known: " + known +
                ", and sums such as volume+0.1*sarap");
  }
  std::vector<WeightedEnergy> terms;
  for (std::size_t begin = 0; begin <= name.size();) {
    // A plus sign after an 'e' belongs to the weight: 1e+3*volume.
    std::size_t end = name.find('+', begin);
    while (end != std::string_view::npos && end > begin + 1 && name[end - 1] == 'e' &&
           std::isdigit(static_cast<unsigned char>(name[end - 2])) != 0) {
      end = name.find('+', end + 1);
    }
    end = std::min(end, name.size());
    terms.push_back(find_term(name.substr(begin, end - begin)));
    begin = end + 1;
  }
  return weighted_sum(std::move(terms));
}

}  // namespace encage

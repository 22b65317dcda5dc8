// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/compare.h"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

namespace encage::tank {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

using Numbers = std::pair<std::int32_t, std::int32_t>;

const BodyContact* find(const Detection& detection, const Numbers& pair) {
  const auto at = std::lower_bound(
      detection.contacts.begin(), detection.contacts.end(), pair,
      [](const BodyContact& contact, const Numbers& p) { return Numbers(contact.body_a, contact.body_b) < p; });
  const bool found = at != detection.contacts.end() && Numbers(at->body_a, at->body_b) == pair;
  return found ? &*at : nullptr;
}

bool same(const BodyContact* s, const BodyContact* t) {
  if (!s || !t) return s == t;
  return s->contact.time == t->contact.time && s->contact.kind == t->contact.kind &&
         s->contact.vertices == t->contact.vertices;
}

}  // namespace

Faults& Faults::operator+=(const Faults& other) {
  missed += other.missed;
  spurious += other.spurious;
  return *this;
}

std::vector<Faults> compare(const bench::RecordedStep& step, const std::vector<const Detection*>& answers,
                            const Judge& judge) {
  std::set<Numbers> pairs;
  for (const Detection* answer : answers) {
    for (const BodyContact& contact : answer->contacts) pairs.emplace(contact.body_a, contact.body_b);
  }
  std::vector<Faults> faults(answers.size());
  for (const Numbers& pair : pairs) {
    std::vector<const BodyContact*> contacts;
    for (const Detection* answer : answers) contacts.push_back(find(*answer, pair));
    std::vector<double> real;  // time of each contact, infinity for none
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const auto known = std::find_if(contacts.begin(), contacts.begin() + static_cast<std::ptrdiff_t>(i),
                                      [&](const BodyContact* contact) { return same(contact, contacts[i]); });
      const auto k = static_cast<std::size_t>(known - contacts.begin());
      real.push_back(k < i ? real[k] : contacts[i] ? judge(step, *contacts[i]).value_or(never) : never);
    }
    const double earliest = *std::min_element(real.begin(), real.end());
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const double answer = contacts[i] ? contacts[i]->contact.time : never;
      if (answer > earliest) ++faults[i].missed;
      if (contacts[i] && answer < real[i] - time_tolerance) ++faults[i].spurious;
    }
  }
  return faults;
}

}  // namespace encage::tank

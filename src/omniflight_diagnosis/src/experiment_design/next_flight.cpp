#include "next_flight.hpp"

#include <algorithm>

#include "../search/single_rotor.hpp"
#include "propose.hpp"

namespace omniflight::diagnosis {
namespace {

/// Effect `id` with the parameters of the most probable set that contains it, preferably one without
/// `without`.
std::optional<physics::ActiveEffect> at_its_likeliest(const Inference& in, const std::string& id,
                                                      const std::string& without) {
  const auto id_of = [&](const SetMember& m) {
    return in.hypotheses[static_cast<std::size_t>(m.hypothesis)].id;
  };
  std::optional<physics::ActiveEffect> out;
  std::pair<bool, double> best{false, -1};
  for (const SetPosterior& s : in.posterior.sets) {
    const SetMember* own = nullptr;
    bool beside = false;
    for (const SetMember& m : s.members) {
      if (id_of(m) == id) own = &m;
      beside = beside || id_of(m) == without;
    }
    const std::pair<bool, double> rank{!beside, s.probability};
    if (own == nullptr || !(rank > best)) continue;
    const Hypothesis& h = in.hypotheses[static_cast<std::size_t>(own->hypothesis)];
    if (h.effect == nullptr) continue;
    best = rank;
    out = in_full({h.effect, own->theta});
  }
  return out;
}

}  // namespace

void add_next_flight(const Inference& in, std::span<const Flight* const> flights,
                     const vehicle::Vehicle& vehicle, const Options& o, Diagnosis& d) {
  std::vector<Rivals> pairs;
  std::vector<std::pair<std::string, std::string>> unpredicted;
  for (const Finding& f : d.findings) {
    if (f.rivals == 0) continue;
    const auto model = std::find_if(d.model.begin(), d.model.end(), [&](const physics::ActiveEffect& m) {
      return m.effect->info().id == f.effect;
    });
    if (model == d.model.end()) continue;
    if (const std::string& how = model->effect->info().separated_by; !how.empty())
      d.next_flight.manoeuvres.push_back(how);
    for (const std::string& other : f.cannot_be_told_apart_from) {
      const auto rival = at_its_likeliest(in, other, f.effect);
      if (!rival) {
        unpredicted.emplace_back(f.effect, other);
        continue;
      }
      pairs.push_back({*model, *rival});
      d.next_flight.separates.emplace_back(f.effect, other);
    }
  }
  d.next_flight.separates.insert(d.next_flight.separates.end(), unpredicted.begin(), unpredicted.end());
  if (pairs.empty() || o.stopped()) return;
  d.next_flight.proposed = propose_flights(*in.problem, *in.noise, *flights.front(), vehicle, pairs, o);
}

}  // namespace omniflight::diagnosis

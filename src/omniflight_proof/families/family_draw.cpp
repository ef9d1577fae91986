#include "family_draw.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "family_aliases.hpp"
#include "seal.hpp"

namespace omniflight::proof {
namespace {

using Weighted = std::vector<std::pair<const char*, double>>;

const char* pick(BoxRandom& random, const Weighted& from) {
  double sum = 0;
  for (const auto& [word, weight] : from) sum += weight;
  double at = static_cast<double>(random.bits() >> 11) * 0x1.0p-53 * sum;
  for (const auto& [word, weight] : from)
    if ((at -= weight) < 0) return word;
  return from.back().first;
}

constexpr double kUnseenShare = 0.12;  ///< of each coordinate that has an unseen value, in a sealed run

/// Deals in random order, shuffles anew when all are dealt.
class Deck {
 public:
  Deck(std::size_t count, Random random) : random_(random) {
    for (std::size_t k = 0; k < count; ++k) cards_.push_back(k);
  }
  std::size_t next() {
    if (left_ == 0) {
      for (std::size_t k = cards_.size(); k > 1; --k) std::swap(cards_[k - 1], cards_[random_.next() % k]);
      left_ = cards_.size();
    }
    return cards_[--left_];
  }

 private:
  std::vector<std::size_t> cards_;
  Random random_;
  std::size_t left_ = 0;
};

bool wanted(const std::vector<std::string>& only, const std::string& word) {
  return only.empty() || std::find(only.begin(), only.end(), word) != only.end();
}

struct Dealer {
  const FamilyDrawOptions& options;
  BoxRandom random;
  std::vector<std::string> ids;       ///< that may be hidden
  std::vector<std::size_t> unknowns;  ///< into hidden_effects()
  std::map<std::string, std::vector<std::size_t>> realisations;
  std::map<std::string, std::size_t> turn;

  explicit Dealer(const FamilyDrawOptions& o) : options(o), random(draw(o.salt, "families"), o.box) {
    const auto& all = hidden_effects();
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (all[k].unseen && o.box == Box::tuning) continue;
      if (!wanted(o.effects, all[k].id)) continue;
      if (all[k].id == "unknown")
        unknowns.push_back(k);
      else
        realisations[all[k].id].push_back(k);
    }
    for (const auto& [id, list] : realisations) {
      ids.push_back(id);
      turn[id] = random.index(list.size());
    }
  }

  bool possible(std::size_t k, const Coordinates& where) const {
    const Hidden& h = hidden_effects()[k];
    if (!h.possible) return true;
    FamilyVehicle some;  // what `possible` asks about depends on the kind of vehicle alone
    BoxRandom any(Random(1), Box::tuning);
    auto vehicle = draw_vehicle(where, any);
    return vehicle && h.possible(*vehicle, where);
  }

  /// Coordinates in which all of these can be hidden; false when many draws found none.
  bool place(FamilyPlan& plan) {
    for (int k = 0; k < 400; ++k) {
      plan.where = draw_coordinates(random, options);
      if (std::all_of(plan.hidden.begin(), plan.hidden.end(),
                      [&](std::size_t h) { return possible(h, plan.where); }))
        return true;
    }
    return false;
  }

  std::size_t realise(const std::string& id) {
    return realisations[id][turn[id]++ % realisations[id].size()];
  }
};

/// What follows from where a case stands and what is hidden in it.
void finish(FamilyPlan& p) {
  bool slow = false;
  for (const std::size_t h : p.hidden) slow = slow || hidden_effects()[h].slow;
  if (slow) p.where.length = std::min(p.where.length, 75.0);  // joints take long to integrate
  p.unseen = unseen_of(p.where);
  for (const std::size_t h : p.hidden)
    if (hidden_effects()[h].unseen) p.unseen.emplace_back("mechanism");
}

/// Times that a case is drawn in another place before its effect is realised in another way.
constexpr int kOtherRealisation = 6;

double some_sigma(BoxRandom& random) {
  const double at = static_cast<double>(random.bits() >> 11) * 0x1.0p-53;
  return at < 0.25 ? kSigmas[0] : at < 0.65 ? kSigmas[1] : kSigmas[2];
}

/// Two or three that do not stand for each other; at most one with joints.
void combine(Dealer& dealer, FamilyPlan& plan, std::size_t first, int count) {
  plan.hidden = {first};
  const auto& all = hidden_effects();
  for (int tries = 0; static_cast<int>(plan.hidden.size()) < count && tries < 500; ++tries) {
    const std::size_t k = dealer.realise(dealer.ids[dealer.random.index(dealer.ids.size())]);
    if (!all[k].combines) continue;
    const bool clash = std::any_of(plan.hidden.begin(), plan.hidden.end(), [&](std::size_t other) {
      const auto one = family_names(all[k].id, plan.where), two = family_names(all[other].id, plan.where);
      const bool listed =
          std::find(all[other].along.begin(), all[other].along.end(), all[k].id) != all[other].along.end() ||
          std::find(all[k].along.begin(), all[k].along.end(), all[other].id) != all[k].along.end();
      return one == two || listed || (all[k].slow && all[other].slow);
    });
    if (!clash) plan.hidden.push_back(k);
  }
}

}  // namespace

std::vector<std::string> unseen_of(const Coordinates& c) {
  std::vector<std::string> out;
  if (c.vehicle == kUnseenVehicle) out.emplace_back("vehicle");
  if (c.controller == "sliding") out.emplace_back("controller");
  if (c.manoeuvre == "helix") out.emplace_back("manoeuvre");
  if (c.turbulence == "bursts") out.emplace_back("turbulence");
  return out;
}

Coordinates draw_coordinates(BoxRandom& random, const FamilyDrawOptions& o) {
  const bool sealed = o.box == Box::sealed;
  const auto unseen = [&] { return sealed && random.chance(kUnseenShare); };
  Coordinates c;
  if (!o.vehicles.empty())
    c.vehicle = o.vehicles[random.index(o.vehicles.size())];
  else
    c.vehicle = unseen() ? kUnseenVehicle : kFamilyVehicles[random.index(std::size(kFamilyVehicles))];
  c.controller = unseen() ? "sliding" : pick(random, {{"geometric", 45}, {"cascade", 35}, {"indi", 20}});
  c.told_gains = c.controller == "geometric" ? pick(random, {{"told", 60}, {"wrong", 10}, {"not told", 30}})
                 : c.controller == "cascade" ? pick(random, {{"told", 30}, {"not told", 70}})
                                             : "not told";
  c.start = pick(random, {{"rest", 40}, {"in flight", 40}, {"segments", 20}});
  c.manoeuvre =
      unseen()
          ? "helix"
          : pick(random,
                 {{"T1", 10}, {"T2", 14}, {"eight", 16}, {"multisine", 20}, {"designed", 22}, {"pilot", 18}});
  const bool morphs = c.vehicle == "omnimorph";
  c.signals = pick(random, {{"imu+speed", 50},
                            {"imu+command", 14},
                            {"speed", 12},
                            {"command", 6},
                            {"imu+duty", morphs ? 0 : 12},
                            {"duty", morphs ? 0 : 6}});
  c.reference = random.chance(0.75);
  c.turbulence = unseen() ? "bursts" : pick(random, {{"ou", 45}, {"dryden", 30}, {"heavy", 25}});
  c.noise = pick(random, {{"white", 60}, {"coloured", 25}, {"outliers", 15}});
  c.calibration = pick(random, {{"exact", 25}, {"told", 45}, {"not told", 30}});
  const std::string length = pick(random, {{"short", 10}, {"usual", 75}, {"long", 15}});
  c.length = length == "short"   ? random.between(10, 25)
             : length == "usual" ? random.between(30, 90)
                                 : random.between_log(90, 240);
  if ((c.manoeuvre == "T1" || c.manoeuvre == "T2" || c.manoeuvre == "designed") && c.length < 35)
    c.length += 25;
  c.length = std::min(c.length, o.longest);
  const bool quick = c.length < 60 && random.chance(0.2);
  c.imu_hz = quick ? 1000 : std::vector<double>{100, 250, 250, 500}[random.index(4)];
  c.pose_hz = std::vector<double>{50, 100, 125, 250}[random.index(4)];
  if (!c.imu() && c.pose_hz < 100) c.pose_hz = 100;
  c.speed_hz = std::vector<double>{50, 100, 125, 250, 500}[random.index(5)];
  c.low = random.chance(0.25);
  c.tilt = "none";
  if (morphs) {
    c.tilt = random.chance(0.35) ? "moves" : "fixed";
    c.alpha_deg = std::vector<double>{20, 30, 42, 54.7356}[random.index(4)];
    if (c.tilt == "moves") c.alpha_deg = std::clamp(c.alpha_deg, 25.0, 42.0);
  }
  return c;
}

FamilyPlan draw_again(const FamilyPlan& plan, const FamilyDrawOptions& options, int attempt) {
  Dealer dealer(options);
  dealer.random = BoxRandom(draw(options.salt, plan.id + fmt::format(" again {}", attempt)), options.box);
  FamilyPlan out = plan;
  if (attempt >= kOtherRealisation)  // this one cannot be flown anywhere: the next of the same effect
    for (std::size_t& h : out.hidden) {
      const auto& same = dealer.realisations[hidden_effects()[h].id];
      const auto at = std::find(same.begin(), same.end(), h) - same.begin();
      if (!same.empty()) h = same[(static_cast<std::size_t>(at) + 1) % same.size()];
    }
  if (!dealer.place(out)) return plan;
  finish(out);
  return out;
}

Result<std::vector<FamilyPlan>> draw_families(const FamilyDrawOptions& o) {
  Dealer dealer(o);
  if (o.cases > 0 && dealer.ids.empty() && dealer.unknowns.empty())
    return bad_input("none of these effects can be hidden", "--effects", "Give ids of `omniflight effects`");
  std::vector<FamilyPlan> out;
  Deck ids(std::max<std::size_t>(1, dealer.ids.size()), draw(o.salt, "ids"));
  Deck firsts(std::max<std::size_t>(1, dealer.ids.size()), draw(o.salt, "firsts"));
  Deck unknowns(std::max<std::size_t>(1, dealer.unknowns.size()), draw(o.salt, "unknowns"));
  // of twenty: thirteen single, three pairs, two triples, two from no library
  static const char cycle[] = "SSPSUSSTSSPSSUSSTSPS";
  for (int k = 0; k < o.cases; ++k) {
    FamilyPlan plan;
    plan.sigma = some_sigma(dealer.random);
    char place = cycle[k % 20];
    if (dealer.ids.empty()) place = 'U';
    if (dealer.unknowns.empty() && place == 'U') place = 'S';
    for (int tries = 0; tries < 60; ++tries) {
      if (place == 'U') {
        plan.kind = Kind::unknown;
        plan.hidden = {dealer.unknowns[unknowns.next()]};
      } else {
        const std::size_t first = dealer.realise(dealer.ids[place == 'S' ? ids.next() : firsts.next()]);
        plan.hidden = {first};
        plan.kind = Kind::single;
        if (place != 'S') {
          if (!hidden_effects()[first].combines) continue;
          combine(dealer, plan, first, place == 'P' ? 2 : 3);
          plan.kind = plan.hidden.size() == 3   ? Kind::triple
                      : plan.hidden.size() == 2 ? Kind::pair
                                                : Kind::single;
        }
      }
      if (dealer.place(plan)) break;
      plan.hidden.clear();
    }
    if (plan.hidden.empty())
      return bad_input("no family was found in which what is asked for can be hidden",
                       "--effects, --vehicles", "Allow more of either");
    out.push_back(plan);
  }
  for (int k = 0; k < o.nulls; ++k) {
    FamilyPlan plan;
    plan.where = draw_coordinates(dealer.random, o);
    if (k % 4 == 3) {
      plan.kind = Kind::decoy;
      plan.decoy = std::vector<const char*>{"quick flight", "retuned controller", "noisy sensors",
                                            "slow turbulence", "strong turbulence"}[dealer.random.index(5)];
    }
    out.push_back(plan);
  }
  for (FamilyPlan& p : out) finish(p);
  Random shuffle = draw(o.salt, "families order");
  for (std::size_t k = out.size(); k > 1; --k) std::swap(out[k - 1], out[shuffle.next() % k]);
  for (std::size_t k = 0; k < out.size(); ++k) out[k].id = fmt::format("case-{:04}", k + 1);
  return out;
}

}  // namespace omniflight::proof

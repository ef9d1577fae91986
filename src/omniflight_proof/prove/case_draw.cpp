#include "case_draw.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "case_aliases.hpp"
#include "seal.hpp"

namespace omniflight::proof {
namespace {

/// Deals what it was given in random order, and shuffles anew when it is used up.
template <class T>
class Deck {
 public:
  Deck(std::vector<T> cards, Random random) : cards_(std::move(cards)), random_(random) {}
  bool empty() const { return cards_.empty(); }
  T next() {
    if (left_ == 0) {
      for (std::size_t k = cards_.size(); k > 1; --k) std::swap(cards_[k - 1], cards_[random_.next() % k]);
      left_ = cards_.size();
    }
    return cards_[--left_];
  }

 private:
  std::vector<T> cards_;
  Random random_;
  std::size_t left_ = 0;
};

struct Card {
  std::size_t mechanism;
  double magnitude;
};

class Dealer {
 public:
  Dealer(const DrawOptions& o, const std::vector<Mechanism>& m)
      : options_(o),
        mechanisms_(m),
        magnitudes_(o.sealed ? std::vector<double>{0.3, 1.0, 0.1} : std::vector<double>{0.4, 1.3, 0.15}),
        simple_(cards([](const Mechanism& k) { return k.level == "L1"; }, magnitudes_),
                draw(o.salt, "deck L1")),
        noisy_(cards([](const Mechanism& k) { return k.level == "L1"; }, magnitudes_),
               draw(o.salt, "deck L2")),
        different_(cards([](const Mechanism& k) { return k.level == "L3"; }, magnitudes_),
                   draw(o.salt, "deck L3")),
        tethered_(cards([](const Mechanism& k) { return k.level != "L5" && !k.needs_tilt; }, magnitudes_),
                  draw(o.salt, "deck repeats")),
        unknown_(cards([](const Mechanism& k) { return k.level == "L5"; }, {magnitudes_[0], magnitudes_[1]}),
                 draw(o.salt, "deck L5")),
        flights_({"designed", "designed", "designed", "designed", "designed", "designed", "T2", "T1"},
                 draw(o.salt, "deck flights")),
        null_flights_({"designed", "T2", "T1"}, draw(o.salt, "deck null flights")),
        decoys_({"quick flight", kRetuned, "noisy sensors", "slow turbulence", "strong turbulence"},
                draw(o.salt, "deck decoys")),
        random_(draw(o.salt, "combinations")) {}

  CasePlan single(const std::string& level) {
    const Card c = level == "L2" ? noisy_.next() : level == "L3" ? different_.next() : simple_.next();
    CasePlan p{.level = level,
               .flight = flights_.next(),
               .decoy = {},
               .kind = Kind::single,
               .magnitude = c.magnitude,
               .parts = {c.mechanism},
               .nuisances = level == "L2"};
    if (mechanisms_[c.mechanism].needs_tilt) p.flight = "designed";
    return p;
  }
  /// The thesis's flights in full nuisance.
  CasePlan repeat() {
    const Card c = tethered_.next();
    return {.level = "L2",
            .flight = random_.uniform() < 0.5 ? "T1" : "T2",
            .decoy = {},
            .kind = Kind::single,
            .magnitude = c.magnitude,
            .parts = {c.mechanism},
            .nuisances = true};
  }
  CasePlan combination(int count) {
    std::vector<std::size_t> pool, chosen;
    for (std::size_t k = 0; k < mechanisms_.size(); ++k)
      if (mechanisms_[k].combines) pool.push_back(k);
    while (static_cast<int>(chosen.size()) < count && !pool.empty()) {
      const auto at = static_cast<std::size_t>(random_.next() % pool.size());
      const std::size_t k = pool[at];
      pool.erase(pool.begin() + static_cast<std::ptrdiff_t>(at));
      const bool twice = std::any_of(chosen.begin(), chosen.end(), [&](std::size_t other) {
        return merged(mechanisms_[other].id, "designed") == merged(mechanisms_[k].id, "designed") ||
               (mechanisms_[other].articulated && mechanisms_[k].articulated);
      });
      if (!twice) chosen.push_back(k);
    }
    const double magnitude = random_.uniform() < 0.4 ? magnitudes_[0] : magnitudes_[1];
    return {.level = "L4",
            .flight = "designed",
            .decoy = {},
            .kind = count == 2 ? Kind::pair : Kind::triple,
            .magnitude = magnitude,
            .parts = chosen,
            .nuisances = false};
  }
  CasePlan unknown() {
    const Card c = unknown_.next();
    return {.level = "L5",
            .flight = "designed",
            .decoy = {},
            .kind = Kind::unknown,
            .magnitude = c.magnitude,
            .parts = {c.mechanism},
            .nuisances = false};
  }
  CasePlan nominal(int k) {
    CasePlan p{.level = "L6",
               .flight = null_flights_.next(),
               .decoy = {},
               .kind = Kind::null,
               .magnitude = 0,
               .parts = {},
               .nuisances = k % 4 == 1};
    if (k % 4 == 3) {
      p.kind = Kind::decoy;
      p.decoy = decoys_.next();
      if (p.decoy == "quick flight") p.flight = "designed";
    }
    return p;
  }

 private:
  template <class Choice>
  std::vector<Card> cards(Choice choice, const std::vector<double>& magnitudes) const {
    std::vector<Card> out;
    for (std::size_t k = 0; k < mechanisms_.size(); ++k)
      if (choice(mechanisms_[k]))
        for (const double m : magnitudes) out.push_back({k, m});
    return out;
  }
  const DrawOptions& options_;
  const std::vector<Mechanism>& mechanisms_;
  std::vector<double> magnitudes_;
  Deck<Card> simple_, noisy_, different_, tethered_, unknown_;
  Deck<std::string> flights_, null_flights_, decoys_;
  Random random_;
};

}  // namespace

std::vector<CasePlan> draw_cases(const DrawOptions& o, const std::vector<Mechanism>& mechanisms) {
  Dealer dealer(o, mechanisms);
  std::vector<CasePlan> out;
  // places of a cycle of 24: 9 single, 3 with nuisances, 3 different, 3 + 2 combined, 2 unknown, 2 repeats
  static const char cycle[] = "SDSPSNSUSRSTSDSPSNPDTNUR";
  for (int k = 0; k < o.cases; ++k) {
    const char place = o.level == "L1"   ? 'S'
                       : o.level == "L2" ? (k % 3 == 2 ? 'R' : 'N')
                       : o.level == "L3" ? 'D'
                       : o.level == "L4" ? (k % 5 < 3 ? 'P' : 'T')
                       : o.level == "L5" ? 'U'
                       : o.level == "L6" ? '0'
                                         : cycle[k % 24];
    switch (place) {
      case 'S':
        out.push_back(dealer.single("L1"));
        break;
      case 'N':
        out.push_back(dealer.single("L2"));
        break;
      case 'D':
        out.push_back(dealer.single("L3"));
        break;
      case 'R':
        out.push_back(dealer.repeat());
        break;
      case 'P':
        out.push_back(dealer.combination(2));
        break;
      case 'T':
        out.push_back(dealer.combination(3));
        break;
      case 'U':
        out.push_back(dealer.unknown());
        break;
      default:
        out.push_back(dealer.nominal(k));
        break;
    }
  }
  for (int k = 0; k < o.nulls; ++k) out.push_back(dealer.nominal(k));
  // gains are told: as many effects fly retuned as nominal flights do, so that they give nothing away
  Random retuned = draw(o.salt, "retuned");
  for (CasePlan& plan : out)
    if (!plan.parts.empty() && retuned.uniform() < kDecoyShare / kDecoys) plan.decoy = kRetuned;
  Random shuffle = draw(o.salt, "order");
  for (std::size_t k = out.size(); k > 1; --k) std::swap(out[k - 1], out[shuffle.next() % k]);
  for (std::size_t k = 0; k < out.size(); ++k) out[k].id = fmt::format("case-{:04}", k + 1);
  return out;
}

}  // namespace omniflight::proof

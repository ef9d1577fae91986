#include <algorithm>
#include <array>
#include <cmath>

#include "../numerics/parallel.hpp"
#include "grid_search.hpp"
#include "posterior.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr int kNeighbourRounds = 4;  ///< of neighbours of the best set
constexpr double kNearSet = 5;       ///< nat: what is this far behind has less than a hundredth of the mass
constexpr double kGridShare = 0.3;   ///< of a gain, at the best point of a grid at least
constexpr std::size_t kMostAdditions = 4;  ///< fitted a round
constexpr std::size_t kMostExchanges = 4;  ///< fitted a member and round
constexpr std::size_t kMostSwings = 6;     ///< points of a grid at which a law with initial states is fitted

class Search {
 public:
  Search(const Evidence& evidence, GridSearch& grid, const SearchLimits& limits)
      : evidence_(evidence), grid_(grid), limits_(limits) {}

  Posterior run(const std::vector<SetMember>& seed) {
    Posterior out;
    fits_[{}] = std::make_unique<SetFit>(evidence_.fit({}));  // also when there is no time for any other
    out.nothing = *fits_.at({});
    if (!seed.empty()) visit({seed});
    if (limits_.load_starts) visit_swinging();
    visit(grid_.promising_sets());
    visit(grid_.promising_sets(GridSearch::Offered::laws));
    for (int round = 0; round < kNeighbourRounds && !stopped(); ++round) {
      const double before = best_joint();
      visit_neighbours();
      if (best_joint() <= before) break;
    }
    finish(out);
    return out;
  }

 private:
  using Key = std::vector<int>;

  bool stopped() const { return limits_.stop && limits_.stop(); }

  static Key key_of(const std::vector<SetMember>& members) {
    Key key;
    for (const SetMember& m : members) key.push_back(m.hypothesis);
    std::sort(key.begin(), key.end());
    return key;
  }

  double log_prior(const Key& key) const {
    double sum = 0;
    for (const int h : key) sum += evidence_.hypotheses()[static_cast<std::size_t>(h)].log_odds;
    return sum;
  }
  double joint(const Key& key) const { return fits_.at(key)->log_evidence + log_prior(key); }
  double best_joint() const {
    double best = -1e300;
    for (const auto& [key, fit] : fits_) best = std::max(best, joint(key));
    return best;
  }

  /// Fits what was not visited yet.
  void visit(const std::vector<std::vector<SetMember>>& sets) {
    std::vector<std::vector<SetMember>> todo;
    std::set<Key> seen;
    for (const auto& members : sets) {
      const Key key = key_of(members);
      if (!fits_.contains(key) && seen.insert(key).second) todo.push_back(members);
    }
    std::vector<std::unique_ptr<SetFit>> done(todo.size());
    parallel_for(
        todo.size(), limits_.threads,
        [&](std::size_t k) { done[k] = std::make_unique<SetFit>(evidence_.fit(todo[k])); }, limits_.stop);
    for (auto& fit : done)
      if (fit && std::isfinite(fit->log_evidence)) fits_[key_of(fit->members)] = std::move(fit);
  }

  /// Laws with initial states alone. A load that swings by half a radian is no small swing about rest, and
  /// its likelihood has an optimum near many points of its grid: the best of some is kept.
  void visit_swinging() {
    for (std::size_t h = 0; h < evidence_.hypotheses().size() && !stopped(); ++h) {
      const Hypothesis& law = evidence_.hypotheses()[h];
      if (!law.effect || law.points.empty()) continue;
      if (law.effect->start_spread(law.points.front().theta.data()).empty()) continue;
      const std::vector<SetMember> points = grid_.points_of(static_cast<int>(h), kMostSwings);
      std::vector<std::unique_ptr<SetFit>> done(points.size());
      parallel_for(
          points.size(), limits_.threads,
          [&](std::size_t k) { done[k] = std::make_unique<SetFit>(evidence_.fit({points[k]})); },
          limits_.stop);
      for (auto& fit : done) {
        if (!fit || !std::isfinite(fit->log_evidence)) continue;
        std::unique_ptr<SetFit>& best = fits_[{static_cast<int>(h)}];
        if (!best || fit->log_evidence > best->log_evidence) best = std::move(fit);
      }
      if (const auto best = fits_.find({static_cast<int>(h)}); best != fits_.end())
        grid_.begin_at(best->second->members.front());
    }
  }

  /// The best set with one more member, without each of its members, and with each exchanged for another.
  void visit_neighbours() {
    Key best;
    for (const auto& [key, fit] : fits_)
      if (joint(key) > joint(best)) best = key;
    const SetFit& whole = *fits_.at(best);
    std::vector<std::vector<SetMember>> without, others;
    const auto join = [&](const SetFit& fit, std::vector<Candidate>& candidates, double least_gain,
                          std::size_t most) {
      for (std::size_t k = 0; k < std::min(most, candidates.size()); ++k) {
        if (candidates[k].gain < least_gain) break;
        others.push_back(fit.members);
        others.back().push_back(std::move(candidates[k].member));
      }
    };
    if (best.size() < static_cast<std::size_t>(limits_.most_members)) {
      auto more = grid_.additions(whole);
      join(whole, more.laws, -kNearSet, kMostAdditions);
      join(whole, more.patterns, 0, 1);
    }
    for (std::size_t k = 0; k < whole.members.size(); ++k) {
      without.push_back(whole.members);
      without.back().erase(without.back().begin() + static_cast<std::ptrdiff_t>(k));
    }
    visit(without);
    for (const auto& rest : without) {
      const auto fit = fits_.find(key_of(rest));
      if (fit == fits_.end()) continue;
      // an exchange matters when it comes near to what the member brought
      const double brought = joint(best) - joint(fit->first);
      auto instead = grid_.additions(*fit->second);
      join(*fit->second, instead.laws, kGridShare * brought - kNearSet, kMostExchanges);
      join(*fit->second, instead.patterns, brought - kNearSet, 1);
    }
    visit(others);
  }

  void finish(Posterior& out) {
    const double best = best_joint();
    for (const auto& [key, fit] : fits_) {
      double choices = 0;
      for (const int h : key) choices += evidence_.hypotheses()[static_cast<std::size_t>(h)].log_choices;
      out.sets.push_back({key, fit->members, fit->theta_deviation, joint(key), log_prior(key) + choices, 0});
    }
    for (const auto& [key, fit] : fits_)
      if (key.size() == 1) out.alone.emplace_back(key[0], fit->log_evidence - fits_.at({})->log_evidence);
    std::sort(out.sets.begin(), out.sets.end(),
              [](const auto& a, const auto& b) { return a.log_joint > b.log_joint; });
    out.best = *fits_.at(out.sets.front().hypotheses);
    out.joint_of_best = best;
    out.finished = !stopped();
  }

  const Evidence& evidence_;
  GridSearch& grid_;
  const SearchLimits& limits_;
  std::map<Key, std::unique_ptr<SetFit>> fits_;
};

}  // namespace

double Posterior::inclusion(const std::string& id, const std::vector<Hypothesis>& hypotheses) const {
  double sum = 0;
  for (const SetPosterior& s : sets)
    if (std::any_of(s.hypotheses.begin(), s.hypotheses.end(),
                    [&](int h) { return hypotheses[static_cast<std::size_t>(h)].id == id; }))
      sum += s.probability;
  return sum;
}

std::array<double, kRivalErrors.size()> probability_of_errors(double law_error, const Eigen::ArrayXd& energy,
                                                              const Eigen::ArrayXd& rest,
                                                              double temperature) {
  std::array<double, kRivalErrors.size()> out{};
  for (std::size_t k = 0; k < out.size(); ++k) {
    const Eigen::ArrayXd more = temperature * std::pow(kRivalErrors[k] * law_error, 2) * energy;
    out[k] = -0.5 / temperature * (more.log1p() - temperature * rest.square() * more / (1 + more)).sum();
  }
  const double best = *std::max_element(out.begin(), out.end());
  double sum = 0;
  for (double& x : out) sum += x = std::exp(x - best);
  for (double& x : out) x /= sum;
  return out;
}

void share_probability(double law_error, Posterior& p) {
  double nothing = -1e300, something = -1e300;  // ln evidence of the empty set, the largest of the others
  for (const SetPosterior& s : p.sets) {
    double& best = s.hypotheses.empty() ? nothing : something;
    best = std::max(best, s.log_joint - s.log_prior);
  }
  p.joint_of_nothing = nothing;
  const double most = std::max(nothing, something);
  const auto left = [&](double variance) {
    return std::min(variance * (most - nothing), 0.5 * (variance * p.energy).min(1.0).sum());
  };
  const auto share = [&](const SetPosterior& s, double left_by_laws, double best) {
    return std::exp(s.log_prior + (s.log_joint - s.log_prior - best) / (1 + left_by_laws));
  };
  p.left_by_laws = left(law_error * law_error);
  double all = 0;
  for (const SetPosterior& s : p.sets) all += share(s, p.left_by_laws, most);
  for (SetPosterior& s : p.sets) s.probability = s.sharp_share = 0;
  for (SetPosterior& s : p.sets)
    if (s.hypotheses.empty()) p.probability_of_nothing = s.probability = share(s, p.left_by_laws, most) / all;
  for (std::size_t k = 0; k < kRivalErrors.size(); ++k) {
    const double here = left(2 * std::pow(kRivalErrors[k] * law_error, 2));  // both are wrong, independently
    p.left_between_laws[k] = here;
    double among = 0;
    for (const SetPosterior& s : p.sets)
      if (!s.hypotheses.empty()) among += share(s, here, something);
    for (SetPosterior& s : p.sets) {
      if (s.hypotheses.empty()) continue;
      const double part = share(s, here, something) / among;
      s.probability += (1 - p.probability_of_nothing) * p.probability_of_error[k] * part;
      if (k == 0) s.sharp_share = part;
    }
  }
}

Posterior search(const Evidence& evidence, GridSearch& grid, const SearchLimits& limits,
                 const std::vector<SetMember>& seed) {
  return Search(evidence, grid, limits).run(seed);
}

}  // namespace omniflight::diagnosis

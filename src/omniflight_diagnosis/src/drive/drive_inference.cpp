#include "drive_inference.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "../conditioning/prior_odds.hpp"
#include "../numerics/minimise.hpp"
#include "../numerics/parallel.hpp"
#include "../numerics/statistics.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::Effect;
using Law = physics::ParameterPrior::Law;

// Chosen. kMost, kPart, kTried, kTogether, kAgain and kMostMembers bound the run time.
constexpr double kMost = 60;     ///< s, used of all flights together
constexpr double kPart = 5;      ///< s, of the flight on which single parameters are scanned
constexpr int kTried = 400;      ///< values per parameter: resolves the step of a quantiser to 2 %
constexpr int kTogether = 60;    ///< values with all parameters of an effect equal
constexpr double kLeast = 0.02;  ///< smallest and ...
constexpr double kFar = 12;      ///< ... largest amplitude tried, in prior standard deviations
constexpr double kFlat = 0.05;   ///< nat, tolerance of a minimum
constexpr double kWorth = 1;     ///< nat, least gain of a restart or of a further member on the whole flight
constexpr double kPromising = 0.3;  ///< nat, least gain on the part for a fit of the whole flight
constexpr int kAgain = 3;           ///< restarts of the simplex
constexpr double kUsual = 1;        ///< prior deviations, bound of the time offset at which members are tried
constexpr std::size_t kMostMembers = 3;
/// Prior standard deviations [s] of the offset between time stamps of commands and of speeds: where body
/// sensors and pose share a clock, and where they do not or that is unknown. Chosen.
constexpr double kStampsAgree = 0.002, kStampsUnknown = 0.02;

/// Whether the clock of the body sensors (and rotor speeds) agrees with that of the pose (and commands), by
/// the lag and skew between gyro and attitude. Empty where that was not measured.
std::optional<bool> clocks_agree(const Flight& flight) {
  for (const Alignment& a : flight.alignment)
    if (a.early == "gyro" && a.late == "attitude")
      return std::abs(a.lag_s) < 0.0015 + 2 * a.lag_se && std::abs(a.skew) < 5e-6 + 3 * a.skew_se;
  return {};
}

/// Effects that act on the drives only (is_of_drives()), subject to Options::only and exclude.
std::vector<const Effect*> offered(const Options& o) {
  std::vector<const Effect*> out;
  const auto named = [](const std::vector<std::string>& ids, const std::string& id) {
    return std::find(ids.begin(), ids.end(), id) != ids.end();
  };
  for (const Effect* e : physics::builtin_effects()) {
    const physics::EffectInfo& info = e->info();
    if (is_of_drives(info) && (o.only.empty() || named(o.only, info.id)) && !named(o.exclude, info.id))
      out.push_back(e);
  }
  return out;
}

/// Standardised values of a parameter to scan, geometrically spaced (log-normal: linearly).
std::vector<double> values_to_try(const physics::ParameterPrior& prior, int count) {
  std::vector<double> out;
  if (prior.law == Law::log_normal) {
    for (int k = 0; k < count / 2; ++k) out.push_back(-4 + 8.0 * k / (count / 2 - 1));
    return out;
  }
  const double most = std::min(kFar, (prior.upper - prior.center) / prior.scale);
  const int sides = prior.law == Law::half_normal ? 1 : 2;
  for (int side = 0; side < sides; ++side)
    for (int k = 0; k < count / sides; ++k) {
      const double u = kLeast * std::pow(most / kLeast, static_cast<double>(k) / (count / sides - 1));
      out.push_back(side == 0 ? u : -u);
    }
  return out;
}

class Search {
 public:
  Search(const DriveModel& model, const Options& o) : model_(model), part_(model.part(kPart)), o_(o) {}

  /// Local maximum by Nelder and Mead's simplex, restarted with the width of the posterior until that gains
  /// less than kWorth: a collapsed simplex does not widen again.
  DriveFit fit(DriveSet set, const Eigen::VectorXd& steps) const {
    double cost = refine(model_, set, steps);
    DriveFit out{std::move(set), 0, {}};
    for (int again = 0; again < kAgain; ++again) {
      integrate(cost, out);
      const double before =
          std::exchange(cost, refine(model_, out.set, out.precision.diagonal().cwiseSqrt().cwiseInverse()));
      if (before - cost < kWorth) break;
    }
    integrate(cost, out);
    return out;
  }

  /// Recomputes the evidence with the current number of independent samples.
  void integrate(DriveFit& f) const { integrate(model_.cost(f.set), f); }

  /// The fit with one more member; empty where no scanned value gains enough.
  std::optional<DriveFit> with(const DriveFit& rest, const Effect* added) const {
    DriveSet set = rest.set;
    set.members.push_back(added);
    const auto first = static_cast<std::size_t>(rest.set.coordinates.size());
    const auto parameters = added->info().parameters.size();
    Eigen::VectorXd neutral(static_cast<Eigen::Index>(first + parameters));
    neutral.head(rest.set.coordinates.size()) = rest.set.coordinates;
    // start from nominal lag and offset: in `rest` they may have absorbed part of the member's effect
    neutral[0] = 0;
    neutral[1] = std::clamp(neutral[1], -kUsual, kUsual);
    Eigen::VectorXd steps = Eigen::VectorXd::Constant(neutral.size(), 0.1);
    for (std::size_t k = 0; k < parameters; ++k)
      neutral[static_cast<Eigen::Index>(first + k)] = neutral_of(*added, k);
    // scan each parameter, then all of them at one value
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k <= parameters && (k < parameters || parameters > 1); ++k) {
      const std::size_t of = k < parameters ? k : 0;
      const auto at = static_cast<Eigen::Index>(first + of);
      const Eigen::Index moved = k < parameters ? 1 : static_cast<Eigen::Index>(parameters);
      const std::vector<double> values =
          values_to_try(physics::prior_of(*added, of, model_.size()), k < parameters ? kTried : kTogether);
      for (std::size_t v = 0; v < values.size() && !o_.stopped(); ++v) {
        DriveSet tried = set;
        tried.coordinates = neutral;
        tried.coordinates.segment(at, moved).setConstant(values[v]);
        const double cost = part_.cost(tried);
        if (!(cost < least)) continue;
        least = cost;
        set.coordinates = tried.coordinates;
        steps.tail(static_cast<Eigen::Index>(parameters)).setConstant(0.1);
        steps.segment(at, moved).setConstant(values[v + 1 < values.size() ? v + 1 : v - 1] - values[v]);
      }
    }
    if (o_.stopped() || !std::isfinite(least)) return {};
    DriveSet without = rest.set;
    const double gained = refine(part_, without, Eigen::VectorXd::Constant(without.coordinates.size(), 0.1)) -
                          refine(part_, set, steps);
    if (o_.stopped() || !(gained > kPromising)) return {};
    // the optimum on the whole flight is near that on the part, and narrower
    const double share = std::sqrt(part_.samples() / model_.samples());
    const double cost = refine(model_, set, share * steps);
    if (!(cost < model_.cost(rest.set) - kWorth)) return {};
    return fit(std::move(set), share * steps);
  }

  /// The fit without a member, started from the values of the others.
  DriveFit without(const DriveFit& whole, std::size_t member) const {
    const Eigen::Index from = whole.set.first(member);
    const auto gone = static_cast<Eigen::Index>(whole.set.members[member]->info().parameters.size());
    const Eigen::Index behind = whole.set.coordinates.size() - from - gone;
    const Eigen::VectorXd widths = whole.precision.diagonal().cwiseSqrt().cwiseInverse();
    DriveSet set;
    set.members = whole.set.members;
    set.members.erase(set.members.begin() + static_cast<std::ptrdiff_t>(member));
    set.coordinates.resize(from + behind);
    set.coordinates << whole.set.coordinates.head(from), whole.set.coordinates.tail(behind);
    Eigen::VectorXd steps(from + behind);
    steps << widths.head(from), widths.tail(behind);
    return fit(std::move(set), steps);
  }

 private:
  /// Moves `set` to a local minimum; returns its cost.
  double refine(const DriveModel& model, DriveSet& set, const Eigen::VectorXd& steps) const {
    const auto cost = [&](const Eigen::VectorXd& u) {
      if (o_.stopped()) return std::numeric_limits<double>::infinity();
      DriveSet at = set;
      at.coordinates = u;
      return model.cost(at);
    };
    const Minimum best =
        minimise(cost, set.coordinates, steps, kFlat, 80 * static_cast<int>(set.coordinates.size()));
    set.coordinates = best.at;
    return best.value;
  }

  double neutral_of(const Effect& effect, std::size_t k) const {
    const double neutral =
        physics::prior_of(effect, k, model_.size()).coordinate(effect.info().parameters[k].neutral);
    return std::clamp(neutral, -4.0, 4.0);
  }

  void integrate(double cost, DriveFit& f) const {
    const auto at = [&](const Eigen::VectorXd& u) {
      DriveSet set = f.set;
      set.coordinates = u;
      return model_.cost(set);
    };
    // curvature of at least 1, which is that of the prior
    f.precision =
        curvature(at, {f.set.coordinates, cost}, Eigen::VectorXd::Constant(f.set.coordinates.size(), 0.1), 1);
    const Eigen::LLT<Eigen::MatrixXd> factor(f.precision);
    f.log_evidence = -cost - factor.matrixLLT().diagonal().array().log().sum();
    for (std::size_t m = 0; m < f.set.members.size(); ++m)
      for (std::size_t k = 0; k < f.set.members[m]->info().parameters.size(); ++k) {
        const Eigen::Index i = f.set.first(m) + static_cast<Eigen::Index>(k);
        if (physics::prior_of(*f.set.members[m], k, model_.size()).law == Law::half_normal)
          f.log_evidence +=
              std::log(2.0) + log_normal_cdf(std::abs(f.set.coordinates[i]) * std::sqrt(f.precision(i, i)));
      }
  }

  const DriveModel& model_;
  DriveModel part_;
  const Options& o_;
};

/// Adds a fit to the list, or replaces a worse one of the same set.
void keep(DriveFit fit, std::vector<DriveFit>& fits) {
  const auto members = [](const DriveFit& f) {
    return std::set<const Effect*>(f.set.members.begin(), f.set.members.end());
  };
  const auto same =
      std::find_if(fits.begin(), fits.end(), [&](const DriveFit& f) { return members(f) == members(fit); });
  if (same == fits.end())
    fits.push_back(std::move(fit));
  else if (same->log_evidence < fit.log_evidence)
    *same = std::move(fit);
}

/// Greedy search; returns all visited sets, the most probable first, or none when stopped.
std::vector<DriveFit> visit(DriveModel& model, const std::vector<const Effect*>& effects,
                            const DriveSet& nothing, const Options& o) {
  const Search search(model, o);
  std::vector<DriveFit> fits{search.fit(nothing, Eigen::VectorXd::Constant(2, 0.3))};
  const auto less_likely = [](const DriveFit& a, const DriveFit& b) { return a.log_joint() < b.log_joint(); };
  const auto likeliest = [&] {
    return static_cast<std::size_t>(std::max_element(fits.begin(), fits.end(), less_likely) - fits.begin());
  };
  double reached = -std::numeric_limits<double>::infinity();
  for (std::size_t best = 0; fits[best].log_joint() > reached + kFlat && !o.stopped(); best = likeliest()) {
    reached = fits[best].log_joint();
    if (fits[best].set.members.size() == kMostMembers) break;
    std::vector<const Effect*> added;
    for (const Effect* e : effects)
      if (const auto& in = fits[best].set.members; std::find(in.begin(), in.end(), e) == in.end())
        added.push_back(e);
    std::vector<std::optional<DriveFit>> more(added.size());
    parallel_for(
        added.size(), o.threads, [&](std::size_t k) { more[k] = search.with(fits[best], added[k]); }, o.stop);
    for (auto& f : more)
      if (f) keep(std::move(*f), fits);
    // a new member may make an earlier one superfluous
    const DriveFit whole = fits[likeliest()];
    for (std::size_t m = 0; whole.set.members.size() > 1 && m < whole.set.members.size() && !o.stopped(); ++m)
      keep(search.without(whole, m), fits);
  }
  if (o.stopped()) return {};
  // the number of independent samples follows from the residual of the best set, which contains no effect any
  // more
  const DriveSet last = fits[likeliest()].set;
  if (!last.members.empty()) {
    model.count_samples(last);
    for (DriveFit& f : fits) search.integrate(f);
  }
  std::stable_sort(fits.begin(), fits.end(), [&](const auto& a, const auto& b) { return less_likely(b, a); });
  return fits;
}

}  // namespace

double DriveFit::log_joint() const {
  double sum = log_evidence;
  for (const Effect* e : set.members) sum += log_odds_beside_wrench(e->info());
  return sum;
}

Eigen::MatrixXd DriveFit::covariance() const {
  return precision.llt().solve(Eigen::MatrixXd::Identity(precision.rows(), precision.cols()));
}

DriveInference infer_drives(const std::vector<const recording::Recording*>& recordings,
                            const std::vector<const Flight*>& flights, const vehicle::Vehicle& vehicle,
                            const Options& o) {
  DriveInference out;
  std::vector<DriveRecord> records;
  std::set<int> boards;
  for (const vehicle::Rotor& r : vehicle.rotors) boards.insert(r.board);
  bool agree = true;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    auto r =
        drive_record(*recordings[k], vehicle, *flights[k], kMost / static_cast<double>(recordings.size()));
    if (!r) continue;
    records.push_back(std::move(*r));
    agree = agree && clocks_agree(*flights[k]).value_or(boards.size() == 1);
  }
  if (records.empty()) return out;
  const double stamps = agree ? kStampsAgree : kStampsUnknown;
  DriveModel held(vehicle, records, Between::held, stamps, o);
  DriveModel straight(vehicle, std::move(records), Between::straight, stamps, o);
  const auto start = [](const DriveModel& model) {
    const auto cost = [&](const Eigen::VectorXd& u) { return model.cost({{}, u}); };
    const Minimum m = minimise(cost, Eigen::VectorXd::Zero(2), Eigen::VectorXd::Constant(2, 0.3), 0.01, 80);
    return DriveSet{{}, m.at};
  };
  const DriveSet on_held = start(held), on_straight = start(straight);
  // Interpolation of the commands is a property of the recorder: choose the likelier one.
  const double cost_held = held.cost(on_held), cost_straight = straight.cost(on_straight);
  if (!std::isfinite(std::min(cost_held, cost_straight))) return out;
  DriveModel& model = cost_held <= cost_straight ? held : straight;
  const DriveSet& nothing = cost_held <= cost_straight ? on_held : on_straight;
  model.count_samples(nothing);
  out.asked = offered(o);
  out.fits = visit(model, out.asked, nothing, o);
  if (out.empty()) return out;
  const DriveFit& best = out.fits.front();
  out.rms_nominal = model.rms_left(nothing);
  out.rms_left = model.rms_left(best.set);
  out.offset_s = model.offset_s(best.set);
  out.offset_deviation_s = stamps * std::sqrt(best.covariance()(1, 1));
  return out;
}

}  // namespace omniflight::diagnosis

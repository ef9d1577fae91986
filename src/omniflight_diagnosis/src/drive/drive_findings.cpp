#include <algorithm>
#include <cmath>
#include <limits>

#include "../conditioning/prior_odds.hpp"
#include "../numerics/text.hpp"
#include "drive_inference.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::Effect;
using Law = physics::ParameterPrior::Law;

/// nat below the best set within which sets have rivals: 5 % of its mass; chosen
constexpr double kRival = 3;
constexpr double kLeastOffset = 0.004;  ///< s, least delay that is mentioned; chosen

bool has(const DriveSet& set, const Effect* e) {
  return std::find(set.members.begin(), set.members.end(), e) != set.members.end();
}

/// Effects that replace e in sets within kRival of the best.
std::vector<const Effect*> rivals_of(const DriveInference& in, const Effect* e) {
  std::vector<const Effect*> out;
  for (std::size_t k = 0; k < in.fits.size() && in.fits[k].log_joint() > in.fits[0].log_joint() - kRival;
       ++k) {
    if (has(in.fits[k].set, e)) continue;
    for (const Effect* other : in.fits[k].set.members)
      if (!has(in.fits[0].set, other) && std::find(out.begin(), out.end(), other) == out.end())
        out.push_back(other);
  }
  return out;
}

/// ln Bayes factor of e: ln posterior mass of sets with e or a rival over that of the others, minus ln prior
/// odds.
double log_factor_of(const DriveInference& in, const Effect* e, const std::vector<const Effect*>& rivals) {
  double with = 0, without = 0;
  for (std::size_t k = 0; k < in.fits.size(); ++k) {
    const DriveSet& set = in.fits[k].set;
    const bool counts = has(set, e) || std::any_of(rivals.begin(), rivals.end(),
                                                   [&](const Effect* r) { return has(set, r); });
    (counts ? with : without) += std::exp(in.fits[k].log_joint() - in.fits[0].log_joint());
  }
  return std::log(with) - std::log(std::max(without, 1e-300)) - log_odds_beside_wrench(e->info());
}

/// Value with its 95 % interval, u and deviation in standardised coordinates.
ParameterValue value_of(const physics::Parameter& p, const physics::ParameterPrior& prior, double value,
                        double u, double deviation) {
  if (prior.law == Law::half_normal) u = std::abs(u);
  double low = prior.value(u - 1.96 * deviation), high = prior.value(u + 1.96 * deviation);
  if (low > high) std::swap(low, high);
  return {p.name, p.symbol, p.unit, value, std::max(p.lower, low), std::min(p.upper, high)};
}

/// ln Bayes factor of the best set with each effect against the best without any.
void add_decisions(const DriveInference& in, Diagnosis& d) {
  double nothing = -std::numeric_limits<double>::infinity();
  for (const DriveFit& f : in.fits)
    if (f.set.members.empty()) nothing = f.log_evidence;
  for (const Effect* e : in.asked) {
    double most = -std::numeric_limits<double>::infinity();
    for (const DriveFit& f : in.fits)
      if (has(f.set, e)) most = std::max(most, f.log_evidence);
    const bool fitted = std::isfinite(most);
    d.decisions.push_back({e->info().id, "ln Bayes factor of drives with it, from commands and speeds",
                           fitted ? most - nothing : 0, -log_odds_beside_wrench(e->info()),
                           "likelihood of the drives; threshold: even odds",
                           has(in.fits.front().set, e) ? "in the likeliest set"
                           : fitted                    ? "another set is likelier"
                                                       : "gains nothing at any value tried"});
  }
}

}  // namespace

std::string on_shared_delay(const DriveInference& in) {
  if (in.empty() || !(in.offset_s > std::max(4 * in.offset_deviation_s, kLeastOffset))) return {};
  return format(
      "On all boards rotor speeds are %.0f ms later than their commands: a delay of the motors or other "
      "stamps. This recording does not tell them apart, and the model has neither; stamping both by one "
      "clock would tell.",
      1e3 * in.offset_s);
}

void add_drives(const DriveInference& in, const vehicle::Vehicle& vehicle, const Options& o, Diagnosis& d) {
  if (in.empty()) return;
  add_decisions(in, d);
  if (in.fits.front().set.members.empty()) return;
  const DriveFit& best = in.fits.front();
  const physics::VehicleSize size = physics::size_of(vehicle, o.environment.gravity);
  const Eigen::MatrixXd covariance = best.covariance();
  for (std::size_t m = 0; m < best.set.members.size(); ++m) {
    const Effect* effect = best.set.members[m];
    const physics::EffectInfo& info = effect->info();
    const std::vector<double> theta = best.set.theta(m, size);
    const std::vector<const Effect*> rivals = rivals_of(in, effect);
    Finding f;
    f.effect = info.id;
    f.stage = info.stage;
    f.channels = info.channels;
    f.equation = info.equation;
    f.latex = info.latex;
    f.log_factor = log_factor_of(in, effect, rivals);
    f.rivals = static_cast<int>(rivals.size());
    for (const Effect* r : rivals) f.cannot_be_told_apart_from.push_back(r->info().id);
    f.sentence = info.term + ":";
    for (std::size_t k = 0; k < theta.size(); ++k) {
      const Eigen::Index at = best.set.first(m) + static_cast<Eigen::Index>(k);
      f.parameters.push_back(value_of(info.parameters[k], physics::prior_of(*effect, k, size), theta[k],
                                      best.set.coordinates[at], std::sqrt(covariance(at, at))));
      const ParameterValue& p = f.parameters.back();
      f.sentence += format("%s %s = %.4g %s (95 %%: %.4g to %.4g)", k > 0 ? "," : "", p.name.c_str(), p.value,
                           p.unit == "1" ? "" : p.unit.c_str(), p.low, p.high);
    }
    f.sentence += ".";
    d.findings.push_back(std::move(f));
    d.model.push_back({effect, theta});
    Mismatch mismatch;
    mismatch.stage = info.stage;
    mismatch.channel = "rotor_speed";
    mismatch.frame = "rotor";
    mismatch.unit = "rad/s";
    mismatch.where = "speeds against their commands, throughout";
    mismatch.rms = in.rms_nominal;
    mismatch.noise_rms = in.rms_left;
    mismatch.p_value = std::exp(std::min(0.0, -d.findings.back().log_factor));
    d.mismatch.push_back(std::move(mismatch));
  }
}

}  // namespace omniflight::diagnosis

#include "unknown_physics.hpp"

#include <algorithm>
#include <cmath>

#include "../discrepancy/state_variables.hpp"
#include "../numerics/statistics.hpp"
#include "../regression/channels.hpp"

namespace omniflight::diagnosis {
namespace {

/// Component of a wrench along the axis of the pattern [N or Nm], one per sample.
Eigen::VectorXd along_axis(const RegressionProblem& problem, const Pattern& p,
                           const Eigen::VectorXd& wrench) {
  const int n = problem.samples();
  if (!p.world) return wrench.segment(p.channel * n, n);
  Eigen::VectorXd out(n);
  for (int i = 0; i < n; ++i)
    out[i] = problem.measured(i).R_WB.row(p.channel).dot(
        Vec3(wrench[i], wrench[n + i], wrench[2 * n + i]).transpose());
  return out;
}

/// "dissipative", "driving" or "conservative", by net power over the sum of |power| (limit 0.5, chosen).
std::string energy_of(const RegressionProblem& problem, const Pattern& p, const Eigen::VectorXd& does) {
  double power = 0, turnover = 1e-300;
  for (int i = 0; i < problem.samples(); ++i) {
    const physics::Situation& s = problem.measured(i);
    const double speed = p.channel >= 3 ? s.body.w_WB_B[p.channel - 3]
                         : p.world      ? s.body.v_WB_W[p.channel]
                                        : s.v_WB_B[p.channel];
    power += does[i] * speed;
    turnover += std::abs(does[i] * speed);
  }
  return power < -0.5 * turnover ? "dissipative" : power > 0.5 * turnover ? "driving" : "conservative";
}

/// Linear fit to the pattern over its state variable, as a term of a model file; empty for a variable that
/// physics::quantities() does not contain.
std::optional<CorrectionTerm> line_through(const RegressionProblem& problem, const Pattern& p,
                                           const Eigen::VectorXd& does) {
  const auto quantities = physics::quantities();
  const auto quantity = std::find_if(quantities.begin(), quantities.end(),
                                     [&](const auto& q) { return p.variable == q.words; });
  if (quantity == quantities.end()) return {};
  Eigen::VectorXd x(problem.samples()), b;
  for (int i = 0; i < problem.samples(); ++i) x[i] = quantity->value(problem.measured(i));
  explained_share(x, does, &b);
  physics::Correction model;
  model.channel = p.channel;
  model.world = p.world;
  model.feature.first = static_cast<int>(quantity - quantities.begin());
  model.coefficient = b[0];
  model.mean = x.mean();
  model.low = x.minCoeff();
  model.high = x.maxCoeff();
  return CorrectionTerm{p.variable, b[0], unit_per(p.channel, p.unit), 0, model};
}

/// A sinusoid with amplitude and phase of the first flight.
CorrectionTerm pulse(const RegressionProblem& problem, const Pattern& p, const Eigen::VectorXd& weights) {
  const double unit = p.raw.col(0).cwiseAbs2().sum() + p.raw.col(1).cwiseAbs2().sum();
  int samples = 0;
  for (const Stretch& s : problem.stretches()) samples += s.flight == 0 ? s.size() : 0;
  const double size = std::sqrt(unit / std::max(1, samples));
  physics::Correction model;
  model.channel = p.channel;
  model.world = p.world;
  model.feature.form = physics::Feature::Form::pulse;
  model.feature.frequency = p.frequency_hz;
  model.feature.phase = std::atan2(weights[1], weights[0]);
  model.coefficient = size * std::hypot(weights[0], weights[1]);
  model.low = -1;
  model.high = 1;
  return {"a pulsation in time", model.coefficient, channel_unit(p.channel), p.frequency_hz, model};
}

}  // namespace

Unexplained unexplained_of(const Inference& in, const SetMember& member, const Eigen::VectorXd& before) {
  const RegressionProblem& problem = *in.problem;
  const Pattern& p = *in.hypotheses[static_cast<std::size_t>(member.hypothesis)].pattern;
  Unexplained u;
  u.channel = kChannels[static_cast<std::size_t>(p.channel)];
  u.unit = channel_unit(p.channel);
  u.frame = p.world ? "world" : "body";
  u.depends_on = {p.variable};
  const Eigen::VectorXd wrench = p.raw * member.weights, does = along_axis(problem, p, wrench),
                        all = along_axis(problem, p, before);
  u.share_of_residual = std::min(1.0, does.squaredNorm() / std::max(1e-300, all.squaredNorm()));
  u.energy = energy_of(problem, p, does);
  for (const StateVariable& v : state_variables(problem)) {
    if (v.name != p.variable) continue;
    const Eigen::VectorXd centred = (v.x.array() - v.x.mean()).matrix();
    u.parity = explained_share(centred.cwiseAbs2(), does) > explained_share(centred, does) ? "even" : "odd";
  }
  if (p.frequency_hz > 0) {
    u.nearest = "something that turns, swings or is driven by itself";
    u.correction.push_back(pulse(problem, p, member.weights));
    return u;
  }
  u.nearest = p.unit == "m/s" || p.unit == "rad/s"                           ? "aerodynamics"
              : p.variable == "height" || p.variable.starts_with("position") ? "tether, load, contact"
                                                                             : "rigid body";
  if (auto term = line_through(problem, p, does)) u.correction.push_back(std::move(*term));
  return u;
}

}  // namespace omniflight::diagnosis

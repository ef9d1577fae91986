#include "regression_problem.hpp"

#include <algorithm>
#include <cmath>

#include "calibration.hpp"
#include "omniflight_diagnosis/residual.hpp"
#include "predetermined.hpp"

namespace omniflight::diagnosis {
namespace {

/// Longest stretch [s] over which the memory of a swinging load is predicted from one initial state: some
/// periods of a pendulum; beyond, small errors of its frequency add up.
constexpr double kMemoryWindow = 10;
/// So many at most over all stretches, if need be longer ones: each has columns of its own at every point of
/// the grid, which would be most of the columns of a flight of some minutes.
constexpr double kMostWindows = 8;

/// Fixed point of accelerations with loads: a load of half the vehicle converges by three a turn.
constexpr int kExpectations = 12;
constexpr double kExpected = 1e-3;  ///< RMS force over the weight

/// Relative step of the numerical derivative by an initial state.
constexpr double kStartStep = 1e-4;
/// Step of the numerical derivative by a parameter of the drives, in standard deviations of its prior: a
/// delay of a few milliseconds moves a simulated speed by more than its rounding.
constexpr double kDriveStep = 0.02;

}  // namespace

RegressionProblem::RegressionProblem(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                                     const Options& options, Horizon horizon)
    : flight_count_(static_cast<int>(flights.size())),
      period_(1.0 / options.grid_hz),
      size_(physics::size_of(vehicle, options.environment.gravity)),
      told_noise_(options.noise),
      predicted_(options.assumes(Assumption::instruments)),
      heavy_tails_(options.assumes(Assumption::heavy_tails)),
      corrected_(options.assumes(Assumption::spectrum_correction)) {
  const Mat3 c = skew(vehicle.center_of_mass);
  inertia_ << vehicle.mass * Mat3::Identity(), -vehicle.mass * c, vehicle.mass * c,
      vehicle.inertia - vehicle.mass * c * c;
  const int lag = std::max(1, static_cast<int>(std::ceil(horizon.s / period_ - 1e-9)));
  std::vector<Vec6> rest, drawn;
  const auto measured = std::make_shared<std::vector<physics::Situation>>();
  const auto commanded = std::make_shared<CommandedWrench>(vehicle);
  measured_ = measured;
  commanded_ = commanded;
  std::vector<double> log_voltage;  // of a modelled thrust
  lowest_.setConstant(1e18);
  highest_.setConstant(-1e18);
  for (int k = 0; k < flight_count_; ++k) {
    const Flight& f = *flights[static_cast<std::size_t>(k)];
    forces_only_ = forces_only_ || f.thrust_modelled;
    kernel_s_.push_back(f.kernel_s);
    const std::vector<physics::Situation> ahead =
        predetermined(f, inertia_, vehicle.center_of_mass, period_, lag, horizon.reference_alone);
    if (predicted_) situation_.insert(situation_.end(), ahead.begin(), ahead.end());
    commanded->add(f, period_, lag, horizon.reference_alone);
    for (const Segment& segment : f.segments) {
      stretches_.push_back({n_, n_ + segment.end - segment.begin, k});
      for (int i = segment.begin; i < segment.end; ++i, ++n_) {
        const physics::Situation& now = f.situation[static_cast<std::size_t>(i)];
        rest.push_back(wrench_residual(now, now.a_WB_B - now.g_B, vehicle.center_of_mass));
        if (f.sensor_noise.size() > 0) drawn.emplace_back(f.sensor_noise.row(i));
        if (!predicted_) situation_.push_back(now);
        measured->push_back(now);
        log_voltage.push_back(f.log_voltage.size() > 0 ? f.log_voltage[i] : 0.0);
        const Vec3& p = now.body.p_WB;
        lowest_ = lowest_.cwiseMin(p);
        highest_ = highest_.cwiseMax(p);
        mean_ += p;
      }
    }
  }
  if (n_ > 0) mean_ /= n_;
  const double window = std::max(kMemoryWindow, n_ * period_ / kMostWindows);  // s
  const bool anywhere = options.assumes(Assumption::initial_states);           // else memories begin at rest
  for (const Stretch& s : anywhere ? stretches_ : std::vector<Stretch>()) {
    const int parts = std::max(1, static_cast<int>(std::lround(s.size() * period_ / window)));
    for (int k = 0; k < parts; ++k)
      windows_.push_back({s.begin + k * s.size() / parts, s.begin + (k + 1) * s.size() / parts, s.flight});
  }
  lever_.setConstant(1e-4 * size_.arm);
  for (const physics::Situation& now : situation_)
    for (const physics::RotorSituation& r : now.all_rotors())
      lever_ = lever_.cwiseMax((r.p_BR.cross(r.n_B) + r.spin * r.drag_ratio * r.n_B).cwiseAbs());
  const auto channel_major = [&](const std::vector<Vec6>& wrenches) {
    Eigen::VectorXd out(rows());
    for (int i = 0; i < n_; ++i)
      for (int ch = 0; ch < 6; ++ch)
        out[ch * n_ + i] = forces_only_ && ch >= 3 ? 0.0 : wrenches[static_cast<std::size_t>(i)][ch];
    return out;
  };
  y_ = channel_major(rest);
  if (drawn.size() == rest.size() && options.assumes(Assumption::told_noise))
    sensor_noise_ = channel_major(drawn);
  temperature_ = noise_told() ? options.told_temperature : options.temperature;
  expected_.setZero(rows());
  calibration_ =
      std::make_shared<const Calibration>(calibrate(*this, flights, vehicle, options, log_voltage));
}

void RegressionProblem::expect(const Eigen::VectorXd& wrench) {
  const Eigen::PartialPivLU<Mat6> mass(inertia_);
  for (int i = 0; i < n_ && predicted_; ++i) {  // a measured acceleration has it
    Vec6 more;
    for (int c = 0; c < 6; ++c) more[c] = wrench[c * n_ + i] - expected_[c * n_ + i];
    situation_[static_cast<std::size_t>(i)].a_WB_B += mass.solve(more).head<3>();
  }
  expected_ = wrench;
}

void RegressionProblem::expect(std::span<const EffectTerm> terms) {
  for (int k = 0; k < kExpectations; ++k) {
    const Eigen::VectorXd sum = wrench_of(terms);
    if (expects(sum)) return;
    expect(sum);
  }
}

bool RegressionProblem::expects(const Eigen::VectorXd& wrench) const {
  return (wrench - expected_).head(3 * n_).norm() <= kExpected * size_.weight * std::sqrt(n_);
}

physics::ParameterPrior RegressionProblem::prior(const physics::Effect& effect, std::size_t k) const {
  physics::ParameterPrior prior = physics::prior_of(effect, k, size_);
  const physics::Parameter& p = effect.info().parameters[k];
  if (p.unit != "m" || prior.law == physics::ParameterPrior::Law::half_normal) return prior;
  const double range = std::max(0.3, highest_.z() - lowest_.z());
  const auto place = [&](double center, double scale) {
    prior.law = physics::ParameterPrior::Law::normal;
    prior.center = std::clamp(center, p.lower, p.upper);
    prior.scale = scale;
  };
  if (p.name == "anchor_x" || p.name == "anchor_y")
    place(mean_[p.name == "anchor_x" ? 0 : 1], 1.0);
  else if (p.name == "start_height")
    place(lowest_.z(), range);
  else if (p.name == "anchor_height" || p.name == "anchor_z")
    place(highest_.z() + 1.0, 1.0);
  else if (p.name == "height")
    place(highest_.z() + 0.3, 0.5);
  return prior;
}

void RegressionProblem::between_command_and_speed(const EffectTerm& term, Eigen::VectorXd& value,
                                                  Eigen::MatrixXd* by_theta, States states) const {
  const bool predicted = predicted_ && states == States::predicted;
  value = (*commanded_)(*term.effect, term.theta, predicted, *measured_);
  std::vector<double> theta = term.theta;
  for (std::size_t k = 0; by_theta && k < theta.size(); ++k) {
    const physics::ParameterPrior p = prior(*term.effect, k);
    const double u = p.coordinate(theta[k]), inward = p.value(u + kDriveStep) > theta[k] ? 1 : -1;
    theta[k] = p.value(u + inward * kDriveStep);
    by_theta->col(static_cast<Eigen::Index>(k)) =
        ((*commanded_)(*term.effect, theta, predicted, *measured_) - value) / (theta[k] - term.theta[k]);
    theta[k] = term.theta[k];
  }
}

void RegressionProblem::replay(const EffectTerm& term, Eigen::VectorXd& value, Eigen::MatrixXd* by_theta,
                               Eigen::MatrixXd* by_start, States states_at) const {
  const physics::Effect& effect = *term.effect;
  const int parameters = by_theta ? effect.parameter_count() : 0;
  const std::vector<double> spread = effect.start_spread(term.theta.data());
  const auto states = static_cast<Eigen::Index>(spread.size());
  const auto count = static_cast<Eigen::Index>(windows_.size()) * states;
  if (by_start) by_start->setZero(rows(), count);
  std::vector<double> w, j, moved, offset(spread.size());
  const std::vector<Stretch>& parts = count == 0 ? stretches_ : windows_;
  for (std::size_t part = 0; part < parts.size(); ++part) {
    const Stretch& s = parts[part];
    const auto length = static_cast<std::size_t>(s.size());
    const std::span<const physics::Situation> motion{at(states_at).data() + s.begin, length};
    w.resize(6 * length);
    const auto scatter = [&](const std::vector<double>& from, std::size_t offset_at, auto&& column) {
      for (std::size_t i = 0; i < length; ++i)
        for (std::size_t c = 0; c < 6; ++c)
          column[static_cast<Eigen::Index>(c) * n_ + s.begin + static_cast<Eigen::Index>(i)] =
              from[offset_at + 6 * i + c];
    };
    const auto first = static_cast<Eigen::Index>(part) * states;
    for (Eigen::Index k = 0; k < states; ++k)
      offset[static_cast<std::size_t>(k)] =
          count > 0 && term.start.size() == count ? term.start[first + k] : 0.0;
    if (parameters > 0 && spread.empty()) {
      j.resize(6 * length * static_cast<std::size_t>(parameters));
      effect.replay(motion, period_, term.theta.data(), w.data(), j.data());
      for (int k = 0; k < parameters; ++k)
        scatter(j, 6 * length * static_cast<std::size_t>(k), by_theta->col(k));
    }
    if (spread.empty()) {
      if (parameters == 0) effect.replay(motion, period_, term.theta.data(), w.data(), nullptr);
      scatter(w, 0, value);
      continue;
    }
    effect.replay_from(motion, period_, term.theta.data(), offset.data(), w.data());
    scatter(w, 0, value);
    moved.resize(w.size());
    if (parameters > 0) {  // the exact derivative starts at rest: replaced by differences from this start
      std::vector<double> theta = term.theta;
      for (int k = 0; k < parameters; ++k) {
        const physics::ParameterPrior p = prior(effect, static_cast<std::size_t>(k));
        const double step = 1e-4 * std::abs(p.slope(0));
        theta[static_cast<std::size_t>(k)] += step;
        effect.replay_from(motion, period_, theta.data(), offset.data(), moved.data());
        theta[static_cast<std::size_t>(k)] = term.theta[static_cast<std::size_t>(k)];
        for (std::size_t i = 0; i < w.size(); ++i) moved[i] = (moved[i] - w[i]) / step;
        scatter(moved, 0, by_theta->col(k));
      }
    }
    if (!by_start || count == 0) continue;
    for (Eigen::Index k = 0; k < states; ++k) {
      const double deviation = spread[static_cast<std::size_t>(k)], step = kStartStep * deviation;
      if (deviation <= 0) continue;
      offset[static_cast<std::size_t>(k)] += step;
      effect.replay_from(motion, period_, term.theta.data(), offset.data(), moved.data());
      offset[static_cast<std::size_t>(k)] -= step;
      for (std::size_t i = 0; i < w.size(); ++i) moved[i] = (moved[i] - w[i]) / step;
      scatter(moved, 0, by_start->col(first + k));
    }
  }
}

void RegressionProblem::wrench_of(const EffectTerm& term, Eigen::VectorXd& value, Eigen::MatrixXd* by_theta,
                                  Eigen::MatrixXd* by_start, States states) const {
  const physics::Effect& effect = *term.effect;
  const int parameters = by_theta ? effect.parameter_count() : 0;
  const std::vector<physics::Situation>& situations = at(states);
  value.resize(rows());
  if (by_theta) by_theta->resize(rows(), parameters);
  if (is_of_drives(effect.info())) {
    if (by_start) by_start->resize(rows(), 0);
    between_command_and_speed(term, value, by_theta, states);
  } else if (effect.memory_size().total() > 0) {
    replay(term, value, by_theta, by_start, states);
  } else {
    if (by_start) by_start->resize(rows(), 0);
    std::array<double, 6> w{};
    std::array<double, 6 * physics::kMaxParameters> j{};
    for (int i = 0; i < n_; ++i) {
      const physics::Situation& now = situations[static_cast<std::size_t>(i)];
      if (by_theta) {
        effect.wrench_with_jacobian(now, term.theta.data(), w.data(), j.data());
      } else {
        physics::Wrench added;
        effect.add_wrench(now, term.theta.data(), added);
        Eigen::Map<Vec6>(w.data()) = added.at(now);
      }
      for (int c = 0; c < 6; ++c) {
        value[c * n_ + i] = w[static_cast<std::size_t>(c)];
        for (int k = 0; k < parameters; ++k)
          (*by_theta)(c * n_ + i, k) = j[static_cast<std::size_t>(6 * k + c)];
      }
    }
  }
  if (!forces_only_) return;
  value.tail(3 * n_).setZero();
  if (by_theta) by_theta->bottomRows(3 * n_).setZero();
  if (by_start && by_start->cols() > 0) by_start->bottomRows(3 * n_).setZero();
}

Eigen::VectorXd RegressionProblem::of_command_delay(double late_s, States states) const {
  Eigen::VectorXd out = commanded_->of_delay(late_s, predicted_ && states == States::predicted, *measured_);
  if (forces_only_) out.tail(3 * n_).setZero();
  return out;
}

Eigen::VectorXd RegressionProblem::wrench_of(std::span<const EffectTerm> terms, States states) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(rows()), value;
  for (const EffectTerm& term : terms) {
    wrench_of(term, value, nullptr, nullptr, states);
    sum += value;
  }
  return sum;
}

}  // namespace omniflight::diagnosis

#include "propose.hpp"

#include <algorithm>
#include <cmath>

#include "../numerics/text.hpp"
#include "../search/hypothesis.hpp"
#include "least_thrusts.hpp"
#include "manoeuvres.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;

// Chosen.
constexpr double kTold = 5;         ///< sigma, separation that counts as told apart (12.5 nat on average)
constexpr double kLongest_s = 600;  ///< s, of a flight with repetitions
constexpr int kMostRounds = 4;      ///< repetitions of a manoeuvre
constexpr double kEnough = 0.95;    ///< of the value at the most repetitions; fewer are taken from there on

/// Rest-to-rest motion (quintic time scaling) through the waypoints at the limits of the proposal.
struct Motion {
  std::vector<Vec3> p;
  std::vector<Quat> q;
  std::vector<double> alpha;  ///< rad
};

/// Quintic from 0 to 1 with zero velocity and acceleration at both ends.
double smooth(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10 + s * (-15 + 6 * s));
}

/// Samples at rate_hz; start [m, world]; tilt_rate [rad/s] of the servo. Peaks of the quintic: velocity 1.875
/// length / time, acceleration 5.78 length / time^2; half of tilt_rate is used.
Motion sample(const ProposedFlight& f, const Vec3& start, double tilt_rate, double rate_hz) {
  Motion m;
  double alpha = f.alpha;
  Vec3 p = start;
  Quat q = Quat::Identity();
  for (const ProposedWaypoint& w : f.waypoints) {
    const Vec3 rpy = w.rpy_deg * kPi / 180;
    const Quat to_q = Quat(Eigen::AngleAxisd(rpy.z(), Vec3::UnitZ())) *
                      Quat(Eigen::AngleAxisd(rpy.y(), Vec3::UnitY())) *
                      Quat(Eigen::AngleAxisd(rpy.x(), Vec3::UnitX()));
    const double way = w.by.norm(), turn = q.angularDistance(to_q);
    const double T = std::max({0.5, 1.875 * way / f.speed, std::sqrt(5.78 * way / f.acceleration),
                               1.875 * turn / f.rate, std::sqrt(5.78 * turn / f.angular_acceleration)});
    const double turning = w.alpha ? std::max(0.5, 3.75 * std::abs(*w.alpha - alpha) / tilt_rate) : 0.0;
    const int moving = static_cast<int>(T * rate_hz), tilting = static_cast<int>(turning * rate_hz),
              resting = static_cast<int>(w.hold_s * rate_hz);
    for (int i = 0; i < moving + tilting + resting; ++i) {
      const double s = smooth(static_cast<double>(i + 1) / moving);
      m.p.push_back(p + s * w.by);
      m.q.push_back(q.slerp(s, to_q));
      const double turned = w.alpha ? smooth(static_cast<double>(i + 1 - moving) / tilting) : 0.0;
      m.alpha.push_back(alpha + turned * (w.alpha.value_or(alpha) - alpha));
    }
    p += w.by;
    q = to_q;
    alpha = w.alpha.value_or(alpha);
  }
  return m;
}

/// Situations of the nominal vehicle on that motion, with rotor speeds from inverse dynamics. Underactuated
/// vehicles lean.
Flight nominal_flight(const ProposedFlight& proposal, const Vec3& start, const vehicle::Vehicle& vehicle,
                      const Flight& like, const Options& o) {
  Flight f;
  f.rate_hz = o.grid_hz;
  f.has_position = true;
  f.has_accelerometer = like.has_accelerometer;
  const Motion m = sample(proposal, start, vehicle.tilt.rate, o.grid_hz);
  const int n = static_cast<int>(m.p.size());
  if (n < 20) return f;
  const bool free_attitude = LeastThrusts(vehicle, proposal.alpha).rank() == 6;
  std::optional<LeastThrusts> thrusts;
  const double dt = 1.0 / o.grid_hz;
  std::vector<RigidState> x(static_cast<std::size_t>(n));
  std::vector<Vec3> a(x.size(), Vec3::Zero());
  const auto at = [&](int i) { return static_cast<std::size_t>(std::clamp(i, 0, n - 1)); };
  for (int i = 0; i < n; ++i) {
    x[at(i)].p_WB = m.p[at(i)];
    x[at(i)].v_WB_W = (m.p[at(i + 1)] - m.p[at(i - 1)]) / (2 * dt);
    a[at(i)] = (m.p[at(i + 1)] - 2 * m.p[at(i)] + m.p[at(i - 1)]) / (dt * dt);
    const Vec3 up = a[at(i)] + Vec3(0, 0, o.environment.gravity);
    x[at(i)].q_WB = free_attitude ? m.q[at(i)] : shortest_rotation(Vec3::UnitZ(), up);
  }
  const auto rate = [&](int i) {
    return Vec3(log_rotation(x[at(i - 1)].q_WB.conjugate() * x[at(i + 1)].q_WB) / (2 * dt));
  };
  std::vector<double> speed(vehicle.rotors.size());
  for (int i = 0; i < n; ++i) {
    RigidState& s = x[at(i)];
    s.w_WB_B = rate(i);
    const Vec3 turn = (rate(i + 1) - rate(i - 1)) / (2 * dt);
    const Mat3 R_BW = s.q_WB.conjugate().toRotationMatrix();
    Vec6 need;
    need << vehicle.mass * (R_BW * (a[at(i)] + Vec3(0, 0, o.environment.gravity))),
        vehicle.inertia * turn + s.w_WB_B.cross(vehicle.inertia * s.w_WB_B);
    const double alpha = m.alpha[at(i)];
    if (!thrusts || alpha != m.alpha[at(i - 1)]) thrusts.emplace(vehicle, alpha);
    const vehicle::RotorVector thrust = (*thrusts)(need);
    for (std::size_t r = 0; r < speed.size(); ++r)
      speed[r] = vehicle.rotors[r].speed(thrust[static_cast<Eigen::Index>(r)]);
    physics::Situation y;
    physics::Environment environment = o.environment;
    environment.floor_z = like.floor_z;
    physics::prepare(vehicle, s, alpha, speed, {}, environment, y);
    y.t = i * dt;
    y.a_WB_B = R_BW * a[at(i)];
    y.dw_WB_B = turn;
    f.t.push_back(y.t);
    f.situation.push_back(y);
  }
  f.reference.resize(n, 0);
  f.segments = {{0, n}};
  return f;
}

/// Whether `rich` contains `named` as a special case: the contribution of `named` lies in the span of the
/// columns of `rich`. Linear laws without memory only.
bool contains_law(const physics::Effect& rich, const physics::Effect& named, const Eigen::MatrixXd& columns,
                  const Eigen::VectorXd& contribution) {
  constexpr double kExactly = 1e-6;  // squared relative residual; numerical
  if (rich.parameter_count() <= named.parameter_count() || !has_constant_columns(rich) ||
      !has_constant_columns(named))
    return false;
  const Eigen::VectorXd left = contribution - columns * columns.colPivHouseholderQr().solve(contribution);
  return left.squaredNorm() <= kExactly * contribution.squaredNorm();
}

/// Whitening by the noise spectrum of the first flight.
class Whitener {
 public:
  Whitener(const RegressionProblem& problem, const NoiseModel& noise) : problem_(problem) {
    inverse_ = Eigen::VectorXd::Zero(amplitude_count(problem));
    Eigen::Index first = 0;
    for (const Stretch& s : problem.stretches()) {
      const int size = transform_length(s.size());
      for (int c = 0; c < 6; ++c, first += size)
        if (const NoiseSpectrum& spectrum = noise.spectrum(0, c); !spectrum.silent())
          inverse_.segment(first, size) = spectrum.inverse_deviations(size, problem.period());
    }
  }
  Eigen::MatrixXd operator()(const Eigen::Ref<const Eigen::MatrixXd>& columns) const {
    return inverse_.asDiagonal() * cosine_amplitudes(problem_, columns);
  }

 private:
  const RegressionProblem& problem_;
  Eigen::VectorXd inverse_;
};

/// Whitened regressors of a pair of rivals on one flight.
struct Seen {
  Eigen::VectorXd named;        ///< contribution of the named effect
  Eigen::MatrixXd unit;         ///< Jacobian of the other one, per unit of its parameters
  Eigen::MatrixXd calibration;  ///< per standard deviation; common to both flights
  Eigen::MatrixXd start;        ///< initial states of loads, per standard deviation; of this flight
};

Seen see(const RegressionProblem& problem, const Whitener& whiten, const Eigen::MatrixXd& calibration,
         const Rivals& pair) {
  Eigen::VectorXd value;
  Eigen::MatrixXd by_theta, own_start, other_start;
  problem.wrench_of({pair.other.effect, pair.other.theta, {}}, value, &by_theta, &other_start,
                    States::measured);
  problem.wrench_of({pair.named.effect, pair.named.theta, {}}, value, nullptr, &own_start, States::measured);
  Eigen::MatrixXd start(problem.rows(), own_start.cols() + other_start.cols());
  for (const auto& [effect, columns, first] : {std::tuple{&pair.named, &own_start, Eigen::Index{0}},
                                               {&pair.other, &other_start, own_start.cols()}}) {
    const std::vector<double> spread = effect->effect->start_spread(effect->theta.data());
    for (Eigen::Index k = 0; k < columns->cols(); ++k)
      start.col(first + k) = spread[static_cast<std::size_t>(k) % spread.size()] * columns->col(k);
  }
  return {whiten(value), whiten(by_theta), calibration, whiten(start)};
}

/// Calibration columns of these names; zero where the flight has none.
Eigen::MatrixXd calibration_named(const RegressionProblem& problem, const std::vector<std::string>& names) {
  const Calibration& c = problem.calibration();
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(problem.rows(), static_cast<Eigen::Index>(names.size()));
  for (std::size_t k = 0; k < names.size(); ++k)
    if (const auto at = std::find(c.names.begin(), c.names.end(), names[k]); at != c.names.end())
      out.col(static_cast<Eigen::Index>(k)) = c.measured.col(at - c.names.begin());
  return out;
}

/// Normal equations (H, g) of one flight for imitating a contribution, and its squared norm.
struct Imitation {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  double energy = 0;
};

/// Imitation of v by the columns of a law and the calibration, initial states marginalised; `times`:
/// repetitions.
Imitation imitation(const Eigen::MatrixXd& law, const Seen& seen, const Eigen::VectorXd& v, int times) {
  Eigen::MatrixXd by(v.size(), law.cols() + seen.calibration.cols());
  by << law, seen.calibration;
  Imitation out{by.transpose() * by, by.transpose() * v, v.squaredNorm()};
  if (seen.start.cols() > 0) {
    Eigen::MatrixXd S = seen.start.transpose() * seen.start;
    S.diagonal().array() += 1;
    const Eigen::LLT<Eigen::MatrixXd> solver(S);
    const Eigen::MatrixXd own = seen.start.transpose() * by;
    const Eigen::VectorXd of_v = seen.start.transpose() * v;
    out.H -= own.transpose() * solver.solve(own);
    out.g -= own.transpose() * solver.solve(of_v);
    out.energy -= of_v.dot(solver.solve(of_v));
  }
  return {times * out.H, times * out.g, times * out.energy};
}

/// Separation [sigma] of a pair by both flights together: norm of the part of the named contribution that the
/// other law cannot imitate. Where the other law contains the named one, the largest such norm, over the
/// parameters of the other law, of a contribution as strong as the named one on the flown flight that the
/// named law cannot imitate. `rounds`: repetitions of the flight `after`.
double separation(const Rivals& pair, const Seen& before, const Seen& after, int rounds) {
  const Eigen::Index calibration = before.calibration.cols();
  const auto left = [&](const Imitation& one, const Imitation& two) {
    Eigen::MatrixXd H = one.H + two.H;
    H.diagonal().tail(calibration).array() += 1;
    Eigen::VectorXd scale(H.rows());
    for (Eigen::Index k = 0; k < H.rows(); ++k) scale[k] = H(k, k) > 0 ? 1.0 / std::sqrt(H(k, k)) : 0.0;
    H = scale.asDiagonal() * H * scale.asDiagonal();
    H.diagonal().array() += 1e-9;
    const Eigen::VectorXd r = scale.asDiagonal() * (one.g + two.g);
    return std::sqrt(std::max(0.0, one.energy + two.energy - r.dot(H.ldlt().solve(r))));
  };
  if (!contains_law(*pair.other.effect, *pair.named.effect, before.unit, before.named))
    return left(imitation(before.unit, before, before.named, 1),
                imitation(after.unit, after, after.named, rounds));
  double most = 0;
  for (Eigen::Index k = 0; k < before.unit.cols(); ++k) {
    if (!(before.unit.col(k).norm() > 0)) continue;
    const double as_much = before.named.norm() / before.unit.col(k).norm();
    most = std::max(most, left(imitation(before.named, before, as_much * before.unit.col(k), 1),
                               imitation(after.named, after, as_much * after.unit.col(k), rounds)));
  }
  return most;
}

/// Number of pairs told apart; those below kTold count in proportion.
double told(const std::vector<double>& separations_sigma) {
  double out = 0;
  for (const double sigma : separations_sigma) out += std::min(1.0, sigma / kTold);
  return out;
}

/// Rank of a proposal: pairs told apart, then the smallest separation.
std::pair<double, double> worth(const ProposedFlight& f) {
  return {std::round(100 * told(f.separations_sigma)), f.separation_sigma};
}

/// Repeats the waypoints `rounds` times, returning to the start in between.
void repeat(ProposedFlight& f, int rounds) {
  if (rounds < 2) return;
  std::vector<ProposedWaypoint> once = f.waypoints;
  Vec3 back = Vec3::Zero();
  for (const ProposedWaypoint& w : once) back -= w.by;
  for (int k = 1; k < rounds; ++k) {
    f.waypoints.push_back({back, Vec3::Zero(), 1});
    f.waypoints.insert(f.waypoints.end(), once.begin(), once.end());
  }
  f.words += format(", %d times", rounds);
}

}  // namespace

std::string stay_together(const NextFlight& next) {
  std::string out;
  for (std::size_t k = 0; k < next.separations_sigma.size(); ++k) {
    if (next.separations_sigma[k] >= kTold) continue;
    const auto& [one, other] = next.separates[k];
    out += format("%s%s and %s (%.1f sigma)", out.empty() ? "" : ", ", one.c_str(), other.c_str(),
                  next.separations_sigma[k]);
  }
  return out;
}

std::vector<ProposedFlight> propose_flights(const RegressionProblem& flown, const NoiseModel& noise,
                                            const Flight& flight, const vehicle::Vehicle& vehicle,
                                            const std::vector<Rivals>& pairs, const Options& o) {
  std::vector<ProposedFlight> out;
  if (pairs.empty() || flown.samples() == 0) return out;
  double alpha = 0, low = 1e9;
  Vec3 middle = Vec3::Zero();
  for (int i = 0; i < flown.samples(); ++i) {
    const physics::Situation& s = flown.measured(i);
    alpha += s.alpha / flown.samples();
    middle += s.body.p_WB / flown.samples();
    low = std::min(low, s.body.p_WB.z());
  }
  const Vec3 start(middle.x(), middle.y(), std::max(low, 0.0));
  std::vector<Seen> before;
  const std::vector<std::string>& names = flown.calibration().names;
  const Whitener whiten_flown(flown, noise);
  const Eigen::MatrixXd known = whiten_flown(calibration_named(flown, names));
  for (const Rivals& pair : pairs) before.push_back(see(flown, whiten_flown, known, pair));
  for (ProposedFlight& f : manoeuvres(vehicle, alpha)) {
    if (o.stopped()) break;
    f.start = start;
    const Flight planned = nominal_flight(f, start, vehicle, flight, o);
    if (planned.segments.empty()) continue;
    const Flight* one[] = {&planned};
    const RegressionProblem next(one, vehicle, o, Horizon{});
    const Whitener whiten_next(next, noise);
    const Eigen::MatrixXd known_next = whiten_next(calibration_named(next, names));
    std::vector<Seen> after;
    for (const Rivals& pair : pairs) after.push_back(see(next, whiten_next, known_next, pair));
    const auto separations = [&](int rounds) {
      std::vector<double> sigma;
      for (std::size_t p = 0; p < pairs.size(); ++p)
        sigma.push_back(separation(pairs[p], before[p], after[p], rounds));
      return sigma;
    };
    // repetitions improve the separation of weak effects: as many as reach kEnough of the most
    const int most =
        std::clamp(static_cast<int>(kLongest_s * planned.rate_hz / planned.size()), 1, kMostRounds);
    const double possible = told(separations(most));
    int rounds = 1;
    while (rounds < most && told(separations(rounds)) < kEnough * possible) ++rounds;
    f.separations_sigma = separations(rounds);
    repeat(f, rounds);
    f.separation_sigma = *std::min_element(f.separations_sigma.begin(), f.separations_sigma.end());
    out.push_back(f);
  }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return worth(a) > worth(b); });
  return out;
}

}  // namespace omniflight::diagnosis

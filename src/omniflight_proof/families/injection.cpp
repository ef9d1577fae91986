#include "injection.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::proof {
namespace {

using Eigen::MatrixXd;

constexpr double kSmooth_hz =
    20;  ///< of what an injected wrench is made of: noise of the log must not come in twice
constexpr double kInTheAir = 0.6;      ///< of the weight: rotors that carry less do not fly
constexpr double kIdle = 0.3;          ///< of the weight: it stands
constexpr double kOffTheFloor = 0.08;  ///< m

/// Forwards and backwards first-order: no delay.
void smooth(MatrixXd& x, double period) {
  const double keep = std::exp(-2 * kPi * kSmooth_hz * period);
  for (Eigen::Index i = 1; i < x.rows(); ++i) x.row(i) = keep * x.row(i - 1) + (1 - keep) * x.row(i);
  for (Eigen::Index i = x.rows() - 2; i >= 0; --i) x.row(i) = keep * x.row(i + 1) + (1 - keep) * x.row(i);
}

/// Before the first and after the last sample the nearest one.
void fill(MatrixXd& x) {
  for (Eigen::Index c = 0; c < x.cols(); ++c) {
    for (Eigen::Index i = 1; i < x.rows(); ++i)
      if (!std::isfinite(x(i, c))) x(i, c) = x(i - 1, c);
    for (Eigen::Index i = x.rows() - 2; i >= 0; --i)
      if (!std::isfinite(x(i, c))) x(i, c) = x(i + 1, c);
  }
}

/// Force along z and torques of thrusts.
Eigen::Matrix<double, 4, Eigen::Dynamic> effectiveness(const vehicle::Vehicle& v) {
  return v.allocation_matrix(0).bottomRows(4);
}

/// Smallest step between values of a signal: what the log resolves.
double quantum(const recording::Signal& s) {
  double least = 1e300;
  for (Eigen::Index i = 1; i < std::min<Eigen::Index>(s.size(), 4000); ++i)
    if (const double d = std::abs(s.values(i, 0) - s.values(i - 1, 0)); d > 1e-9) least = std::min(least, d);
  return least < 1e299 ? least : 0;
}

}  // namespace

vehicle::RotorVector RealFlight::thrust(std::size_t i) const {
  vehicle::RotorVector out(vehicle_.rotor_count());
  for (int k = 0; k < vehicle_.rotor_count(); ++k)
    out[k] = vehicle_.rotors[static_cast<std::size_t>(k)].thrust(speed(i, k));
  return out;
}

Result<RealFlight> RealFlight::create(recording::Recording recording, const vehicle::Vehicle& vehicle) {
  RealFlight f;
  f.recording_ = std::move(recording);
  f.vehicle_ = vehicle;
  const recording::Recording& r = f.recording_;
  for (const char* name : {"rotor_speed", "gyro", "acc", "attitude", "position"})
    if (auto s = r.require(name); !s) return Failure(s.error());
  const recording::Signal& speed = *r.find("rotor_speed");
  if (speed.width() != vehicle.rotor_count())
    return bad_input("has " + std::to_string(speed.width()) + " rotors and the vehicle " +
                         std::to_string(vehicle.rotor_count()),
                     r.file, "Give the --vehicle that flew");
  f.t_ = speed.t_s;
  f.period_ = speed.median_period_s();
  f.speed_ = speed.values;
  f.position_ = recording::resample(*r.find("position"), f.t_);
  f.force_ = recording::resample(*r.find("acc"), f.t_);
  f.rate_ = recording::resample(*r.find("gyro"), f.t_);
  MatrixXd q = recording::resample(*r.find("attitude"), f.t_);
  for (MatrixXd* x : {&f.position_, &f.force_, &f.rate_, &q}) fill(*x);
  if (!f.position_.allFinite() || !f.force_.allFinite() || !f.rate_.allFinite() || !q.allFinite())
    return bad_input("has signals that never come together", r.file);
  for (Eigen::Index i = 0; i < q.rows(); ++i)
    f.attitude_.push_back(Quat(q(i, 0), q(i, 1), q(i, 2), q(i, 3)).normalized());
  smooth(f.force_, f.period_);
  smooth(f.rate_, f.period_);
  f.turning_ = MatrixXd::Zero(f.rate_.rows(), 3);
  for (Eigen::Index i = 1; i + 1 < f.rate_.rows(); ++i)
    f.turning_.row(i) =
        (f.rate_.row(i + 1) - f.rate_.row(i - 1)) /
        std::max(1e-6, f.t_[static_cast<std::size_t>(i) + 1] - f.t_[static_cast<std::size_t>(i) - 1]);
  // the floor is where it stands with idle rotors; a recording that begins and ends in the air has none
  double low = 0, standing = 0;
  for (std::size_t i = 0; i < f.t_.size(); ++i)
    if (f.thrust(i).sum() < kIdle * vehicle.mass * kGravity)
      low += f.position_(static_cast<Eigen::Index>(i), 2), ++standing;
  f.floor_ = standing > 0 ? low / standing : 0;
  double air = 0;
  for (std::size_t i = 0; i < f.t_.size(); ++i) {
    const double height = f.position_(static_cast<Eigen::Index>(i), 2) - f.floor_;
    f.flying_.push_back(f.thrust(i).sum() > kInTheAir * vehicle.mass * kGravity &&
                        (standing == 0 || height > kOffTheFloor));
    air += f.flying_.back() ? f.period_ : 0;
  }
  if (air < 8) return bad_input("flies for " + std::to_string(air) + " s, 8 s are needed", r.file);
  const auto B = effectiveness(vehicle);
  const int block = std::max(1, static_cast<int>(std::lround(0.02 / f.period_)));
  Eigen::Vector4d sum = Eigen::Vector4d::Zero(), square = Eigen::Vector4d::Zero(),
                  mean = Eigen::Vector4d::Zero();
  int n = 0, in = 0;
  for (std::size_t i = 0; i < f.t_.size(); ++i) {
    if (!f.flying_[i]) continue;
    Eigen::Vector4d w;
    w << vehicle.mass * f.force(i).z(),
        vehicle.inertia * f.turning(i) + f.rate(i).cross(vehicle.inertia * f.rate(i));
    mean += (w - B * f.thrust(i)) / block;
    if (++in < block) continue;
    sum += mean;
    square += mean.cwiseAbs2();
    mean.setZero();
    ++n;
    in = 0;
  }
  for (int c = 0; c < 4; ++c)
    f.noise_[static_cast<std::size_t>(c + 2)] =
        std::sqrt(std::max(1e-24, square[c] / n - sum[c] * sum[c] / n / n));
  return f;
}

Injected inject(const RealFlight& f, const Injectable& what, double a, const Shape& shape) {
  const vehicle::Vehicle& v = f.vehicle();
  const auto B = effectiveness(v);
  const Eigen::MatrixXd inverse = B.transpose() * (B * B.transpose()).inverse();
  const auto n = static_cast<Eigen::Index>(f.size());
  const int rotors = v.rotor_count();
  MatrixXd change = MatrixXd::Zero(n, rotors);  // of thrusts
  vehicle::RotorVector lagged = vehicle::RotorVector::Zero(rotors);
  Injected out;
  out.recording = f.recording();
  Eigen::Vector4d square = Eigen::Vector4d::Zero();
  int flying = 0, limited = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto s = static_cast<std::size_t>(i);
    vehicle::RotorVector wanted = vehicle::RotorVector::Zero(rotors);
    if (f.flying(s)) wanted = inverse * -what.wrench(f, s, a, shape);
    const vehicle::RotorVector now = f.thrust(s);
    bool clipped = false;
    for (int k = 0; k < rotors; ++k) {
      const vehicle::Rotor& rotor = v.rotors[static_cast<std::size_t>(k)];
      const double keep = rotor.time_constant > 0 ? std::exp(-f.period() / rotor.time_constant) : 0;
      lagged[k] = wanted[k] + keep * (lagged[k] - wanted[k]);
      const double least = std::min(now[k], rotor.lower_thrust()), most = std::max(now[k], rotor.max_thrust);
      const double bounded = std::clamp(now[k] + lagged[k], least, most) - now[k];
      clipped = clipped || std::abs(bounded - lagged[k]) > 1e-6 * rotor.max_thrust;
      change(i, k) = bounded;
    }
    if (!f.flying(s)) continue;
    ++flying;
    limited += clipped;
    square += Eigen::Vector4d(B * change.row(i).transpose()).cwiseAbs2();
  }
  out.limited = static_cast<double>(limited) / std::max(1, flying);
  for (int c = 0; c < 4; ++c) {
    const auto channel = static_cast<std::size_t>(c + 2);
    out.rms[channel] = std::sqrt(square[c] / std::max(1, flying));
    if (const double sigma = out.rms[channel] / f.noise()[channel]; sigma > out.sigma)
      out.sigma = sigma, out.channel = kChannels[channel];
  }
  recording::Signal& speed = out.recording.signals.at("rotor_speed");
  const double step = quantum(*f.recording().find("rotor_speed"));
  MatrixXd ratio = MatrixXd::Ones(n, rotors);  // of commanded speeds, which lead by the lag
  for (int k = 0; k < rotors; ++k) {
    const vehicle::Rotor& rotor = v.rotors[static_cast<std::size_t>(k)];
    double before = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double old = speed.values(i, k), thrust = rotor.thrust(old) + change(i, k);
      if (change(i, k) == 0 || thrust <= 0) continue;
      const double held = rotor.speed(thrust), difference = held - old;
      speed.values(i, k) = step > 0 ? step * std::round(held / step) : held;
      const double lead = i > 0 ? rotor.time_constant * (difference - before) / f.period() : 0;
      before = difference;
      ratio(i, k) = std::clamp(1 + (difference + lead) / std::max(1.0, old), 0.0, 3.0);
    }
  }
  recording::Signal by{"ratio", "1", f.recording().find("rotor_speed")->t_s, ratio, ""};
  for (const char* name : {"rotor_command", "pwm", "motor_power"}) {
    const auto found = out.recording.signals.find(name);
    if (found == out.recording.signals.end() || found->second.width() != rotors) continue;
    const double resolved = quantum(found->second);
    MatrixXd factor = recording::resample(by, found->second.t_s);
    for (Eigen::Index i = 0; i < factor.rows(); ++i)
      for (int k = 0; k < rotors; ++k) {
        if (!std::isfinite(factor(i, k)) || factor(i, k) == 1) continue;
        const double x = found->second.values(i, k) * factor(i, k);
        found->second.values(i, k) = resolved > 0 ? resolved * std::round(x / resolved) : x;
      }
  }
  // what was computed on board from these speeds would give the change away
  for (const char* name : {"thrust_model", "thrust_command", "qdd", "qddr", "integral"})
    out.recording.signals.erase(name);
  return out;
}

}  // namespace omniflight::proof

#include "reflight.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "omniflight_control/controller.hpp"
#include "omniflight_control/estimator.hpp"
#include "omniflight_simulation/plant.hpp"
#include "omniflight_simulation/sensors.hpp"

namespace omniflight::cli {
namespace {

using recording::Recording;
using recording::Signal;

constexpr double kStep = 0.001;   // s
constexpr int kControlEvery = 4;  // steps
constexpr double kSettle = 3.0;   // s, flown at the first reference before the recording begins

/// A body wrench given on a regular grid, linear in between.
class GivenWrench : public simulation::Disturbance {
 public:
  GivenWrench(const Eigen::MatrixXd& wrench, double from_s, double rate_hz)
      : wrench_(wrench), from_(from_s), rate_(rate_hz) {}
  void add_wrench(const physics::Situation& s, physics::Wrench& out) const override {
    const double at = std::clamp((s.t - from_) * rate_, 0.0, static_cast<double>(wrench_.rows() - 1));
    const auto k = std::min(static_cast<Eigen::Index>(at), wrench_.rows() - 2);
    const double part = at - static_cast<double>(k);
    const Eigen::Matrix<double, 1, 6> w = (1 - part) * wrench_.row(k) + part * wrench_.row(k + 1);
    out.force_B += w.head<3>().transpose();
    out.torque_B += w.tail<3>().transpose();
  }

 private:
  const Eigen::MatrixXd& wrench_;
  double from_, rate_;
};

/// Signals that a simulated flight adds to, sample by sample.
class Log {
 public:
  void add(const char* name, double t, const Eigen::Ref<const Eigen::VectorXd>& x) {
    auto& [times, values] = kept_[name];
    times.push_back(t);
    values.push_back(x);
  }
  void into(Recording& out) const {
    for (const auto& [name, kept] : kept_) {
      Signal s;
      s.name = name;
      s.t_s = kept.first;
      s.values.resize(static_cast<Eigen::Index>(kept.second.size()), kept.second.front().size());
      for (std::size_t i = 0; i < kept.second.size(); ++i)
        s.values.row(static_cast<Eigen::Index>(i)) = kept.second[i].transpose();
      if (const auto* spec = recording::find_spec(name)) s.unit = spec->unit;
      out.signals[name] = std::move(s);
    }
  }

 private:
  std::map<std::string, std::pair<std::vector<double>, std::vector<Eigen::VectorXd>>> kept_;
};

/// What the flight needs of the recording, on the control grid.
struct Asked {
  std::vector<double> t;
  std::vector<Reference> reference;
  Eigen::MatrixXd thrust;  ///< commanded, N a rotor
};

std::shared_ptr<const Asked> asked_of(const Recording& r, const vehicle::Vehicle& vehicle) {
  const Signal* parts[] = {r.find("ref_position"), r.find("ref_attitude"), r.find("ref_velocity"),
                           r.find("ref_angular_velocity"), r.find("rotor_command")};
  double from = -1e18, to = 1e18;
  for (const Signal* s : parts) {
    if (!s || s->empty()) return nullptr;
    from = std::max(from, s->t_s.front());
    to = std::min(to, s->t_s.back());
  }
  if (!(to - from > 4) || to - from > 600 || parts[4]->width() != vehicle.rotor_count()) return nullptr;
  auto out = std::make_shared<Asked>();
  for (double t = from; t < to; t += kStep * kControlEvery) out->t.push_back(t);
  const auto on_grid = [&](const Signal* s, Eigen::Index width) {
    Eigen::MatrixXd x = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(out->t.size()), width);
    if (s && s->width() == width) x = recording::resample(*s, out->t);
    for (Eigen::Index i = 0; i < x.rows(); ++i)
      if (!x.row(i).allFinite()) x.row(i) = i > 0 ? x.row(i - 1).eval() : s->values.row(0).eval();
    return x;
  };
  const Eigen::MatrixXd p = on_grid(parts[0], 3), q = on_grid(parts[1], 4), v = on_grid(parts[2], 3),
                        w = on_grid(parts[3], 3), a = on_grid(r.find("ref_acceleration"), 3),
                        dw = on_grid(r.find("ref_angular_acceleration"), 3),
                        speed = on_grid(parts[4], vehicle.rotor_count());
  const Signal* tilt = r.find("alpha_command") ? r.find("alpha_command") : r.find("alpha");
  const Eigen::MatrixXd alpha = on_grid(tilt, 1);
  out->thrust.resize(speed.rows(), speed.cols());
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    Reference one;
    one.p_WB = p.row(i).transpose();
    one.q_WB = Quat(q(i, 0), q(i, 1), q(i, 2), q(i, 3)).normalized();
    one.v_WB_W = v.row(i).transpose();
    one.w_WB_B = w.row(i).transpose();
    one.a_WB_W = a.row(i).transpose();
    one.dw_WB_B = dw.row(i).transpose();
    one.alpha = alpha(i, 0);
    out->reference.push_back(one);
    for (Eigen::Index k = 0; k < speed.cols(); ++k)
      out->thrust(i, k) = vehicle.rotors[static_cast<std::size_t>(k)].thrust(speed(i, k));
  }
  return out;
}

double rate_of(const Recording& r, const char* name, double otherwise) {
  const Signal* s = r.find(name);
  const double period = s ? s->median_period_s() : 0;
  return period > 0 ? std::clamp(1 / period, 1.0, 1 / kStep) : otherwise;
}

}  // namespace

diagnosis::Reflight make_reflight(const Recording& recording, const vehicle::Vehicle& vehicle,
                                  const diagnosis::Told& told, const physics::Environment& environment) {
  const auto three = [&](const char* place, const Vec3& otherwise) -> Vec3 {
    const auto found = told.numbers.find(place);
    if (found == told.numbers.end()) return otherwise;
    const auto& v = found->second;
    return v.size() == 3 ? Vec3(v[0], v[1], v[2]) : Vec3::Constant(v[0]);
  };
  if (!told.numbers.count("controller.kp") || !told.numbers.count("controller.kR")) return {};
  const auto asked = asked_of(recording, vehicle);
  if (!asked) return {};
  const auto first = vehicle.allocation_matrix(asked->reference.front().alpha);
  if (Eigen::JacobiSVD<Eigen::MatrixXd>(first).rank() < 6) return {};
  control::ControllerConfig gains;
  gains.kp = three("controller.kp", gains.kp);
  gains.kv = three("controller.kv", gains.kv);
  gains.ki = three("controller.ki", Vec3::Zero());
  gains.kR = three("controller.kR", gains.kR);
  gains.kw = three("controller.kw", gains.kw);
  gains.kI = three("controller.kI", Vec3::Zero());
  simulation::SensorConfig sensors;
  sensors.imu_rate = rate_of(recording, "gyro", 250);
  sensors.mocap_rate = rate_of(recording, "attitude", 125);
  sensors.rotor_rate = rate_of(recording, "rotor_speed", 125);
  std::map<std::string, Signal> references;
  for (const auto& [name, signal] : recording.signals)
    if (name.rfind("ref_", 0) == 0) references[name] = signal;

  return [=](const Eigen::MatrixXd& wrench, double from_s, double rate_hz,
             const std::vector<physics::ActiveEffect>& motors) -> Result<Recording> {
    if (wrench.rows() < 2 || wrench.cols() != 6)
      return bad_input("a disturbance needs two samples of a wrench", "", "");
    const double begin = asked->t.front() - kSettle;
    const GivenWrench gusts(wrench, from_s - begin, rate_hz);
    simulation::PlantConfig config;
    config.step = kStep;
    config.environment = environment;
    config.initial.p_WB = asked->reference.front().p_WB;
    config.initial.q_WB = asked->reference.front().q_WB;
    config.initial_alpha = asked->reference.front().alpha;
    auto plant = simulation::Plant::create(vehicle, physics::Model{motors, {}}, config);
    if (!plant) return Failure(plant.error());
    plant->set_disturbance(&gusts);
    simulation::SensorSuite suite(sensors, physics::Model{}, kStep, 1);
    control::Estimator estimator({});
    control::Controller controller(gains);
    simulation::SensorFrame frame;
    Log log;
    const auto rotors = static_cast<std::size_t>(vehicle.rotor_count());
    std::vector<double> speed(rotors);
    const int hold = static_cast<int>(kSettle / kStep);
    const int steps = hold + kControlEvery * static_cast<int>(asked->t.size());
    double tilt = std::numeric_limits<double>::quiet_NaN();
    vehicle::AllocationMatrix B;
    Eigen::CompleteOrthogonalDecomposition<vehicle::AllocationMatrix> inverse;
    const double late = 0.5;  // the rotors come up to speed while the body rests
    for (int step = 0; step < steps; ++step) {
      const double time = step * kStep, t = begin + time;
      suite.sample(*plant, frame);
      if (frame.imu) estimator.add_imu(time, frame.imu_sample.specific_force_B, frame.imu_sample.gyro_B);
      if (frame.mocap) estimator.add_mocap(time, frame.mocap_sample.p_WB, frame.mocap_sample.q_WB);
      if (step >= hold) {
        if (frame.imu) {
          log.add("acc", t, frame.imu_sample.specific_force_B);
          log.add("gyro", t, frame.imu_sample.gyro_B);
        }
        if (frame.mocap) {
          const Quat& q = frame.mocap_sample.q_WB;
          log.add("position", t, frame.mocap_sample.p_WB);
          log.add("attitude", t, Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()));
        }
        if (frame.rotor) {
          log.add("rotor_speed", t,
                  Eigen::Map<const Eigen::VectorXd>(frame.rotor_sample.speed.data(),
                                                    static_cast<Eigen::Index>(rotors)));
          log.add("alpha", t, Eigen::VectorXd::Constant(1, frame.rotor_sample.alpha));
        }
      }
      if (step % kControlEvery == 0) {
        const auto k = static_cast<std::size_t>(std::max(0, step - hold)) / kControlEvery;
        Reference r = asked->reference[std::min(k, asked->reference.size() - 1)];
        if (time < late) controller.reset();
        if (step < hold) {
          r.v_WB_W = r.w_WB_B = r.a_WB_W = r.dw_WB_B = Vec3::Zero();
        }
        RigidState state = plant->body();
        if (estimator.ready() && time > 0.1) state = estimator.state();
        const Vec6 demand = controller.update(r, state, kStep * kControlEvery);
        Vec6 w;
        const Vec3& rate = state.w_WB_B;
        const Vec3 force = vehicle.mass * (state.q_WB.conjugate() *
                                           (demand.head<3>() + environment.gravity * Vec3::UnitZ()));
        w << force, vehicle.inertia * Vec3(demand.tail<3>()) + rate.cross(vehicle.inertia * rate) +
                        vehicle.center_of_mass.cross(force);
        // what the wrench leaves open stays as it was commanded
        if (r.alpha != tilt) {
          tilt = r.alpha;
          B = vehicle.allocation_matrix(tilt);
          inverse = B.completeOrthogonalDecomposition();
        }
        const Eigen::VectorXd before =
            asked->thrust.row(static_cast<Eigen::Index>(std::min(k, asked->reference.size() - 1)))
                .transpose();
        const Eigen::VectorXd thrust = before + inverse.solve(w - B * before);
        for (std::size_t i = 0; i < rotors; ++i) {
          const vehicle::Rotor& rotor = vehicle.rotors[i];
          double f = std::clamp(thrust[static_cast<Eigen::Index>(i)], rotor.lower_thrust(), rotor.max_thrust);
          if (std::abs(f) < rotor.min_thrust) f = std::copysign(rotor.min_thrust, f);
          speed[i] = rotor.speed(f);
        }
        if (!plant->set_command(speed, r.alpha))
          return fail(ErrorCode::incomplete, "the flight again gave no finite command", "");
        if (step >= hold)
          log.add("rotor_command", t,
                  Eigen::Map<const Eigen::VectorXd>(speed.data(), static_cast<Eigen::Index>(rotors)));
      }
      if (auto ok = plant->step(time < late); !ok) return Failure(ok.error());
      if (!((plant->body().p_WB - asked->reference[0].p_WB).norm() < 100))
        return fail(ErrorCode::incomplete, "the flight again was lost", "");
    }
    Recording out;
    out.file = "flown again";
    out.duration_s = asked->t.back() - asked->t.front();
    out.signals = references;
    log.into(out);
    if (out.signals.count("acc") == 0) return fail(ErrorCode::incomplete, "nothing was measured", "");
    return out;
  };
}

}  // namespace omniflight::cli

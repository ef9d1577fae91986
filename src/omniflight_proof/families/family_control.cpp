#include "family_control.hpp"

#include <cmath>

namespace omniflight::proof {
namespace {

constexpr double kMostTilt = 0.75;    ///< rad, of the thrust of an underactuated vehicle
constexpr double kFarthestError = 1;  ///< m, a larger position error counts as this

Vec3 limited(const Vec3& v, double most) {
  const double n = v.norm();
  return n > most ? Vec3(v * (most / n)) : v;
}

double yaw_of(const Quat& q) { return roll_pitch_yaw(q).z(); }

}  // namespace

void FamilyController::Filter::design(double cut_off, double dt) {
  const double k = std::tan(kPi * cut_off * dt), q = std::sqrt(2.0), norm = 1 / (1 + k * q + k * k);
  b0 = k * k * norm;
  b1 = 2 * b0;
  b2 = b0;
  a1 = 2 * (k * k - 1) * norm;
  a2 = (1 - k * q + k * k) * norm;
}

Vec3 FamilyController::Filter::operator()(const Vec3& x) {
  if (!begun) x1 = x2 = y1 = y2 = x;
  begun = true;
  const Vec3 y = b0 * x + b1 * x1 + b2 * x2 - a1 * y1 - a2 * y2;
  x2 = x1, x1 = x, y2 = y1, y1 = y;
  return y;
}

FamilyController::FamilyController(const FamilyVehicle& vehicle, const ControllerSetup& setup)
    : vehicle_(vehicle),
      setup_(setup),
      mass_(setup.allocation_mass > 0 ? setup.allocation_mass : vehicle.nominal.mass) {}

void FamilyController::reset() { position_integral_ = attitude_integral_ = Vec3::Zero(); }

/// m/s^2, world, without gravity.
Vec3 FamilyController::acceleration(const ControlInput& in) {
  const Gains& g = setup_.gains;
  const Vec3 ep = limited(in.reference.p_WB - in.state.p_WB, kFarthestError);
  const Vec3 ev = in.reference.v_WB_W - in.state.v_WB_W;
  const Vec3 feed = setup_.feedforward ? in.reference.a_WB_W : Vec3(Vec3::Zero());
  const auto integrate = [&](const Vec3& rate) {
    position_integral_ = limited(position_integral_ + rate * in.dt, setup_.integral_limit);
  };
  switch (setup_.kind) {
    case ControllerKind::cascade: {
      const Vec3 error = limited(g.kp.cwiseQuotient(g.kv).cwiseProduct(ep), 1.5) + ev;
      integrate(g.ki.cwiseProduct(g.kv).cwiseQuotient(g.kp).cwiseProduct(error));
      return feed + g.kv.cwiseProduct(error) + position_integral_;
    }
    case ControllerKind::indi:
      return feed + g.kp.cwiseProduct(ep) + g.kv.cwiseProduct(ev);
    case ControllerKind::sliding: {
      const Vec3 surface = ev + g.kp.cwiseQuotient(g.kv).cwiseProduct(ep);
      integrate(g.ki.cwiseProduct(ep));
      const Vec3 soft = (surface / 0.4).array().tanh().matrix();
      return feed + 0.4 * g.kv.cwiseProduct(soft) + g.kp.cwiseQuotient(g.kv).cwiseProduct(ev) +
             position_integral_;
    }
    case ControllerKind::geometric:
      break;
  }
  integrate(g.ki.cwiseProduct(ep));
  return feed + g.kp.cwiseProduct(ep) + g.kv.cwiseProduct(ev) + position_integral_;
}

/// Thrust along specific_W, nose to the yaw of the reference.
Quat FamilyController::wanted_attitude(const ControlInput& in, const Vec3& specific_W) const {
  if (vehicle_.fully_actuated) return in.reference.q_WB;
  Vec3 up = specific_W;
  up.z() = std::max(up.z(), 2.0);
  const double across = up.head<2>().norm(), most = std::tan(kMostTilt) * up.z();
  if (across > most) up.head<2>() *= most / across;
  const Vec3 z = up.normalized();
  const double yaw = yaw_of(in.reference.q_WB);
  const Vec3 y = z.cross(Vec3(std::cos(yaw), std::sin(yaw), 0)).normalized();
  Mat3 R;
  R << y.cross(z), y, z;
  return Quat(R);
}

/// rad/s^2, body; rate and rate_change are those wanted, body axes of the vehicle.
Vec3 FamilyController::angular_acceleration(const ControlInput& in, const Quat& wanted, const Vec3& rate,
                                            const Vec3& rate_change) {
  const Gains& g = setup_.gains;
  const Vec3 error = log_rotation(in.state.q_WB.conjugate() * wanted), ew = rate - in.state.w_WB_B;
  Vec3 out;
  const auto integrate = [&](const Vec3& by) {
    attitude_integral_ = limited(attitude_integral_ + by * in.dt, 2 * setup_.integral_limit);
  };
  switch (setup_.kind) {
    case ControllerKind::cascade: {
      const Vec3 miss = limited(g.kR.cwiseQuotient(g.kw).cwiseProduct(error), 6.0) + ew;
      integrate(g.kI.cwiseProduct(g.kw).cwiseQuotient(g.kR).cwiseProduct(miss));
      out = g.kw.cwiseProduct(miss) + attitude_integral_;
      break;
    }
    case ControllerKind::indi:
      out = rate_change + g.kR.cwiseProduct(error) + g.kw.cwiseProduct(ew);
      break;
    case ControllerKind::sliding: {
      const Vec3 surface = ew + g.kR.cwiseQuotient(g.kw).cwiseProduct(error);
      integrate(g.kI.cwiseProduct(error));
      out =
          rate_change + g.kw.cwiseProduct((surface / 1.5).array().tanh().matrix()) * 1.5 + attitude_integral_;
      break;
    }
    case ControllerKind::geometric:
      integrate(g.kI.cwiseProduct(error));
      out = rate_change + g.kR.cwiseProduct(error) + g.kw.cwiseProduct(ew) + attitude_integral_;
      break;
  }
  out.z() *= setup_.yaw_cut;
  return out;
}

/// N, N m, body.
Vec6 FamilyController::wrench(const ControlInput& in, const Vec3& a, const Vec3& dw) {
  const Mat3 R = in.state.q_WB.toRotationMatrix();
  const Mat3& J = vehicle_.nominal.inertia;
  Vec6 w;
  if (setup_.kind == ControllerKind::indi) {
    const Vec3 now = R * filtered_force_ - kGravity * Vec3::UnitZ();
    w.head<3>() = filtered_wrench_.head<3>() + mass_ * (R.transpose() * (a - now));
    w.tail<3>() = filtered_wrench_.tail<3>() + J * (dw - gyro_rate_);
  } else {
    w.head<3>() = mass_ * (R.transpose() * (a + kGravity * Vec3::UnitZ()));
    w.tail<3>() = J * dw;
    if (setup_.kind == ControllerKind::geometric) w.tail<3>() += in.state.w_WB_B.cross(J * in.state.w_WB_B);
  }
  return w;
}

/// Least norm within what the vehicle can do; yaw gives way before a rotor is driven into its limit.
vehicle::RotorVector FamilyController::allocate(const Vec6& wanted, double alpha) const {
  const vehicle::Vehicle& v = vehicle_.nominal;
  const vehicle::AllocationMatrix B = v.allocation_matrix(alpha);
  const int n = v.rotor_count();
  const int rows = vehicle_.fully_actuated ? 6 : 4;
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, vehicle::kMaxRotors> A =
      B.bottomRows(rows);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> w = wanted.tail(rows);
  vehicle::RotorVector thrust(n);
  for (const double yaw : {1.0, 0.5, 0.0}) {
    w[rows - 1] = yaw * wanted[5];
    thrust = A.transpose() * (A * A.transpose()).ldlt().solve(w);
    bool inside = true;
    for (int i = 0; i < n; ++i) {
      const auto& r = v.rotors[static_cast<std::size_t>(i)];
      inside = inside && thrust[i] <= r.max_thrust && thrust[i] >= r.lower_thrust();
    }
    if (inside) break;
  }
  for (int i = 0; i < n; ++i) {
    const auto& r = v.rotors[static_cast<std::size_t>(i)];
    thrust[i] = std::clamp(thrust[i], r.lower_thrust(), r.max_thrust);
    if (std::abs(thrust[i]) < r.min_thrust) thrust[i] = std::copysign(r.min_thrust, thrust[i]);
  }
  return thrust;
}

ControlOutput FamilyController::update(const ControlInput& in) {
  const vehicle::Vehicle& v = vehicle_.nominal;
  const vehicle::AllocationMatrix B = v.allocation_matrix(in.alpha);
  if (setup_.kind == ControllerKind::indi) {
    if (!filters_ready_)
      for (Filter* f : {&force_, &gyro_, &rotor_force_, &rotor_torque_}) f->design(setup_.filter_hz, in.dt);
    vehicle::RotorVector now(v.rotor_count());
    for (int i = 0; i < v.rotor_count(); ++i)
      now[i] = v.rotors[static_cast<std::size_t>(i)].thrust(in.rotor_speed[static_cast<std::size_t>(i)]);
    const Vec6 w = B * now;
    filtered_force_ = force_(in.specific_force_B);
    const Vec3 gyro = gyro_(in.state.w_WB_B);
    if (filters_ready_) gyro_rate_ = (gyro - last_gyro_) / in.dt;
    last_gyro_ = gyro;
    filtered_wrench_ << rotor_force_(w.head<3>()), rotor_torque_(w.tail<3>());
    filters_ready_ = true;
  }
  ControlOutput out;
  const Vec3 a = acceleration(in);
  const Mat3 R = in.state.q_WB.toRotationMatrix();
  Vec3 specific_W = a + kGravity * Vec3::UnitZ();
  if (setup_.kind == ControllerKind::indi)
    specific_W =
        R * filtered_wrench_.head<3>() / mass_ + a - (R * filtered_force_ - kGravity * Vec3::UnitZ());
  out.attitude = wanted_attitude(in, specific_W);
  const Mat3 from_wanted = R.transpose() * out.attitude.toRotationMatrix();
  Vec3 rate = in.reference.w_WB_B, change = in.reference.dw_WB_B;
  if (!vehicle_.fully_actuated) {  // of the reference only its turning about the vertical is left
    const Vec3 turning = in.reference.q_WB * in.reference.w_WB_B;
    rate = out.attitude.conjugate() * Vec3(0, 0, turning.z());
    change.setZero();
  }
  const Vec3 dw = angular_acceleration(in, out.attitude, from_wanted * rate, from_wanted * change);
  out.demand << a, dw;
  out.thrust = allocate(wrench(in, a, dw), in.alpha);
  const Vec6 given = B * out.thrust;
  out.achieved.head<3>() = R * given.head<3>() / mass_ - kGravity * Vec3::UnitZ();
  out.achieved.tail<3>() =
      v.inertia.ldlt().solve(Vec3(given.tail<3>() - in.state.w_WB_B.cross(v.inertia * in.state.w_WB_B)));
  return out;
}

Gains draw_gains(const FamilyVehicle& vehicle, BoxRandom& random) {
  Gains g;
  if (vehicle.fully_actuated) {
    g.kp = Vec3::Constant(10), g.kv = Vec3::Constant(5.5), g.ki = Vec3::Constant(6);
    g.kR = Vec3::Constant(90), g.kw = Vec3::Constant(18), g.kI = Vec3::Constant(20);
  }
  const double position = random.between(0.8, 1.25), attitude = random.between(0.8, 1.2);
  g.kp *= position;
  g.kv *= std::sqrt(position);
  g.ki *= random.between(0.5, 1.3);
  g.kR *= attitude;
  g.kw *= std::sqrt(attitude);
  g.kI *= random.between(0.4, 1.3);
  if (!vehicle.fully_actuated) g.kR.z() *= 0.2, g.kw.z() *= 0.35, g.kI.z() *= 0.2;
  return g;
}

}  // namespace omniflight::proof

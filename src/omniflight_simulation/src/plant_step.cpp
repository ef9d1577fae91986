// What happens within a step of the plant.
#include <algorithm>
#include <cmath>
#include <utility>

#include "omniflight_simulation/plant.hpp"

namespace omniflight::simulation {
namespace {

/// Rotation matrix of a quaternion that need not have unit length, times its squared length.
[[gnu::always_inline]] inline Mat3 scaled_rotation(const Eigen::Vector4d& q) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  const double xx = x * x, yy = y * y, zz = z * z, ww = w * w;
  const double xy = 2 * x * y, xz = 2 * x * z, yz = 2 * y * z, wx = 2 * w * x, wy = 2 * w * y, wz = 2 * w * z;
  Mat3 m;
  m << (ww + xx) - (yy + zz), xy - wz, xz + wy,  //
      xy + wz, (ww - xx) + (yy - zz), yz - wx,   //
      xz - wy, yz + wx, (ww - xx) - (yy - zz);
  return m;
}

using Pair [[gnu::vector_size(16), gnu::aligned(8), gnu::may_alias]] = double;

template <class Matrix, std::size_t... kPair>
[[gnu::always_inline]] inline void put_pairs(const Matrix& from, Matrix& to, std::index_sequence<kPair...>) {
  constexpr Eigen::Index kSize = Matrix::SizeAtCompileTime;
  ((*reinterpret_cast<Pair*>(to.data() + 2 * kPair) =
        Pair{from.data()[2 * kPair], from.data()[2 * kPair + 1]}),
   ...);
  if constexpr (kSize % 2 == 1) to.data()[kSize - 1] = from.data()[kSize - 1];
}
/// to = from, two numbers at a time: effects load what they look at in pairs, and a processor that stored two
/// numbers one by one must wait for both before it can load them as a pair.
template <class Matrix>
[[gnu::always_inline]] inline void put(const Matrix& from, Matrix& to) {
  put_pairs(from, to, std::make_index_sequence<Matrix::SizeAtCompileTime / 2>());
}

/// One over the root of the squared length of a quaternion. Within a step it is close to one, and its series
/// leaves the divider of the processor to the effects.
[[gnu::always_inline]] inline double inverse_root(double square) {
  const double over = square - 1.0;
  if (std::abs(over) < 1e-4) return 1.0 + over * (-0.5 + over * (0.375 - 0.3125 * over));
  return 1.0 / std::sqrt(square);
}

/// q (0, w) / 2, coefficients x y z w.
inline Eigen::Vector4d quaternion_rate(const Eigen::Vector4d& q, const Vec3& w) {
  const double x = 0.5 * w.x(), y = 0.5 * w.y(), z = 0.5 * w.z();
  return {q[3] * x + q[1] * z - q[2] * y, q[3] * y + q[2] * x - q[0] * z, q[3] * z + q[0] * y - q[1] * x,
          -(q[0] * x + q[1] * y + q[2] * z)};
}

/// A^-1 b of a matrix that is far from singular, by its minors.
Vec3 solve(const Mat3& A, const Vec3& b) {
  const Vec3 r0 = A.row(0), r1 = A.row(1), r2 = A.row(2);
  const Vec3 c0 = r1.cross(r2), c1 = r2.cross(r0), c2 = r0.cross(r1);
  return (1.0 / r0.dot(c0)) * (b[0] * c0 + b[1] * c1 + b[2] * c2);
}

}  // namespace

[[gnu::always_inline]] inline void Plant::solve_motion(const Frame& frame, const Vec3& w, const Vec3& force,
                                                       const Vec3& torque, double mass, double lifted_mass,
                                                       Rate& out) const {
  const double g = config_.environment.gravity, all = vehicle_.mass + mass;
  const double inverse = mass == 0 ? inverse_mass_ : 1.0 / all;
  out.a_W = (inverse * frame.inverse_square) * (frame.scaled * force);
  if (mass == 0 && lifted_mass == 0)
    out.a_W.z() -= g;
  else
    out.a_W.z() = (1.0 / (all + lifted_mass)) * (all * out.a_W.z() - vehicle_.mass * g);
  out.dw_B = inverse_inertia_ * (torque - w.cross(vehicle_.inertia * w));
}

void Plant::solve_general_motion(const Vec6& rotors, const physics::Wrench& sum, Rate& out) const {
  const Vec3& w = situation_.body.w_WB_B;
  const Vec3& c = vehicle_.center_of_mass;
  const double m = vehicle_.mass;
  Vec3 force = rotors.head<3>() + sum.force_B + m * situation_.g_B;
  Vec3 torque = rotors.tail<3>() + sum.torque_B - w.cross(vehicle_.inertia * w);
  // equations about the body origin: [A B; C D] (a, dw) = (force, torque), solved by blocks, since A and D
  // are mass and inertia and far from singular. The vehicle's inertia is about its centre of mass: add m
  // (|c|^2 I - c c^T)
  const Vec3 up = situation_.R_WB.row(2);
  Mat3 A = sum.lifted_mass * up * up.transpose(), B = Mat3::Zero(), C = Mat3::Zero(), D = vehicle_.inertia;
  A.diagonal().array() += m + sum.mass;
  if (!centred_) {
    const Mat3 cross = skew(c);
    const Mat3 shift = -m * cross * cross;
    force -= m * w.cross(w.cross(c));
    torque += m * c.cross(situation_.g_B) - w.cross(shift * w);
    B = -m * cross;
    C = m * cross;
    D += shift;
  }
  if (sum.has_inertia) {
    A += sum.inertia.topLeftCorner<3, 3>();
    B += sum.inertia.topRightCorner<3, 3>();
    C += sum.inertia.bottomLeftCorner<3, 3>();
    D += sum.inertia.bottomRightCorner<3, 3>();
  }
  const Mat3 CA = C * A.inverse();
  out.dw_B = solve(D - CA * B, torque - CA * force);
  const Vec3 a_B = solve(A, force - B * out.dw_B);
  out.a_W = situation_.R_WB * a_B;
}

[[gnu::always_inline]] inline void Plant::solve_motion(const Frame& frame, const Vec6& rotors,
                                                       Rate& out) const {
  const physics::Wrench& sum = wrench_;
  if (centred_ && !sum.has_inertia)
    solve_motion(frame, situation_.body.w_WB_B, rotors.head<3>() + sum.force_B,
                 rotors.tail<3>() + sum.torque_B, sum.mass, sum.lifted_mass, out);
  else
    solve_general_motion(rotors, sum, out);
  situation_.a_WB_B = frame.inverse_square * (frame.scaled.transpose() * out.a_W);
  situation_.dw_WB_B = out.dw_B;
}

Plant::Speeds Plant::speed_rates(const double* speed) const {
  Speeds rate;
  actuators_.rates(speed, rate.data());
  for (std::size_t i = 0; faulty_ && i < count_; ++i) {
    const double tau = actuators_.actuation().time_constant[i];
    if (fault_[i] != Fault::none) rate[i] = fault_[i] == Fault::seized || tau <= 0 ? 0.0 : -speed[i] / tau;
  }
  return rate;
}

void Plant::apply_rotor_faults() {
  for (std::size_t i = 0; i < count(); ++i) {
    if (fault_[i] == Fault::seized) speed_[i] = seized_at_[i];
    if (fault_[i] == Fault::cut && actuators_.actuation().time_constant[i] <= 0) speed_[i] = 0.0;
  }
  end_known_ = false;
}

void Plant::map_rotors() const {
  const double alpha = actuators_.alpha();
  if (alpha == mapped_alpha_) return;
  map_ = thrust_map_.at(alpha);
  mapped_alpha_ = alpha;
}

void Plant::spin(Rotors (&nodes)[3]) {
  Rotors &start = nodes[0], &middle = nodes[1], &end = nodes[2];
  start.speed = speed_;
  actuators_.reach(speed_.data(), middle.speed.data(), end.speed.data());
  for (std::size_t i = 0; faulty_ && i < count_; ++i) {
    if (fault_[i] == Fault::none) continue;
    const double decays = fault_[i] == Fault::cut ? 1.0 : 0.0;
    middle.speed[i] = speed_[i] * (1.0 - decays * actuators_.share_middle(i));
    end.speed[i] = speed_[i] * (1.0 - decays * actuators_.share_end(i));
  }
  if (actuators_.alpha() != mapped_alpha_) end_known_ = false;
  map_rotors();
  start.wrench = end_wrench_;
  if (!end_known_) start.wrench = rotor_wrench(speed_.data());
  Vec6 &m = middle.wrench, &e = end.wrench;
  m.setZero();
  e.setZero();
  for (std::size_t i = 0; i < count_; ++i) {
    const double a = middle.speed[i], b = end.speed[i];
    const bool reverses = lowest_[i] < 0;
    const auto column = map_.col(static_cast<Eigen::Index>(i));
    m += (a * (reverses ? std::abs(a) : a)) * column;
    e += (b * (reverses ? std::abs(b) : b)) * column;
  }
  end_wrench_ = e;
  end_known_ = true;
}

Vec6 Plant::rotor_wrench(const double* speed) const {
  Vec6 sum = Vec6::Zero();
  for (std::size_t i = 0; i < count_; ++i)
    sum += (speed[i] * (lowest_[i] < 0 ? std::abs(speed[i]) : speed[i])) *
           map_.col(static_cast<Eigen::Index>(i));
  return sum;
}

[[gnu::always_inline]] inline Plant::Frame Plant::look(const RigidState& body, double t) const {
  const Eigen::Vector4d& q = body.q_WB.coeffs();
  const double square = q.squaredNorm();
  const Frame frame{scaled_rotation(q), 1.0 / square};
  const Mat3 R = frame.inverse_square * frame.scaled;
  const Vec3 v = frame.inverse_square * (frame.scaled.transpose() * body.v_WB_W),
             g = -config_.environment.gravity * R.row(2).transpose();
  physics::Situation& s = situation_;
  put<Vec3>(body.p_WB, s.body.p_WB);
  put<Eigen::Vector4d>(inverse_root(square) * q, s.body.q_WB.coeffs());
  put<Vec3>(body.v_WB_W, s.body.v_WB_W);
  put<Vec3>(body.w_WB_B, s.body.w_WB_B);
  put<Mat3>(R, s.R_WB);
  put<Vec3>(v, s.v_WB_B);
  put<Vec3>(g, s.g_B);
  s.t = t;
  if (!config_.neighbours.empty()) physics::set_neighbours(config_.neighbours, t, s);
  s.a_WB_B.setZero();
  s.dw_WB_B.setZero();
  return frame;
}

void Plant::look_at(const Rotors& rotors, bool speeds) const {
  if (const double alpha = actuators_.alpha(); alpha != prepared_alpha_) {
    physics::prepare(vehicle_, body_, alpha, {}, {}, config_.environment, situation_);
    prepared_alpha_ = alpha;
  }
  for (std::size_t i = 0; speeds && i < count(); ++i) {
    physics::RotorSituation& r = situation_.rotors[i];
    const double speed = rotors.speed[i];
    r.speed = speed;
    r.acceleration = rotors.rate[i];
    r.thrust = r.thrust_coefficient * speed * (lowest_[i] < 0 ? std::abs(speed) : speed);
  }
}

void Plant::sum_effects(const double* memory, bool all) const {
  physics::Wrench& sum = wrench_;
  sum.force_B.setZero();
  sum.torque_B.setZero();
  if (sum.has_inertia) sum.inertia.setZero();
  sum.has_inertia = false;
  sum.mass = sum.lifted_mass = 0;
  for (const Acting& e : effects_) {
    if (e.on_wrench && (all || !e.mapped)) e.effect->add_wrench(situation_, e.theta.data(), sum);
    if (e.size.total() > 0) e.effect->add_memory_wrench(situation_, e.theta.data(), memory + e.at, sum);
  }
  if (disturbance_) disturbance_->add_wrench(situation_, sum);
}

[[gnu::always_inline]] inline void Plant::evaluate(const RigidState& body, const Rotors& rotors,
                                                   const double* memory, double t, bool held, Rate& out,
                                                   double* memory_rate) const {
  const Frame frame = look(body, t);
  out.q_WB = quaternion_rate(body.q_WB.coeffs(), body.w_WB_B);
  if (!held) {
    sum_effects(memory, false);
    solve_motion(frame, rotors.wrench, out);
  }
  if (!memory_rate) return;
  for (const Acting& e : effects_)
    if (e.size.continuous > 0)
      e.effect->state_rate(situation_, e.theta.data(), memory + e.at, memory_rate + e.at);
}

const Plant::Answers& Plant::answers() const {
  if (answered_) return answers_;
  answered_ = true;
  look_at({speed_, speed_rates(speed_.data()), Vec6::Zero()}, true);
  const Frame frame = look(body_, time_);
  if (held_) {
    answers_ = {-situation_.g_B, Vec3::Zero(), Vec6::Zero()};
    return answers_;
  }
  sum_effects(memory_.data(), true);
  Rate d;
  solve_motion(frame, physics::rotor_wrench(situation_), d);
  answers_ = {situation_.a_WB_B - situation_.g_B, d.dw_B, wrench_.at(situation_)};
  return answers_;
}

void Plant::euler_step(bool held) {
  const double h = config_.step;
  Rate k;
  map_rotors();
  const Rotors rotors{speed_, speed_rates(speed_.data()), rotor_wrench(speed_.data())};
  look_at(rotors, true);
  evaluate(body_, rotors, memory_.data(), time_, held, k, memory_rate_.data());
  for (std::size_t i = 0; i < count(); ++i) speed_[i] += h * rotors.rate[i];
  over_continuous([&](std::size_t j) { memory_[j] += h * memory_rate_[j]; });
  if (held) return;
  body_.v_WB_W += h * k.a_W;
  body_.w_WB_B += h * k.dw_B;
  body_.p_WB += h * body_.v_WB_W;
  body_.q_WB = (body_.q_WB * exp_rotation(h * body_.w_WB_B)).normalized();
}

template <bool kBare>
inline void Plant::move_body(const Rotors (&nodes)[3], bool held) {
  constexpr int kAt[] = {0, 1, 1, 2};
  const double h = config_.step, way[] = {0.0, 0.5 * h, 0.5 * h, h};
  const RigidState start = body_;
  Vec3 last_v = start.v_WB_W;  // at the stage before
  Rate k[4];
  [[maybe_unused]] const bool speeds = looks_at_speeds_ || disturbance_;
  for (int n = 0; n < 4; ++n) {
    const Rotors& rotors = nodes[kAt[n]];
    const double f = way[n];
    const Rate& before = k[n > 0 ? n - 1 : 0];
    RigidState body = start;
    if (n > 0 && !held) {
      body.w_WB_B += f * before.dw_B;
      body.q_WB.coeffs() += f * before.q_WB;
    }
    if constexpr (kBare) {
      const Eigen::Vector4d& q = body.q_WB.coeffs();
      k[n].q_WB = quaternion_rate(q, body.w_WB_B);
      solve_motion({scaled_rotation(q), 1.0 / q.squaredNorm()}, body.w_WB_B, rotors.wrench.head<3>(),
                   rotors.wrench.tail<3>(), 0, 0, k[n]);
    } else {
      if (n > 0) {
        if (!held) {
          body.p_WB += f * last_v;
          body.v_WB_W += f * before.a_W;
        }
        over_continuous([&](std::size_t j) { stage_memory_[j] = memory_[j] + f * memory_rate_[j]; });
      }
      if (n == 0 || (speeds && n != 2)) look_at(rotors, speeds);
      evaluate(body, rotors, stage_memory_.data(), time_ + f, held, k[n], memory_rate_.data());
      last_v = body.v_WB_W;
      const double weight = n == 0 || n == 3 ? 1.0 : 2.0;
      over_continuous([&](std::size_t j) { memory_sum_[j] += weight * memory_rate_[j]; });
    }
  }
  if (held) return;
  const Vec3 inner = k[1].a_W + k[2].a_W;
  body_.p_WB += h * start.v_WB_W + (h * h / 6) * (k[0].a_W + inner);
  body_.v_WB_W += (h / 6) * (2 * inner + (k[0].a_W + k[3].a_W));
  body_.w_WB_B += (h / 6) * (2 * (k[1].dw_B + k[2].dw_B) + (k[0].dw_B + k[3].dw_B));
  const Eigen::Vector4d q =
      start.q_WB.coeffs() + (h / 6) * (2 * (k[1].q_WB + k[2].q_WB) + (k[0].q_WB + k[3].q_WB));
  body_.q_WB.coeffs() = inverse_root(q.squaredNorm()) * q;
}

void Plant::runge_kutta_step(bool held) {
  Rotors nodes[3];
  spin(nodes);
  if (bare_ && !disturbance_ && centred_) {
    if (!held) move_body<true>(nodes, held);
  } else {
    if (looks_at_speeds_ || disturbance_)
      for (Rotors& node : nodes) node.rate = speed_rates(node.speed.data());
    stage_memory_ = memory_;  // same size: no allocation
    over_continuous([&](std::size_t j) { memory_sum_[j] = 0.0; });
    move_body<false>(nodes, held);
    over_continuous([&](std::size_t j) { memory_[j] += config_.step / 6.0 * memory_sum_[j]; });
  }
  speed_ = nodes[2].speed;
}

}  // namespace omniflight::simulation

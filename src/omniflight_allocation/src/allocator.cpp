#include "omniflight_allocation/allocator.hpp"

#include <Eigen/Cholesky>

namespace omniflight::allocation {
namespace {

constexpr double kKktLimit = 1e-7;  // of the largest thrust; a solved problem is orders of magnitude below

QpMatrix weighted_product(const vehicle::AllocationMatrix& a, const vehicle::AllocationMatrix& b,
                          const Vec6& w) {
  const QpMatrix product = a.transpose() * w.asDiagonal() * b;
  return 0.5 * (product + product.transpose());
}

}  // namespace

struct Allocator::Candidate {
  double alpha = 0, cost = 0;
  vehicle::AllocationMatrix A;
  BoxQpSolution qp;
};

Result<Allocator> Allocator::create(const vehicle::Vehicle& vehicle, const AllocatorConfig& config) {
  if (const Status ok = vehicle::validate(vehicle); !ok) return Failure(ok.error());
  if (const Status ok = validate(config); !ok) return Failure(ok.error());
  if (vehicle.tilt.kind == vehicle::TiltKind::individual)
    return bad_input("individually tilting rotors are not supported by this allocator", "tilt.kind",
                     "Use kind common or none");
  Allocator a;
  a.config_ = config;
  a.n_ = vehicle.rotor_count();
  const bool tilts = vehicle.tilt.kind == vehicle::TiltKind::common;
  a.alpha_min_ = tilts ? vehicle.tilt.min : 0.0;
  a.alpha_max_ = tilts ? vehicle.tilt.max : 0.0;
  const double mass = config.mass > 0 ? config.mass : vehicle.mass;
  a.inertia_ = config.inertia.isZero(0) ? vehicle.inertia : config.inertia;
  if (Eigen::LLT<Mat3>(a.inertia_).info() != Eigen::Success)
    return bad_input("inertia is not positive definite, kg m^2", "allocator.inertia",
                     "Correct the parameter");
  a.inertia_inverse_ = a.inertia_.inverse();
  a.com_ = vehicle.center_of_mass;
  // angular: J^-1 (tau - c x f); linear, of the body origin: f/m + c x (angular)
  a.M_.topLeftCorner<3, 3>() = Mat3::Identity() / mass - skew(a.com_) * a.inertia_inverse_ * skew(a.com_);
  a.M_.topRightCorner<3, 3>() = skew(a.com_) * a.inertia_inverse_;
  a.M_.bottomLeftCorner<3, 3>() = -a.inertia_inverse_ * skew(a.com_);
  a.M_.bottomRightCorner<3, 3>() = a.inertia_inverse_;
  a.M_inverse_ = a.M_.inverse();

  const vehicle::AllocationMatrix at_0 = a.M_ * vehicle.allocation_matrix(0.0);
  const vehicle::AllocationMatrix at_90 = a.M_ * vehicle.allocation_matrix(0.5 * kPi);
  const vehicle::AllocationMatrix at_180 = a.M_ * vehicle.allocation_matrix(kPi);
  a.A0_ = 0.5 * (at_0 + at_180);
  a.Ac_ = 0.5 * (at_0 - at_180);
  a.As_ = at_90 - a.A0_;
  a.constant_part_ = a.A0_.cwiseAbs().maxCoeff() > 1e-14 * at_0.cwiseAbs().maxCoeff();
  if (!a.constant_part_) a.A0_.setZero();
  Vec6 w;
  w << Vec3::Constant(config.w_linear), Vec3::Constant(config.w_angular);
  a.Q00_ = weighted_product(a.A0_, a.A0_, w);
  a.Qcc_ = weighted_product(a.Ac_, a.Ac_, w);
  a.Qss_ = weighted_product(a.As_, a.As_, w);
  a.Q0c_ = 2.0 * weighted_product(a.A0_, a.Ac_, w);
  a.Q0s_ = 2.0 * weighted_product(a.A0_, a.As_, w);
  a.Qcs_ = 2.0 * weighted_product(a.Ac_, a.As_, w);

  a.lower_ = vehicle.lower_thrusts();
  a.upper_ = vehicle.upper_thrusts();
  a.rotors_ = vehicle.rotors;
  a.gap_ = vehicle::RotorVector::Zero(a.n_);
  for (int i = 0; i < a.n_ && config.keep_min_thrust; ++i)
    if (const vehicle::Rotor& rotor = a.rotors_[static_cast<std::size_t>(i)]; rotor.bidirectional)
      a.gap_[i] = rotor.min_thrust;
  a.unit_weight_ = vehicle::RotorVector::Ones(a.n_);
  if (config.input_unit == InputUnit::hz2) {
    for (int i = 0; i < a.n_; ++i) {
      const double newton_per_hz2 =
          a.rotors_[static_cast<std::size_t>(i)].thrust_coefficient * 4.0 * kPi * kPi;
      a.unit_weight_[i] = 1.0 / (newton_per_hz2 * newton_per_hz2);
    }
  }
  a.reset(config.initial_tilt);
  return a;
}

void Allocator::reset(double alpha, const vehicle::RotorVector* u_previous) {
  alpha_ = std::clamp(std::isfinite(alpha) ? alpha : alpha_min_, alpha_min_, alpha_max_);
  u_previous_ = vehicle::RotorVector::Zero(n_);
  if (u_previous != nullptr && u_previous->size() == n_ && u_previous->allFinite()) u_previous_ = *u_previous;
  const DynamicWeights& d = config_.dynamic_weights;
  w_input_ = d.enabled ? std::clamp(config_.w_input, d.floor, d.ceiling) : config_.w_input;
  warm_ = {};
}

double Allocator::next_weight(double position_error) const {
  const DynamicWeights& d = config_.dynamic_weights;
  if (!d.enabled) return config_.w_input;
  const double factor =
      (d.threshold >= position_error ? d.growth : 0.0) + (position_error >= d.threshold ? d.shrink : 0.0);
  return std::clamp(w_input_ * factor, d.floor, d.ceiling);
}

void Allocator::assemble_quadratic(double c, double s, QpMatrix& H) const {
  H = (c * c) * Qcc_ + (s * s) * Qss_ + (c * s) * Qcs_;
  if (constant_part_) H += Q00_ + c * Q0c_ + s * Q0s_;
}

Vec6 Allocator::acceleration(const Mat3& R_WB, const Vec3& w, const vehicle::AllocationMatrix& A,
                             const vehicle::RotorVector& u) const {
  Vec6 qdd = A * u;
  const Vec3 spin = -inertia_inverse_ * w.cross(inertia_ * w);
  qdd.head<3>() =
      R_WB * (qdd.head<3>() + com_.cross(spin) - w.cross(w.cross(com_))) - kGravity * Vec3::UnitZ();
  qdd.tail<3>() += spin;
  return qdd;
}

Result<Allocation> Allocator::allocate(const AllocationInput& in) {
  const auto refuse = [](const char* field, const char* why) {
    return bad_input(std::string(field) + " " + why, std::string("allocation input ") + field,
                     "Hold the last command or stop the rotors");
  };
  if (!in.qdd_ref.allFinite()) return refuse("qdd_ref", "is not finite");
  if (!in.q_WB.coeffs().allFinite() || std::abs(in.q_WB.norm() - 1.0) > 1e-3)
    return refuse("q_WB", "is no unit quaternion");
  if (!in.w_WB_B.allFinite()) return refuse("w_WB_B", "is not finite");
  if (!(in.position_error >= 0) || !std::isfinite(in.position_error))
    return refuse("position_error", "must be finite and >= 0 m");
  double centre = alpha_;
  if (config_.tilt_mode == TiltMode::fixed && in.alpha) {
    if (!(*in.alpha >= alpha_min_ - 1e-9 && *in.alpha <= alpha_max_ + 1e-9))
      return refuse("alpha", "lies outside the tilt limits");
    centre = std::clamp(*in.alpha, alpha_min_, alpha_max_);
  }

  const Mat3 R_WB = in.q_WB.normalized().toRotationMatrix();
  const double w_input = next_weight(in.position_error);
  // what the rotors have to give, body axes: W2 is isotropic in each block, so the rotation drops out of H
  Vec6 target = in.qdd_ref;
  const Vec3 spin = -inertia_inverse_ * in.w_WB_B.cross(inertia_ * in.w_WB_B);
  target.head<3>() = R_WB.transpose() * (in.qdd_ref.head<3>() + kGravity * Vec3::UnitZ()) -
                     (com_.cross(spin) - in.w_WB_B.cross(in.w_WB_B.cross(com_)));
  target.tail<3>() -= spin;
  Vec6 weight;
  weight << Vec3::Constant(config_.w_linear), Vec3::Constant(config_.w_angular);
  const Vec6 weighted_target = weight.cwiseProduct(target);

  std::array<double, 3> offsets{0.0, -config_.tilt_step, config_.tilt_step};
  const std::size_t count = config_.tilt_mode == TiltMode::search && config_.tilt_step > 0 ? 3 : 1;
  Candidate best, trial;
  int iterations = 0, programs = 0;
  bool have = false;
  QpMatrix H(n_, n_);
  for (std::size_t k = 0; k < count; ++k) {
    trial.alpha = std::clamp(centre + offsets[k], alpha_min_, alpha_max_);
    if (k > 0 && trial.alpha == centre) continue;
    const double c = std::cos(trial.alpha), s = std::sin(trial.alpha);
    trial.A = c * Ac_ + s * As_;
    if (constant_part_) trial.A += A0_;
    assemble_quadratic(c, s, H);
    H.diagonal() += (w_input + config_.w_rate) * unit_weight_;
    const QpVector g =
        -trial.A.transpose() * weighted_target - config_.w_rate * unit_weight_.cwiseProduct(u_previous_);
    const GapQpSolution found = solve_gap_qp(H, g, lower_, upper_, gap_, warm_[k]);
    trial.qp = found.best;
    if (trial.qp.status != QpStatus::solved || !(trial.qp.kkt_residual < kKktLimit))
      return fail(ErrorCode::internal,
                  std::string("the quadratic program was not solved: ") + to_string(trial.qp.status),
                  "allocation", "Check the weights: their ratio may exceed double precision");
    warm_[k] = found.relaxed_active_set;
    iterations += trial.qp.iterations;
    programs += found.nodes;
    // summed from its terms: the tracking part is many orders larger than what tells the tilts apart
    const Vec6 missing = trial.A * trial.qp.u - target;
    trial.cost = weight.dot(missing.cwiseAbs2()) +
                 unit_weight_.dot(config_.w_rate * (trial.qp.u - u_previous_).cwiseAbs2() +
                                  w_input * trial.qp.u.cwiseAbs2());
    if (!have || trial.cost < best.cost) best = trial;
    have = true;
  }

  Allocation out;
  out.u = best.qp.u;
  out.speed.resize(n_);
  for (int i = 0; i < n_; ++i) out.speed[i] = rotors_[static_cast<std::size_t>(i)].speed(out.u[i]);
  out.alpha = best.alpha;
  out.qdd = acceleration(R_WB, in.w_WB_B, best.A, best.qp.u);
  out.unachieved_wrench = M_inverse_ * (target - best.A * best.qp.u);
  out.cost = best.cost;
  out.w_input = w_input;
  out.kkt_residual = best.qp.kkt_residual;
  out.active_bounds = best.qp.active_bounds;
  out.iterations = iterations;
  out.programs = programs;
  u_previous_ = best.qp.u;
  alpha_ = best.alpha;
  w_input_ = w_input;
  return out;
}

}  // namespace omniflight::allocation

#include "omniflight_allocation/allocator.hpp"

#include <Eigen/Cholesky>
#include <bit>

#include "tilt_lanes.hpp"

namespace omniflight::allocation {
namespace {

constexpr double kKktLimit = 1e-7;  // of the largest thrust; a solved problem is orders of magnitude below

QpMatrix weighted_product(const vehicle::AllocationMatrix& a, const vehicle::AllocationMatrix& b,
                          const Vec6& w) {
  const QpMatrix product = a.transpose() * w.asDiagonal() * b;
  return 0.5 * (product + product.transpose());
}

/// What the lanes need of a vehicle with up to 8 rotors.
struct Products {
  const QpMatrix &cc, &ss, &cs, &one, &c, &s;
};
TiltTerms tilt_terms(const Products& q, bool constant_part, const vehicle::AllocationMatrix& Ac,
                     const vehicle::AllocationMatrix& As, const vehicle::AllocationMatrix& A0,
                     const Vec6& weight) {
  TiltTerms out;
  out.n = static_cast<int>(Ac.cols());
  out.constant_part = constant_part;
  for (int i = 0; i < out.n; ++i) {
    for (int j = 0; j <= i; ++j)
      out.quadratic[static_cast<std::size_t>(i * (i + 1) / 2 + j)] = {q.cc(i, j),  q.ss(i, j), q.cs(i, j),
                                                                      q.one(i, j), q.c(i, j),  q.s(i, j)};
    for (int r = 0; r < 6; ++r)
      out.rows[static_cast<std::size_t>(r)][static_cast<std::size_t>(i)] = {Ac(r, i), As(r, i), A0(r, i)};
  }
  for (int r = 0; r < 6; ++r) out.weight[static_cast<std::size_t>(r)] = weight[r];
  return out;
}

}  // namespace

struct Allocator::Wish {
  Mat3 R_WB;
  Vec6 target;    ///< what the rotors have to give, body axes
  Vec6 weighted;  ///< times W2
  double w_input = 0;
};

struct Allocator::Candidate {
  double alpha = 0, cost = 0;
  vehicle::AllocationMatrix A;
  BoxQpSolution qp;
  int iterations = 0, programs = 0;  ///< of all candidates together
};

Result<Allocator> Allocator::create(const vehicle::Vehicle& vehicle, const AllocatorConfig& config) {
  if (const Status ok = vehicle::validate(vehicle); !ok) return Failure(ok.error());
  if (const Status ok = validate(config); !ok) return Failure(ok.error());
  Allocator a;
  a.config_ = config;
  a.n_ = vehicle.rotor_count();
  const bool tilts = vehicle.tilt.kind != vehicle::TiltKind::none;
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
  a.weight_ << Vec3::Constant(config.w_linear), Vec3::Constant(config.w_angular);

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
  a.assemble_products();
  double step = config.tilt_step;
  for (std::size_t pair = 0; pair < a.cos_step_.size(); ++pair, step *= 0.5)
    a.cos_step_[pair] = std::cos(step), a.sin_step_[pair] = std::sin(step);
  a.reset(config.initial_tilt);
  return a;
}

void Allocator::assemble_products() {
  const Vec6& w = weight_;
  Q00_ = weighted_product(A0_, A0_, w);
  Qcc_ = weighted_product(Ac_, Ac_, w);
  Qss_ = weighted_product(As_, As_, w);
  Q0c_ = 2.0 * weighted_product(A0_, Ac_, w);
  Q0s_ = 2.0 * weighted_product(A0_, As_, w);
  Qcs_ = 2.0 * weighted_product(Ac_, As_, w);
  has_gap_ = gap_.maxCoeff() > 0;
  if (n_ > kLaneInputs) return;
  auto terms = std::make_shared<TiltTerms>(
      tilt_terms({Qcc_, Qss_, Qcs_, Q00_, Q0c_, Q0s_}, constant_part_, Ac_, As_, A0_, w));
  double largest = 0;
  for (int i = 0; i < n_; ++i) {
    terms->lower[static_cast<std::size_t>(i)] = lower_[i];
    terms->upper[static_cast<std::size_t>(i)] = upper_[i];
    largest = std::max({largest, std::abs(lower_[i]), std::abs(upper_[i])});
  }
  terms->primal_tolerance = 1e-12 * largest;
  terms_ = terms;
}

Status Allocator::drop_rotor(int rotor) {
  if (rotor < 0 || rotor >= n_)
    return bad_input("there is no rotor " + std::to_string(rotor + 1), "allocator",
                     "Give 1 to " + std::to_string(n_));
  const std::uint32_t dropped = dropped_ | std::uint32_t{1} << rotor;
  if (std::popcount(dropped) == n_) return bad_input("no rotor is left", "allocator", "Stop the rotors");
  dropped_ = dropped;
  // without a column its thrust costs only: the optimum is 0, which must lie within the bounds
  for (vehicle::AllocationMatrix* part : {&A0_, &Ac_, &As_}) part->col(rotor).setZero();
  lower_[rotor] = std::min(lower_[rotor], 0.0);
  gap_[rotor] = 0;
  u_previous_[rotor] = 0;
  // What the others cannot give is taken from the rotation or from the translation. From here on a rad/s^2
  // counts for as much as the m/s^2 that it is at the rotors: the usual weights let the vehicle turn over in
  // order to stay in its place.
  double square = 0;  // m^2, mean distance from the centre of mass
  for (const auto& r : rotors_) square += (r.p_BR - com_).squaredNorm() / n_;
  weight_.tail<3>().setConstant(std::max(config_.w_angular, square * config_.w_linear));
  assemble_products();
  warm_ = {};
  lanes_at_low_ = lanes_at_high_ = {};
  kept_alpha_ = std::numeric_limits<double>::quiet_NaN();
  return {};
}

void Allocator::reset(double alpha, const vehicle::RotorVector* u_previous) {
  alpha_ = std::clamp(std::isfinite(alpha) ? alpha : alpha_min_, alpha_min_, alpha_max_);
  u_previous_ = vehicle::RotorVector::Zero(n_);
  if (u_previous != nullptr && u_previous->size() == n_ && u_previous->allFinite()) u_previous_ = *u_previous;
  const DynamicWeights& d = config_.dynamic_weights;
  w_input_ = d.enabled ? std::clamp(config_.w_input, d.floor, d.ceiling) : config_.w_input;
  warm_ = {};
  lanes_at_low_ = lanes_at_high_ = {};
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

Allocator::Wish Allocator::wish(const AllocationInput& in) const {
  Wish out;
  out.R_WB = in.q_WB.normalized().toRotationMatrix();
  out.w_input = next_weight(in.position_error);
  // W2 is isotropic in each block, so the rotation drops out of H
  out.target = in.qdd_ref;
  const Vec3 spin = -inertia_inverse_ * in.w_WB_B.cross(inertia_ * in.w_WB_B);
  out.target.head<3>() = out.R_WB.transpose() * (in.qdd_ref.head<3>() + kGravity * Vec3::UnitZ()) -
                         (com_.cross(spin) - in.w_WB_B.cross(in.w_WB_B.cross(com_)));
  out.target.tail<3>() -= spin;
  out.weighted = weight_.cwiseProduct(out.target);
  return out;
}

int Allocator::tilts(double centre, Tilts& out) const {
  const double c = std::cos(centre), s = std::sin(centre);
  out.fill({centre, c, s});
  if (config_.tilt_mode != TiltMode::search || !(config_.tilt_step > 0) || alpha_min_ == alpha_max_) return 1;
  double step = config_.tilt_step;
  for (std::size_t k = 1; k < out.size(); ++k) {
    const std::size_t pair = (k - 1) / 2;
    const double sign = k % 2 == 1 ? -1.0 : 1.0, alpha = centre + sign * step;
    const double cd = cos_step_[pair], sd = sign * sin_step_[pair];
    out[k] = {alpha, c * cd - s * sd, s * cd + c * sd};
    if (alpha < alpha_min_) out[k] = {alpha_min_, std::cos(alpha_min_), std::sin(alpha_min_)};
    if (alpha > alpha_max_) out[k] = {alpha_max_, std::cos(alpha_max_), std::sin(alpha_max_)};
    if (k % 2 == 0) step *= 0.5;
  }
  return config_.tilt_candidates;
}

Status Allocator::solve(const Wish& wish, const Tilt& tilt, ActiveSet& warm, Candidate& out) {
  const auto [alpha, c, s] = tilt;
  out.alpha = alpha;
  out.A = c * Ac_ + s * As_;
  if (constant_part_) out.A += A0_;
  const QpVector g =
      -out.A.transpose() * wish.weighted - config_.w_rate * unit_weight_.cwiseProduct(u_previous_);
  const bool stays = !has_gap_ && kept_alpha_ == alpha && kept_w_ == wish.w_input;
  if (!stays) {
    QpMatrix H(n_, n_);
    assemble_quadratic(c, s, H);
    H.diagonal() += (wish.w_input + config_.w_rate) * unit_weight_;
    if (has_gap_) {
      const GapQpSolution found = solve_gap_qp(H, g, lower_, upper_, gap_, warm);
      out.qp = found.best;
      out.programs += found.nodes;
      warm = found.relaxed_active_set;
    } else {
      kept_alpha_ = alpha;
      kept_w_ = wish.w_input;
      out.qp.status = kept_.set_matrix(H);
      if (out.qp.status != QpStatus::solved) kept_alpha_ = std::numeric_limits<double>::quiet_NaN();
    }
  }
  if (!has_gap_ && (stays || out.qp.status == QpStatus::solved)) {
    out.qp = kept_.solve(g, lower_, upper_, warm);
    ++out.programs;
    warm = out.qp.active_set;
  }
  if (out.qp.status != QpStatus::solved || !(out.qp.kkt_residual < kKktLimit))
    return fail(ErrorCode::internal,
                std::string("the quadratic program was not solved: ") + to_string(out.qp.status),
                "allocation", "Check the weights: their ratio may exceed double precision");
  out.iterations += out.qp.iterations;
  // summed from its terms: the tracking part is many orders larger than what tells the tilts apart
  const Vec6 missing = out.A * out.qp.u - wish.target;
  out.cost = weight_.dot(missing.cwiseAbs2()) +
             unit_weight_.dot(config_.w_rate * (out.qp.u - u_previous_).cwiseAbs2() +
                              wish.w_input * out.qp.u.cwiseAbs2());
  return {};
}

void Allocator::fill(const Wish& wish, const Tilts& tilts, int count, TiltPrograms& p) const {
  p.count = count;
  for (std::size_t k = 0; k < tilts.size(); ++k) p.c[k] = tilts[k].c, p.s[k] = tilts[k].s;
  double steepest = 0, stiffest = 0;
  for (std::size_t i = 0; i < kLaneInputs; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    if (at >= n_) {
      p.diagonal[i] = 1;  // a rotor that is not there: bounds and slope are zero
      continue;
    }
    p.rate[i] = config_.w_rate * unit_weight_[at];
    p.input[i] = wish.w_input * unit_weight_[at];
    p.diagonal[i] = p.rate[i] + p.input[i];
    p.previous[i] = u_previous_[at];
    auto& linear = p.linear[i];
    linear = {0, 0, p.rate[i] * p.previous[i]};
    for (std::size_t r = 0; r < 6; ++r)
      for (std::size_t f = 0; f < 3; ++f)
        linear[f] += terms_->rows[r][i][f] * wish.weighted[static_cast<Eigen::Index>(r)];
    steepest = std::max(steepest, std::abs(linear[0]) + std::abs(linear[1]) + std::abs(linear[2]));
    const auto& q = terms_->quadratic[i * (i + 1) / 2 + i];
    stiffest = std::max(stiffest, q[0] + q[1] + p.diagonal[i]);
  }
  p.dual_tolerance = 1e-14 * (stiffest * terms_->primal_tolerance * 1e12 + steepest);
  for (std::size_t r = 0; r < 6; ++r) p.target[r] = wish.target[static_cast<Eigen::Index>(r)];
  p.at_low = lanes_at_low_;
  p.at_high = lanes_at_high_;
}

Status Allocator::search(const Wish& wish, const Tilts& tilts, int count, Candidate& best) {
  // the cost of each candidate without gaps, which no solution with gaps is below; unknown: -infinity
  std::array<double, 8> floor;
  floor.fill(-HUGE_VAL);
  int programs = 0, iterations = 0;
  if (terms_ != nullptr) {
    TiltPrograms p;
    fill(wish, tilts, count, p);
    solve_tilts(*terms_, p);
    lanes_at_low_ = p.at_low;
    lanes_at_high_ = p.at_high;
    programs = count;
    iterations = count * p.sweeps;
    for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) {
      if ((p.solved >> k & 1) != 0) floor[k] = p.cost[k];
      for (std::size_t i = 0; i < static_cast<std::size_t>(n_); ++i)
        warm_[k][i] = static_cast<std::int8_t>((p.at_high[i] >> k & 1) - (p.at_low[i] >> k & 1));
    }
  }
  bool have = false;
  Candidate trial;
  for (int visited = 0; visited < count; ++visited) {
    const auto end = floor.begin() + count;
    const auto k = static_cast<std::size_t>(std::min_element(floor.begin(), end) - floor.begin());
    if (floor[k] == HUGE_VAL || (have && floor[k] >= best.cost)) break;
    floor[k] = HUGE_VAL;
    if (k > 0 && have && tilts[k].alpha == tilts[0].alpha) continue;
    if (const Status ok = solve(wish, tilts[k], warm_[k], trial); !ok) return ok;
    if (!have || trial.cost < best.cost) best = trial;
    have = true;
  }
  best.programs = trial.programs + programs;
  best.iterations = trial.iterations + iterations;
  return {};
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

  const Wish wanted = wish(in);
  Tilts candidates;
  const int count = tilts(centre, candidates);
  Candidate best;
  const Status found =
      count == 1 ? solve(wanted, candidates[0], warm_[0], best) : search(wanted, candidates, count, best);
  if (!found) return Failure(found.error());
  // Numbers whose squares overflow compare as no candidate's cost.
  if (best.qp.u.size() != n_ || !best.qp.u.allFinite()) return refuse("qdd_ref", "is too large to allocate");

  Allocation out;
  out.u = best.qp.u;
  out.speed.resize(n_);
  for (int i = 0; i < n_; ++i) out.speed[i] = rotors_[static_cast<std::size_t>(i)].speed(out.u[i]);
  out.alpha = best.alpha;
  out.qdd = acceleration(wanted.R_WB, in.w_WB_B, best.A, best.qp.u);
  out.unachieved_wrench = M_inverse_ * (wanted.target - best.A * best.qp.u);
  out.cost = best.cost;
  out.w_input = wanted.w_input;
  out.kkt_residual = best.qp.kkt_residual;
  out.active_bounds = best.qp.active_bounds;
  out.iterations = best.iterations;
  out.programs = best.programs;
  u_previous_ = best.qp.u;
  alpha_ = best.alpha;
  w_input_ = wanted.w_input;
  return out;
}

}  // namespace omniflight::allocation

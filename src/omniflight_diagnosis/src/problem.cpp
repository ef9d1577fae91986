#include "problem.hpp"

#include <algorithm>

#include "state_variables.hpp"

namespace omniflight::diagnosis {

namespace {

constexpr double kLeastTurn = 1e-5;  ///< 1 and rad: an offset needs some tolerance

/// How fast the rotors' wrench changes with their speeds [N/s, Nm/s].
Vec6 rotor_wrench_rate(const physics::Situation& s) {
  physics::Situation rate = s;
  for (int k = 0; k < s.rotor_count; ++k) {
    const physics::RotorSituation& r = s.rotors[static_cast<std::size_t>(k)];
    rate.rotors[static_cast<std::size_t>(k)].thrust =
        2 * r.thrust_coefficient * std::abs(r.speed) * r.acceleration;
  }
  return physics::rotor_wrench(rate);
}

}  // namespace

Vec6 wrench_residual(const physics::Situation& s, const Vec3& f, const Vec3& c) {
  const Vec3 &w = s.body.w_WB_B, &dw = s.dw_WB_B;
  const Vec3 f_com = f + dw.cross(c) + w.cross(w.cross(c));
  Vec6 r = -physics::rotor_wrench(s);
  r.head<3>() += s.mass * f_com;
  r.tail<3>() += s.inertia * dw + w.cross(s.inertia * w) + s.mass * c.cross(f_com);
  return r;
}

bool is_linear(const physics::Effect& effect) {
  for (const physics::Parameter& p : effect.info().parameters)
    if (!p.linear) return false;
  return true;
}

bool adds_inertia(const physics::Effect& effect) {
  physics::Situation s;
  std::vector<double> theta;
  for (const physics::Parameter& p : effect.info().parameters)
    theta.push_back(p.lower > 0 ? p.lower : p.typical);
  s.body.p_WB.z() = 1e3;  // above every start height
  physics::Wrench w;
  effect.add_wrench(s, theta.data(), w);
  return w.moves_mass();
}

bool acts_at_once(const physics::Effect& effect) {
  return !adds_inertia(effect) && effect.memory_size().total() == 0;
}

bool Problem::has_constant_columns(const physics::Effect& effect) const {
  return is_linear(effect) && effect.memory_size().total() == 0 && (instrumented_ || !adds_inertia(effect));
}

Problem::Problem(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                 const Options& options)
    : flight_count_(static_cast<int>(flights.size())), period_(1.0 / options.grid_hz) {
  std::vector<Vec6> fast;
  std::vector<std::array<double, 2>> drive;
  std::vector<const physics::Situation*> instrument;
  for (int k = 0; k < flight_count_; ++k) {
    const Flight& f = *flights[static_cast<std::size_t>(k)];
    for (const Segment& segment : f.segments) {
      runs_.push_back({n_, n_ + segment.end - segment.begin, k});
      for (int i = segment.begin; i < segment.end; ++i, ++n_) {
        const auto at = static_cast<std::size_t>(i);
        const physics::Situation& s = f.situation[at];
        situation_.push_back(f.smooth[at]);
        situation_.back().a_WB_B = s.a_WB_B;
        situation_.back().dw_WB_B = s.dw_WB_B;
        acceleration_.emplace_back();
        acceleration_.back() << s.a_WB_B, s.dw_WB_B;
        if (!f.instrument.empty()) instrument.push_back(&f.instrument[at]);
        const bool known = f.log_drive.size() > 0;
        drive.push_back({known ? f.log_drive[i] : 0.0, known ? f.log_voltage[i] : 0.0});
        fast.push_back(physics::rotor_wrench(f.smooth[at]) - physics::rotor_wrench(s));
      }
    }
  }
  double arm = 1e-3;
  for (const vehicle::Rotor& r : vehicle.rotors) arm = std::max(arm, r.p_BR.norm());
  const double weight = vehicle.mass * options.environment.gravity;
  weight_ = weight;
  // a vehicle with upright rotors has little to turn about its vertical with
  lever_.setConstant(1e-4 * arm);
  for (const physics::Situation& now : situation_)
    for (const physics::RotorSituation& r : now.all_rotors())
      lever_ = lever_.cwiseMax((r.p_BR.cross(r.n_B) + r.spin * r.drag_ratio * r.n_B).cwiseAbs());
  vehicle_scale_ = scale_of(vehicle, options.environment.gravity);
  for (const physics::Situation& now : situation_)
    vehicle_scale_.highest = std::max(vehicle_scale_.highest, now.body.p_WB.z());
  took_off_ = std::any_of(flights.begin(), flights.end(), [](const Flight* f) { return f->stood_at; });
  const Tolerance& tol = options.tolerance;
  const bool biased = flight_count_ > 0 && flights[0]->has_accelerometer;
  offset_names_ = {"thrust_scale", "trim_x", "trim_y", "trim_z", "world_x", "world_y", "world_z"};
  offset_sigma_ = Eigen::VectorXd::Constant(7, tol.torque_trim);
  offset_sigma_[0] = tol.thrust_scale;
  offset_sigma_.tail<3>().setConstant(tol.world_force);
  if (biased) {
    for (const char* name : {"bias_x", "bias_y", "bias_z"}) offset_names_.push_back(name);
    offset_sigma_.conservativeResize(10);
    offset_sigma_.tail<3>() << tol.accelerometer_lateral, tol.accelerometer_lateral,
        tol.accelerometer_vertical;
  }
  const Eigen::Index clock = offset_sigma_.size();
  offset_names_.emplace_back("rotor_clock");
  offset_sigma_.conservativeResize(clock + 1);
  offset_sigma_[clock] = tol.rotor_clock;
  const Eigen::Index axes = offset_sigma_.size();
  const bool turned = biased && (tol.accelerometer_scale > 0 || tol.accelerometer_misalignment > 0);
  if (turned) {
    for (const char* name :
         {"acc_scale_x", "acc_scale_y", "acc_scale_z", "acc_turn_x", "acc_turn_y", "acc_turn_z"})
      offset_names_.push_back(name);
    offset_sigma_.conservativeResize(axes + 6);
    offset_sigma_.segment(axes, 3).setConstant(std::max(kLeastTurn, tol.accelerometer_scale));
    offset_sigma_.tail<3>().setConstant(std::max(kLeastTurn, tol.accelerometer_misalignment));
  }
  // a thrust that is only modelled: scale, exponent and voltage are known roughly
  const bool modelled = flight_count_ > 0 && flights[0]->thrust_modelled;
  forces_only_ = modelled;
  const Eigen::Index first_model = offset_sigma_.size();
  if (modelled) {
    offset_sigma_[0] = 0.1 * tol.modelled_scale;  // the flight itself gave the scale to a tenth of that
    offset_sigma_.segment(1, 3).setConstant(tol.modelled_trim);
    offset_sigma_.conservativeResize(first_model + 2);
    offset_sigma_.tail<2>() << tol.modelled_exponent, tol.modelled_voltage;
    offset_names_.insert(offset_names_.end(), {"thrust_exponent", "thrust_voltage"});
  }
  const Mat3 c_x = skew(vehicle.center_of_mass);
  inertia_ << vehicle.mass * Mat3::Identity(), -vehicle.mass * c_x, vehicle.mass * c_x,
      vehicle.inertia - vehicle.mass * c_x * c_x;
  y_.resize(rows());
  fast_.resize(rows());
  offsets_ = Eigen::MatrixXd::Zero(rows(), offset_sigma_.size());
  for (int i = 0; i < n_; ++i) {
    const physics::Situation& s = situation(i);
    const Vec6 r = wrench_residual(s, s.a_WB_B - s.g_B, vehicle.center_of_mass);
    for (int c = 0; c < 6; ++c) {
      fast_[c * n_ + i] = fast[static_cast<std::size_t>(i)][c];
      y_[c * n_ + i] = r[c] + fast_[c * n_ + i];
    }
  }
  instrumented_ = n_ > 0 && static_cast<int>(instrument.size()) == n_;
  if (instrumented_) vehicle_scale_.least_drag_torque = -0.8;
  if (instrumented_)  // from here on nothing sees the measured state any more
    for (std::size_t i = 0; i < instrument.size(); ++i) {
      situation_[i] = *instrument[i];
      acceleration_[i] << situation_[i].a_WB_B, situation_[i].dw_WB_B;
    }
  for (int i = 0; i < n_; ++i) {
    const physics::Situation& s = situation(i);
    const Vec6 rotors = physics::rotor_wrench(s);
    // where feedback colours the state, a clock that is off looks as the answer of the rotors does
    const Vec6 rate = instrumented_ ? rotor_wrench_rate(s) : Vec6::Zero();
    for (int c = 0; c < 6; ++c) {
      const int row = c * n_ + i;
      offsets_(row, 0) = rotors[c];
      if (c >= 3) offsets_(row, c - 2) = weight * arm;
      if (c < 3)
        for (int k = 0; k < 3; ++k) offsets_(row, 4 + k) = weight * s.R_WB(k, c);
      if (c < 3 && biased) offsets_(row, 7 + c) = vehicle.mass;
      offsets_(row, clock) = rate[c];
      if (c < 3 && turned) {
        // of what the rotors give: the measured force has the disturbances of the residual in it
        const Vec3 force = rotors.head<3>();
        offsets_(row, axes + c) = force[c];
        for (int k = 0; k < 3; ++k) offsets_(row, axes + 3 + k) = Vec3::Unit(k).cross(force)[c];
      }
      if (modelled) {
        offsets_(row, first_model) = rotors[c] * drive[static_cast<std::size_t>(i)][0];
        offsets_(row, first_model + 1) = rotors[c] * drive[static_cast<std::size_t>(i)][1];
      }
    }
  }
  if (forces_only_) {
    y_.tail(3 * n_).setZero();
    fast_.tail(3 * n_).setZero();
    offsets_.bottomRows(3 * n_).setZero();
  }
  noise_ = std::make_shared<const Whitening>(noise_model(*this, options));
  linear_.clear();  // whitened now
  whitened_offsets_ = noise_->apply(*this, offsets_);
}

Problem Problem::thinned(const Eigen::VectorXd& residual, int every) const {
  Problem few = *this;
  few.memory_ = std::make_shared<ColumnMemory>();
  few.linear_.clear();
  few.products_.clear();
  few.bent_.clear();
  few.period_ *= every;
  few.runs_.clear();
  std::vector<int> kept;
  for (const Run& run : runs_) {
    const int begin = static_cast<int>(kept.size());
    for (int i = run.begin; i < run.end; i += every) kept.push_back(i);
    few.runs_.push_back({begin, static_cast<int>(kept.size()), run.flight});
  }
  few.n_ = static_cast<int>(kept.size());
  few.situation_.clear();
  few.acceleration_.clear();
  few.y_.resize(few.rows());
  few.fast_ = Eigen::VectorXd::Zero(few.rows());
  few.offsets_.resize(few.rows(), offsets_.cols());
  for (int k = 0; k < few.n_; ++k) {
    const int i = kept[static_cast<std::size_t>(k)];
    few.situation_.push_back(situation(i));
    few.acceleration_.push_back(acceleration_[static_cast<std::size_t>(i)]);
    for (int c = 0; c < 6; ++c) {
      few.y_[c * few.n_ + k] = residual[c * n_ + i];
      few.offsets_.row(c * few.n_ + k) = offsets_.row(c * n_ + i);
    }
  }
  few.noise_ = std::make_shared<const Whitening>(Whitening::scale_only(few, few.y_));
  few.whitened_offsets_ = few.noise_->apply(few, few.offsets_);
  return few;
}

const Problem::Constant& Problem::constant(const physics::Effect& effect) const {
  auto known = linear_.find(&effect);
  if (known == linear_.end()) {
    Constant c;
    Eigen::VectorXd value;
    const physics::ActiveEffect at_rest{
        &effect, std::vector<double>(static_cast<std::size_t>(effect.parameter_count()))};
    wrench_of(at_rest, value, &c.columns);
    if (noise_) c.whitened = noise_->apply(*this, c.columns);
    known = linear_.emplace(&effect, std::move(c)).first;
  }
  return known->second;
}

bool Problem::has_inertia(const std::vector<physics::ActiveEffect>& effects) const {
  return !instrumented_ &&
         std::any_of(effects.begin(), effects.end(), [](const auto& e) { return adds_inertia(*e.effect); });
}

Problem::Bent* Problem::remembered(const physics::ActiveEffect& at) const {
  const auto known = std::find_if(bent_.begin(), bent_.end(), [&](const Bent& b) {
    return b.at.effect == at.effect && b.at.theta == at.theta;
  });
  if (known == bent_.end()) return nullptr;
  bent_.splice(bent_.begin(), bent_, known);
  return &bent_.front();
}

const Problem::Bent& Problem::bent(const physics::ActiveEffect& at) const {
  if (const Bent* known = remembered(at)) return *known;
  constexpr std::size_t kMost = 8;
  if (bent_.size() == kMost) bent_.pop_back();
  bent_.push_front({at, {}, {}, {}});
  wrench_of(at, bent_.front().value, &bent_.front().columns);
  return bent_.front();
}

void Problem::wrench_of(const physics::ActiveEffect& active, Eigen::VectorXd& value,
                        Eigen::MatrixXd* jacobian) const {
  const physics::Effect& effect = *active.effect;
  const int parameters = jacobian ? effect.parameter_count() : 0;
  value.resize(rows());
  if (jacobian) jacobian->resize(rows(), parameters);
  if (effect.memory_size().total() > 0) {  // its state starts anew with every uninterrupted stretch
    std::vector<double> w, j;
    for (const Run& run : runs_) {
      const auto length = static_cast<std::size_t>(run.end - run.begin);
      w.resize(6 * length);
      j.resize(6 * length * static_cast<std::size_t>(parameters));
      effect.replay({situation_.data() + run.begin, length}, period_, active.theta.data(), w.data(),
                    jacobian ? j.data() : nullptr);
      for (std::size_t i = 0; i < length; ++i)
        for (std::size_t c = 0; c < 6; ++c) {
          const Eigen::Index row =
              static_cast<Eigen::Index>(c) * n_ + run.begin + static_cast<Eigen::Index>(i);
          value[row] = w[6 * i + c];
          for (int k = 0; k < parameters; ++k)
            (*jacobian)(row, k) = j[6 * length * static_cast<std::size_t>(k) + 6 * i + c];
        }
    }
    return;
  }
  std::array<double, 6> w{};
  std::array<double, 6 * physics::kMaxParameters> j{};
  for (int i = 0; i < n_; ++i) {
    if (jacobian) {
      effect.wrench_with_jacobian(situation(i), active.theta.data(), w.data(), j.data());
    } else {
      physics::Wrench now;
      effect.add_wrench(situation(i), active.theta.data(), now);
      Eigen::Map<Vec6>(w.data()) = now.at(situation(i));
    }
    for (int c = 0; c < 6; ++c) {
      value[c * n_ + i] = w[static_cast<std::size_t>(c)];
      for (int k = 0; k < parameters; ++k)
        (*jacobian)(c * n_ + i, k) = j[static_cast<std::size_t>(6 * k + c)];
    }
  }
}

void Problem::amplitude_columns(const physics::Effect& effect, std::vector<double> theta,
                                const std::vector<Eigen::Index>& free, Eigen::MatrixXd& columns) const {
  const auto own = static_cast<Eigen::Index>(free.size());
  columns.resize(rows(), own);
  const auto step_of = [&](std::size_t at) {
    const physics::Parameter& p = effect.info().parameters[at];
    return p.linear ? std::max(std::abs(p.typical - p.neutral), 1e-9) : 1e-3 * p.typical;
  };
  if (effect.memory_size().total() > 0) {
    Eigen::VectorXd moved;
    for (Eigen::Index k = 0; k < own; ++k) {
      const auto at = static_cast<std::size_t>(free[static_cast<std::size_t>(k)]);
      const double step = step_of(at), held = theta[at];
      theta[at] += step;
      wrench_of({&effect, theta}, moved, nullptr);
      theta[at] = held;
      columns.col(k) = moved / step;
    }
    if (forces_only_) columns.bottomRows(3 * n_).setZero();
    return;
  }
  for (int i = 0; i < n_; ++i) {
    for (Eigen::Index k = 0; k < own; ++k) {
      const auto at = static_cast<std::size_t>(free[static_cast<std::size_t>(k)]);
      const double step = step_of(at), held = theta[at];
      theta[at] += step;
      physics::Wrench moved;
      effect.add_wrench(situation(i), theta.data(), moved);
      theta[at] = held;
      for (int c = 0; c < 3; ++c) {
        columns(c * n_ + i, k) = moved.force_B[c] / step;
        columns((c + 3) * n_ + i, k) = forces_only_ ? 0.0 : moved.torque_B[c] / step;
      }
    }
  }
}

void Problem::predict(const std::vector<physics::ActiveEffect>& effects, const Eigen::VectorXd& offset_values,
                      Eigen::VectorXd& rest, Eigen::MatrixXd* jacobian) const {
  Eigen::Index parameters = 0;
  for (const physics::ActiveEffect& e : effects) parameters += e.effect->parameter_count();
  const bool heavy = has_inertia(effects);
  rest = y_ - fast_;
  if (jacobian) jacobian->resize(rows(), parameters + offsets_.cols());
  Eigen::VectorXd value;
  Eigen::MatrixXd columns;
  Eigen::Index at = 0;
  for (const physics::ActiveEffect& e : effects) {
    const Eigen::Index own = e.effect->parameter_count();
    if (has_constant_columns(*e.effect)) {
      const Eigen::MatrixXd& always = constant(*e.effect).columns;
      rest.noalias() -= always * Eigen::Map<const Eigen::VectorXd>(e.theta.data(), own);
      if (jacobian) jacobian->middleCols(at, own) = always;
    } else if (instrumented_ || !adds_inertia(*e.effect)) {
      if (jacobian) {
        const Bent& known = bent(e);
        rest -= known.value;
        jacobian->middleCols(at, own) = known.columns;
      } else {
        wrench_of(e, value, nullptr);
        rest -= value;
      }
    }
    at += own;
  }
  if (heavy) {
    std::vector<Mat6> shrink(static_cast<std::size_t>(n_));
    for (int i = 0; i < n_; ++i) {
      const auto k = static_cast<std::size_t>(i);
      physics::Wrench w;
      for (const physics::ActiveEffect& e : effects)
        if (adds_inertia(*e.effect)) e.effect->add_wrench(situation_[k], e.theta.data(), w);
      Vec6 e;
      for (int c = 0; c < 6; ++c) e[c] = rest[c * n_ + i];
      e.head<3>() -= w.force_B;
      e.tail<3>() -= w.torque_B;
      const Mat6 added = w.moving_inertia(situation_[k]);
      e += added * acceleration_[k];
      const Mat6 inverse = (inertia_ + added).partialPivLu().inverse();
      const Vec6 error = inverse * e;
      shrink[k] = inertia_ * inverse;
      const Vec6 scaled = inertia_ * error;
      for (int c = 0; c < 6; ++c) rest[c * n_ + i] = scaled[c];
      const Vec6 predicted = acceleration_[k] - error;
      situation_[k].a_WB_B = predicted.head<3>();
      situation_[k].dw_WB_B = predicted.tail<3>();
    }
    if (jacobian) {
      at = 0;
      for (const physics::ActiveEffect& e : effects) {
        if (adds_inertia(*e.effect)) {
          wrench_of(e, value, &columns);  // where it is predicted to be, which is not remembered
          jacobian->middleCols(at, columns.cols()) = columns;
        }
        at += e.effect->parameter_count();
      }
      for (int i = 0; i < n_; ++i) {
        for (Eigen::Index k = 0; k < parameters; ++k) {
          Vec6 column;
          for (int c = 0; c < 6; ++c) column[c] = (*jacobian)(c * n_ + i, k);
          const Vec6 scaled = shrink[static_cast<std::size_t>(i)] * column;
          for (int c = 0; c < 6; ++c) (*jacobian)(c * n_ + i, k) = scaled[c];
        }
      }
    }
    for (int i = 0; i < n_; ++i) {
      const auto k = static_cast<std::size_t>(i);
      situation_[k].a_WB_B = acceleration_[k].head<3>();
      situation_[k].dw_WB_B = acceleration_[k].tail<3>();
    }
  }
  rest += fast_ - offsets_ * offset_values;
  if (jacobian) jacobian->rightCols(offsets_.cols()) = offsets_;
  if (forces_only_) {
    rest.tail(3 * n_).setZero();
    if (jacobian) jacobian->bottomRows(3 * n_).setZero();
  }
}

}  // namespace omniflight::diagnosis

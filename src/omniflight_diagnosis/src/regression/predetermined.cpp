#include "predetermined.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "linear_prediction.hpp"
#include "omniflight_diagnosis/residual.hpp"

namespace omniflight::diagnosis {
namespace {

/// Time constant [s] of the low pass of the wrench residual that predicts the acceleration. Chosen: some
/// samples, against sensor noise, and short compared to the motion.
constexpr double kResidualMemory = 0.1;

/// Distance [s], beyond the horizon, of the samples that train the prediction of another one (cross-fitting).
/// Chosen: turbulence at a multirotor is mostly decorrelated after that time.
constexpr double kApart = 0.3;
/// Length [s] of a block of the cross-fitting. Chosen: short compared to a manoeuvre, so that a manoeuvre
/// that is flown once is still predicted by the rest of itself.
constexpr double kBlock = 1.0;

/// Shifts of the reference among the regressors [s]: the vehicle follows it with a delay. Chosen: from one
/// step ahead of the sample to two steps behind.
constexpr double kReferenceStep = 0.075;
constexpr int kReferenceShifts = 4;
/// The same where nothing else is known: a cascade of controllers answers within half a second.
constexpr int kReferenceAloneShifts = 9;

/// Arguments `apart` and `block` of LinearPrediction, in rows.
int rows_apart(double period, int lag) { return lag + static_cast<int>(std::lround(kApart / period)); }
int rows_of_block(double period) { return std::max(1, static_cast<int>(std::lround(kBlock / period))); }

/// Samples of all segments of a flight, one segment after the other.
class Samples {
 public:
  explicit Samples(const Flight& flight) : flight_(flight) {
    for (const Segment& segment : flight.segments)
      for (int i = segment.begin; i < segment.end; ++i) {
        index_.push_back(i);
        begin_.push_back(segment.begin);
      }
  }
  Eigen::Index count() const { return static_cast<Eigen::Index>(index_.size()); }
  /// Of a row in the flight.
  int index(Eigen::Index row) const { return index_[static_cast<std::size_t>(row)]; }
  bool begins(Eigen::Index row) const { return index(row) == begin_[static_cast<std::size_t>(row)]; }
  /// Row of the sample `lag` samples before, or of the first of the segment.
  Eigen::Index before(Eigen::Index row, int lag) const {
    return row - std::min(lag, index(row) - begin_[static_cast<std::size_t>(row)]);
  }
  const physics::Situation& operator[](Eigen::Index row) const {
    return flight_.situation[static_cast<std::size_t>(index(row))];
  }

 private:
  const Flight& flight_;
  std::vector<int> index_, begin_;  ///< a row; the latter of its segment
};

Vec6 acceleration_of(const physics::Situation& x) {
  Vec6 a;
  a << x.a_WB_B, x.dw_WB_B;
  return a;
}

constexpr Eigen::Index kState = 15;

/// State `lag` samples before, on which a controller acts: rate (and one sample earlier), gravity direction,
/// velocity (body axes), position (world).
Eigen::Matrix<double, 1, kState> state_before(const Samples& measured, Eigen::Index row, int lag) {
  const physics::Situation &a = measured[measured.before(row, lag)],
                           &b = measured[measured.before(row, lag + 1)];
  Eigen::Matrix<double, 1, kState> out;
  out << a.body.w_WB_B.transpose(), b.body.w_WB_B.transpose(), a.g_B.transpose(), a.v_WB_B.transpose(),
      a.body.p_WB.transpose();
  return out;
}

/// Speed and acceleration of a rotor; n x 2.
Eigen::MatrixXd turning_of(const Samples& measured, std::size_t rotor) {
  Eigen::MatrixXd out(measured.count(), 2);
  for (Eigen::Index i = 0; i < out.rows(); ++i) {
    const physics::RotorSituation& r = measured[i].rotors[rotor];
    out.row(i) << r.speed, r.acceleration;
  }
  return out;
}

/// `predicted`: speed and acceleration, n x 2.
void set_rotor(const Eigen::MatrixXd& predicted, std::size_t rotor, std::vector<physics::Situation>& out) {
  for (std::size_t i = 0; i < out.size(); ++i) {
    physics::RotorSituation& x = out[i].rotors[rotor];
    x.speed = predicted(static_cast<Eigen::Index>(i), 0);
    x.acceleration = predicted(static_cast<Eigen::Index>(i), 1);
    x.thrust = x.thrust_coefficient * x.speed * std::abs(x.speed);
  }
}

/// Replaces rotor speeds and accelerations in `out` by predictions from their own past, the past state and
/// `asked`.
void predict_rotors(std::vector<physics::Situation>& out, int lag, int block, int apart,
                    const Samples& measured, const Eigen::MatrixXd& asked) {
  const Eigen::Index n = measured.count();
  constexpr Eigen::Index kOwn = 4;
  Eigen::MatrixXd known(n, kState + asked.cols() + kOwn);
  known.middleCols(kState, asked.cols()) = asked;
  for (Eigen::Index i = 0; i < n; ++i) known.row(i).head<kState>() = state_before(measured, i, lag);
  for (std::size_t r = 0; r < static_cast<std::size_t>(out[0].rotor_count); ++r) {
    const auto before = [&](Eigen::Index i, int samples) -> const physics::RotorSituation& {
      return measured[measured.before(i, samples)].rotors[r];
    };
    for (Eigen::Index i = 0; i < n; ++i)
      known.row(i).tail<kOwn>() << before(i, lag).speed, before(i, lag).acceleration,
          before(i, lag + 1).speed, before(i, lag + 2).speed;
    set_rotor(predict_linearly(known, turning_of(measured, r), block, apart), r, out);
  }
}

/// The reference from one step of kReferenceStep ahead of each sample backwards; n x (shifts columns).
Eigen::MatrixXd reference_around(const Eigen::MatrixXd& reference, const Samples& samples, double period,
                                 int shifts) {
  const Eigen::Index n = samples.count(), m = reference.cols();
  const int step = std::max(1, static_cast<int>(std::lround(kReferenceStep / period)));
  Eigen::MatrixXd out(n, m * shifts);
  for (Eigen::Index i = 0; i < n; ++i)
    for (int k = 0; k < shifts; ++k) {
      const Eigen::Index from =
          std::clamp<Eigen::Index>(samples.index(i) + (1 - k) * step, 0, reference.rows() - 1);
      out.row(i).segment(k * m, m) = reference.row(from);
    }
  return out;
}

}  // namespace

double least_horizon(const Flight& flight) { return std::max(6 * flight.kernel_s, 2 * flight.reach_s); }

double least_horizon(std::span<const Flight* const> flights) {
  double out = 0;
  for (const Flight* f : flights) out = std::max(out, least_horizon(*f));
  return out;
}

LinearPrediction predict_from_commands(const Flight& f, const Eigen::MatrixXd& commanded, double period,
                                       int lag, bool reference_alone) {
  const int block = rows_of_block(period), apart = rows_apart(period, lag);
  const Samples measured(f);
  if (reference_alone)
    return {reference_around(f.reference, measured, period, kReferenceAloneShifts), block, apart};
  const Eigen::Index n = measured.count();
  const Eigen::MatrixXd asked = reference_around(f.reference, measured, period, kReferenceShifts);
  // Samples; a motor lag remembers some tenths of a second
  constexpr std::array<int, 5> kBefore{0, 1, 2, 4, 8};
  Eigen::MatrixXd known(n, kState + asked.cols() + static_cast<Eigen::Index>(6 * kBefore.size()));
  known.middleCols(kState, asked.cols()) = asked;
  for (Eigen::Index i = 0; i < n; ++i) {
    known.row(i).head<kState>() = state_before(measured, i, lag);
    for (std::size_t k = 0; k < kBefore.size(); ++k)
      known.row(i).segment<6>(kState + asked.cols() + static_cast<Eigen::Index>(6 * k)) =
          commanded.row(measured.before(i, lag + kBefore[k]));
  }
  return {known, block, apart};
}

std::vector<physics::Situation> predetermined(const Flight& f, const Mat6& inertia,
                                              const Vec3& center_of_mass, double period, int lag,
                                              bool reference_alone) {
  const Samples measured(f);
  const Eigen::Index n = measured.count();
  if (n == 0) return {};
  const int apart = rows_apart(period, lag), block = rows_of_block(period);
  const Eigen::PartialPivLU<Mat6> mass(inertia);
  std::vector<Vec6> rest, slow;  // wrench residual, and its causal low pass
  std::vector<physics::Situation> out;
  const double keep = std::exp(-period / kResidualMemory);
  for (Eigen::Index i = 0; i < n; ++i) {
    const physics::Situation& now = measured[i];
    rest.push_back(wrench_residual(now, now.a_WB_B - now.g_B, center_of_mass));
    slow.push_back(measured.begins(i) ? rest.back() : Vec6(keep * slow.back() + (1 - keep) * rest.back()));
    out.push_back(now);
  }
  const Eigen::MatrixXd asked = reference_around(f.reference, measured, period,
                                                 reference_alone ? kReferenceAloneShifts : kReferenceShifts);
  const auto from_reference =
      reference_alone ? std::optional<LinearPrediction>(std::in_place, asked, block, apart) : std::nullopt;
  if (from_reference)
    for (std::size_t r = 0; r < static_cast<std::size_t>(out[0].rotor_count); ++r)
      set_rotor(from_reference->of(turning_of(measured, r)), r, out);
  else
    predict_rotors(out, lag, block, apart, measured, asked);
  Eigen::MatrixXd known(n, 24 + asked.cols()), targets(n, 9);
  known.rightCols(asked.cols()) = asked;
  const auto ahead_of = [&](Eigen::Index i) {
    return static_cast<double>(i - measured.before(i, lag)) * period;
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    physics::Situation& s = out[static_cast<std::size_t>(i)];
    const Eigen::Index from = measured.before(i, lag);
    const physics::Situation &now = measured[i], &last = measured[from];
    const double ahead = ahead_of(i);
    // acceleration of the predicted rotors, and of the low-passed residual at the horizon
    const Vec6 modelled =
        acceleration_of(now) +
        mass.solve(physics::rotor_wrench(s) - physics::rotor_wrench(now) - rest[static_cast<std::size_t>(i)]);
    const Vec6& left = slow[static_cast<std::size_t>(from)];
    const Vec6 mean = 0.5 * (acceleration_of(last) + modelled + mass.solve(left));
    const Vec3 w = last.body.w_WB_B + ahead * mean.tail<3>();
    const Vec3 v = last.v_WB_B + ahead * mean.head<3>();  // in body axes of the sample at the horizon
    known.row(i).head<24>() << w.transpose(), v.transpose(), last.body.w_WB_B.transpose(),
        last.v_WB_B.transpose(), left.transpose(), modelled.transpose();
    targets.row(i) << now.body.w_WB_B.transpose(), (last.R_WB.transpose() * now.body.v_WB_W).transpose(),
        now.dw_WB_B.transpose();
    // internal states of loads are driven by the measured acceleration (Situation::memory_acceleration)
    s.observed = true;
    s.observed_a_B = now.a_WB_B;
    s.observed_dw_B = now.dw_WB_B;
    s.a_WB_B = modelled.head<3>();
  }
  // The angular acceleration is predicted without the residual: otherwise an inertia error of any sign would
  // predict the residual from its own past.
  Eigen::MatrixXd motion(n, 12 + asked.cols());
  motion << known.middleCols(6, 6), known.middleCols(18, 6), asked;
  const auto predict = [&](const Eigen::MatrixXd& from, const Eigen::MatrixXd& what) {
    return from_reference ? from_reference->of(what) : predict_linearly(from, what, block, apart);
  };
  const Eigen::MatrixXd predicted = predict(known, targets.leftCols(6)),
                        turning = predict(motion, targets.rightCols(3));
  for (Eigen::Index i = 0; i < n; ++i) {
    physics::Situation& s = out[static_cast<std::size_t>(i)];
    const physics::Situation& last = measured[measured.before(i, lag)];
    const double ahead = ahead_of(i);
    s.body.w_WB_B = predicted.row(i).segment<3>(0).transpose();
    s.body.v_WB_W = last.R_WB * Vec3(predicted.row(i).segment<3>(3).transpose());
    s.body.p_WB = last.body.p_WB + 0.5 * ahead * (last.body.v_WB_W + s.body.v_WB_W);
    s.body.q_WB = last.body.q_WB * exp_rotation(0.5 * ahead * (last.body.w_WB_B + s.body.w_WB_B));
    s.R_WB = s.body.q_WB.toRotationMatrix();
    s.v_WB_B = s.R_WB.transpose() * s.body.v_WB_W;
    s.dw_WB_B = turning.row(i).transpose();
    // The specific force is that of the predicted rotors, with gravity in the predicted attitude, and again
    // without the residual: otherwise a mass error of any sign would predict the residual from its own past.
    const Vec3 g_B = s.R_WB.transpose() * Vec3(0, 0, -s.environment.gravity);
    s.a_WB_B += g_B - measured[i].g_B;
    s.g_B = g_B;
  }
  return out;
}

}  // namespace omniflight::diagnosis

#include "control_replay.hpp"

#include <algorithm>
#include <cmath>

#include "../conditioning/attitude_rows.hpp"
#include "../conditioning/decimate.hpp"
#include "../conditioning/segments.hpp"
#include "../numerics/statistics.hpp"
#include "../numerics/text.hpp"
#include "merge_recordings.hpp"
#include "omniflight_diagnosis/filter.hpp"
#include "omniflight_physics/effect_ids.hpp"

namespace omniflight::diagnosis {
namespace {

// Chosen, not measured, where nothing else is said.
// Hz, grid and low pass: below the effects of estimators and delays
constexpr double kRate = 50, kCutoff = 4;
constexpr double kReach = 0.3;  // s, length of the low pass: samples left out around a gap
constexpr double kBlock = 5;    // s, block with its own mean: integrators saturate and are reset in between
constexpr int kLeastBlocks = 4;
constexpr double kLeastShare = 0.8;  // of the command's variance explained; below, another control law flew
constexpr double kLeastSigmas = 4;   // standard errors by which a gain must differ
// Relative difference of proportional, derivative and integral gain; saturation and resets bias the integral
// gain.
constexpr double kLeastChange[] = {0.15, 0.15, 0.5};
// Of the blocks: a difference in these alone is a limit that was hit, not a gain
constexpr double kWorst = 0.25;
constexpr double kLate = 0.02;  // s, delay of the logged state that is tolerated

/// Unknowns of the regression: proportional, derivative and integral gain, and to absorb delays the
/// derivative of the rate, the reference rate and its derivative.
constexpr int kUnknowns = 6;
using MatU = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using VecU = Eigen::Matrix<double, kUnknowns, 1>;

/// One control loop: command and the regressors of its gains, n x 3, one column per axis.
struct Loop {
  std::array<const char*, 3> gain, unit;
  std::array<Vec3*, 3> value;  ///< told gains; judge() replaces them by the estimates
  std::array<const char*, 3> axis;
  Eigen::MatrixXd command, error, rate;
  Eigen::MatrixXd motion;  ///< rate of the reference; a delayed pose deviates by a multiple of it
  std::vector<char> valid;
};

/// Delay [s] of the logged pose and rates relative to the command.
struct Lateness {
  double pose = 0, rate = 0;
};

struct Gains {
  Vec3 value, se;
  Vec3 usual;        ///< estimate without the kWorst blocks, in which the told gains fit worst
  double share = 0;  ///< explained share of the command's variance
  double off = 0;    ///< RMS of command minus prediction by the told gains
};

/// Regressors and command of an axis in blocks of kBlock, each centred; samples x (kUnknowns + 1).
std::vector<Eigen::MatrixXd> blocks_of(const Loop& loop, Eigen::Index axis) {
  const Eigen::Index n = loop.command.rows();
  Eigen::MatrixXd x(n, kUnknowns + 1);  // and the command
  x << loop.error.col(axis), loop.rate.col(axis), loop.error.col(axis), loop.rate.col(axis),
      loop.motion.col(axis), loop.motion.col(axis), loop.command.col(axis);
  for (Eigen::Index i = 1; i < n; ++i) x(i, 2) = x(i - 1, 2) + loop.error(i, axis) / kRate;
  x = low_pass(x, kRate, kCutoff);
  for (const int k : {3, 5}) x.col(k) = differentiate(x.col(k), kRate);
  const auto length = static_cast<Eigen::Index>(kBlock * kRate);
  std::vector<Eigen::MatrixXd> blocks;
  for (Eigen::Index from = 0; from + length <= n; from += length) {
    Eigen::MatrixXd block(length, kUnknowns + 1);
    Eigen::Index kept = 0;
    for (Eigen::Index i = from; i < from + length; ++i)
      if (loop.valid[static_cast<std::size_t>(i)]) block.row(kept++) = x.row(i);
    if (kept < length / 2) continue;
    block.conservativeResize(kept, kUnknowns + 1);
    block.rowwise() -= block.colwise().mean().eval();
    blocks.push_back(std::move(block));
  }
  return blocks;
}

/// Squared norm of command minus prediction by the told gains.
double off_in(const Eigen::MatrixXd& block, const Vec3& told) {
  return (block.col(kUnknowns) - block.leftCols<3>() * told).squaredNorm();
}

/// Least squares over centred blocks with cluster-robust standard errors (blocks as clusters; noise may be
/// coloured). Empty where the regressors are collinear.
std::optional<Gains> regress(const std::vector<Eigen::MatrixXd>& blocks, const Vec3& told) {
  if (blocks.size() < 2) return std::nullopt;
  MatU H = MatU::Zero();
  VecU g = VecU::Zero();
  double energy = 0;
  Eigen::Index samples = 0;
  for (const auto& b : blocks) {
    H += b.leftCols<kUnknowns>().transpose() * b.leftCols<kUnknowns>();
    g += b.leftCols<kUnknowns>().transpose() * b.col(kUnknowns);
    energy += b.col(kUnknowns).squaredNorm();
    samples += b.rows();
  }
  for (const int k : {4, 5})
    if (H(k, k) < 1e-12) H(k, k) = 1;  // constant reference
  const VecU scale = H.diagonal().cwiseSqrt().cwiseMax(1e-12).cwiseInverse();
  const MatU scaled = scale.asDiagonal() * H * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatU> eigen(scaled);
  if (energy <= 0 || eigen.eigenvalues()[0] < 1e-6) return std::nullopt;
  const MatU inverse = scale.asDiagonal() * scaled.inverse() * scale.asDiagonal();
  Gains out;
  const VecU found = inverse * g;
  MatU scatter = MatU::Zero();
  double rest = 0, off = 0;
  for (const auto& b : blocks) {
    const Eigen::VectorXd r = b.col(kUnknowns) - b.leftCols<kUnknowns>() * found;
    const VecU score = b.leftCols<kUnknowns>().transpose() * r;
    scatter += score * score.transpose();
    rest += r.squaredNorm();
    off += off_in(b, told);
  }
  const auto count = static_cast<double>(blocks.size());
  out.value = out.usual = found.head<3>();
  out.se = (count / (count - 1) * inverse * scatter * inverse).diagonal().head<3>().cwiseSqrt();
  out.share = 1 - rest / energy;
  out.off = std::sqrt(off / static_cast<double>(samples));
  return out;
}

/// Gains of one axis; empty with fewer than kLeastBlocks blocks.
std::optional<Gains> gains_of(const Loop& loop, Eigen::Index axis, const Vec3& told) {
  const std::vector<Eigen::MatrixXd> blocks = blocks_of(loop, axis);
  if (static_cast<int>(blocks.size()) < kLeastBlocks) return std::nullopt;
  std::vector<double> off;
  for (const auto& b : blocks) off.push_back(off_in(b, told));
  std::vector<double> sorted = off;
  std::sort(sorted.begin(), sorted.end());
  const double limit = sorted[static_cast<std::size_t>((1 - kWorst) * static_cast<double>(off.size() - 1))];
  std::vector<Eigen::MatrixXd> rest;
  for (std::size_t b = 0; b < blocks.size(); ++b)
    if (off[b] <= limit) rest.push_back(blocks[b]);
  auto all = regress(blocks, told);
  const auto usual = regress(rest, told);
  if (all && usual) all->usual = usual->value;
  return all;
}

/// The loop with pose and rates shifted to the clock of the command, by the delays that leave the least
/// residual. The first-order terms of the regression do not suffice: with a gyro 8 ms late, a rate gain came
/// out a quarter too small (CHANGELOG).
template <class Make>
Loop on_one_clock(const Make& make) {
  constexpr double kLatest = 0.05, kFirst = 0.008, kLast = 0.0005;  // s, bound, first and last step; chosen
  // Least relative reduction of the residual: shifted noise alone reaches some; chosen
  constexpr double kWorth = 0.7;
  const auto left_by = [&](const Lateness& late) {
    const Loop loop = make(late);
    double left = 0;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const auto gains = regress(blocks_of(loop, axis), Vec3::Zero());
      left += gains ? 1 - gains->share : 1;
    }
    return left;
  };
  Lateness late;
  double least = left_by(late);
  for (double Lateness::*clock : {&Lateness::rate, &Lateness::pose}) {
    Lateness best = late;
    double left = least;
    for (double step = kFirst; step > kLast; step /= 2)
      for (bool better = true; better;) {
        better = false;
        for (const double by : {step, -step}) {
          Lateness tried = best;
          tried.*clock += by;
          if (std::abs(tried.*clock) > kLatest) continue;
          if (const double l = left_by(tried); l < left * (1 - 1e-6)) left = l, best = tried, better = true;
        }
      }
    if (left < kWorth * least) late = best, least = left;
  }
  return make(late);
}

/// Gains that are compared: three of each axis of two loops (Bonferroni).
constexpr double kCompared = 18;

/// Compares the estimated gains of a loop with the told ones, adds differences to f and mismatch, and stores
/// the estimates.
void judge(const Loop& loop, const std::string& frame, Finding& f, std::vector<Mismatch>& mismatch) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Vec3 told((*loop.value[0])[axis], (*loop.value[1])[axis], (*loop.value[2])[axis]);
    const auto gains = gains_of(loop, axis, told);
    if (!gains || gains->share < kLeastShare) continue;
    std::string words;
    double p_value = 1;
    for (int k = 0; k < 3; ++k) {
      const double difference = gains->value[k] - told[k];
      const double late =
          k == 1 ? kLate * told[0] : 0;  // a delayed error adds kp times the delay to the rate gain
      if (told[k] <= 0 ||                // nothing to compare
          std::abs(difference) <
              std::max(kLeastSigmas * gains->se[k], (kLeastChange[k] + 1 - gains->share) * told[k] + late) ||
          std::abs(gains->usual[k] - told[k]) < kLeastChange[k] * told[k])
        continue;
      p_value = std::min(p_value, kCompared * chi_squared_tail(std::pow(difference / gains->se[k], 2), 1));
      const auto which = static_cast<std::size_t>(k);
      const std::string name =
          std::string(loop.gain[which]) + "_" + loop.axis[static_cast<std::size_t>(axis)];
      const double half = 1.96 * gains->se[k];
      (*loop.value[which])[axis] = std::max(0.0, gains->value[k]);
      f.parameters.push_back(
          {name, name, loop.unit[which], gains->value[k], gains->value[k] - half, gains->value[k] + half});
      words += format("%s%s is %.3g, told %.3g", words.empty() ? "" : ", ", name.c_str(), gains->value[k],
                      told[k]);
    }
    if (words.empty()) continue;
    Mismatch m;
    m.stage = physics::Stage::control;
    m.channel = std::string("qddr_") + loop.axis[static_cast<std::size_t>(axis)];
    m.frame = frame;
    m.unit = frame == "world" ? "m/s2" : "rad/s2";
    m.p_value = p_value;
    m.rms = gains->off;
    m.where = words;
    f.channels.push_back(m.channel);
    f.sentence += (f.sentence.empty() ? "" : "; ") + words;
    mismatch.push_back(std::move(m));
  }
}

}  // namespace

void add_control(const recording::Recording& r, const ToldController& told, Diagnosis& d,
                 bool attitude_free) {
  // Prefer the estimate that the controller used: noise in measured regressors attenuates the gains.
  const auto seen = [&](const char* estimate, const char* measured) {
    const recording::Signal* s = r.find(estimate);
    return s ? s : r.find(measured);
  };
  const recording::Signal *asked = r.find("qddr"), *p = seen("est_position", "position"),
                          *q = seen("est_attitude", "attitude"), *ref_p = r.find("ref_position"),
                          *ref_q = r.find("ref_attitude");
  if (!asked || asked->width() != 6 || asked->size() < 200) return;
  std::vector<double> t;
  for (double at = asked->t_s.front(); at < asked->t_s.back() && t.size() < 1000000; at += 1 / kRate)
    t.push_back(at);
  std::vector<char> valid(t.size(), 1);
  const auto leave_out = [&](std::ptrdiff_t i) {  // with the length of the low pass
    const auto reach = static_cast<std::ptrdiff_t>(kReach * kRate), n = static_cast<std::ptrdiff_t>(t.size());
    for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(0, i - reach); k <= std::min(n - 1, i + reach); ++k)
      valid[static_cast<std::size_t>(k)] = 0;
  };
  // resampled onto the grid; samples in gaps are bridged for the filter and left out of the regression
  const auto read = [&](recording::Signal s, double late = 0) {
    for (double& at : s.t_s) at -= late;
    if (recording::is_attitude(s.name)) make_continuous(s.values);
    s = decimate(s, 1 / kRate);  // aliased noise would attenuate the gains
    const Eigen::MatrixXd strict = recording::resample(s, t, std::max(0.1, 3 * s.median_period_s()));
    for (Eigen::Index i = 0; i < strict.rows(); ++i)
      if (!strict.row(i).allFinite()) leave_out(i);
    Eigen::MatrixXd x = recording::resample(s, t);
    for (Eigen::Index i = 0; i < x.rows(); ++i)
      if (!x.row(i).allFinite()) x.row(i) = i > 0 ? x.row(i - 1).eval() : Eigen::RowVectorXd::Zero(x.cols());
    return x;
  };
  const auto optional = [&](const char* name) -> Eigen::MatrixXd {
    const recording::Signal* s = r.find(name);
    if (!s || s->width() != 3) return Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(t.size()), 3);
    return read(*s);
  };
  const Eigen::MatrixXd command = read(*asked);
  if (const recording::Signal* phase = r.find("phase")) {  // held vehicles are not controlled
    const std::vector<char> free = in_free_flight(*phase, t);
    for (std::size_t i = 0; i < free.size(); ++i)
      if (!free[i]) leave_out(static_cast<std::ptrdiff_t>(i));
  }
  ToldController flown = told;
  Finding f;
  std::vector<Mismatch> mismatch;
  if (p && ref_p) {
    const recording::Signal *v = r.find("est_velocity"), *ref_v = r.find("ref_velocity");
    const bool with_velocity = v && ref_v && v->width() == 3 && ref_v->width() == 3;
    const Eigen::MatrixXd wanted = read(*ref_p), rest = command.leftCols(3) - optional("ref_acceleration");
    const auto loop = [&](const Lateness& late) {
      const Eigen::MatrixXd error = wanted - read(*p, late.pose);
      const Eigen::MatrixXd rate =
          with_velocity ? Eigen::MatrixXd(read(*ref_v) - read(*v, late.rate)) : differentiate(error, kRate);
      return Loop{{"kp", "kv", "ki"},
                  {"1/s2", "1/s", "1/s3"},
                  {&flown.kp, &flown.kv, &flown.ki},
                  {"x", "y", "z"},
                  rest,
                  error,
                  rate,
                  differentiate(wanted, kRate),
                  valid};
    };
    judge(on_one_clock(loop), "world", f, mismatch);
  }
  const recording::Signal* gyro = seen("est_angular_velocity", "gyro");
  if (attitude_free && q && ref_q && gyro && gyro->width() == 3) {
    const Eigen::MatrixXd wanted = read(*ref_q), w_ref = optional("ref_angular_velocity"),
                          dw_ref = optional("ref_angular_acceleration");
    const auto loop = [&](const Lateness& late) {
      const Eigen::MatrixXd at = read(*q, late.pose), w = read(*gyro, late.rate);
      Loop out{{"kR", "kw", "kI"},
               {"1/s2", "1/s", "1/s3"},
               {&flown.kR, &flown.kw, &flown.kI},
               {"roll", "pitch", "yaw"},
               command.rightCols(3),
               Eigen::MatrixXd::Zero(w.rows(), 3),
               Eigen::MatrixXd::Zero(w.rows(), 3),
               Eigen::MatrixXd::Zero(w.rows(), 3),
               valid};
      for (Eigen::Index i = 0; i < w.rows(); ++i) {
        const Mat3 R_BD = (quaternion(at, i).conjugate() * quaternion(wanted, i)).toRotationMatrix();
        out.error.row(i) = vee(R_BD).transpose();
        out.motion.row(i) = (R_BD * w_ref.row(i).transpose()).transpose();
        out.rate.row(i) = out.motion.row(i) - w.row(i);
        out.command.row(i) -= (R_BD * dw_ref.row(i).transpose()).transpose();
        if (out.error.row(i).allFinite() && out.command.row(i).allFinite()) continue;
        out.valid[static_cast<std::size_t>(i)] = 0;
        for (Eigen::MatrixXd* x : {&out.error, &out.motion, &out.rate, &out.command}) x->row(i).setZero();
      }
      return out;
    };
    judge(on_one_clock(loop), "body", f, mismatch);
  }
  if (f.parameters.empty()) return;
  f.effect = physics::effect_id::controller_mismatch;
  f.stage = physics::Stage::control;
  f.sentence = "The controller asks for something else than its told gains do: " + f.sentence + ".";
  f.equation = "qddr = feed-forward + k_p e + k_v de/dt + k_i integral(e)";
  d.findings.push_back(std::move(f));
  for (Mismatch& m : mismatch) d.mismatch.push_back(std::move(m));
  d.controller = flown;
}

void add_controls(const std::vector<const recording::Recording*>& recordings, const ToldController& told,
                  Diagnosis& d, bool attitude_free) {
  for (const recording::Recording* r : recordings) {
    Diagnosis one;
    add_control(*r, told, one, attitude_free);
    merge_recording(one, r->file, d);
    if (r == recordings.front()) d.controller = one.controller;
  }
}

}  // namespace omniflight::diagnosis

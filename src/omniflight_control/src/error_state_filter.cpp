#include "omniflight_control/error_state_filter.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace omniflight::control {
namespace {

constexpr double kLongestStep = 0.05;   // s; a longer gap of the IMU is bridged by poses, not by integration
constexpr double kLongestAhead = 0.01;  // s that a pose may be newer than the newest inertial sample
constexpr double kMostAccelerometerBias = 3.0,
                 kMostGyroBias = 0.5;  // m/s^2, rad/s: beyond, the sensor is broken
// what a vehicle may do in a gap of its IMU that nobody saw
constexpr double kUnseenAcceleration = 3.0, kUnseenRate = 1.0;  // m/s^2, rad/s
// uncertainty at the start, beside that of the pose
constexpr double kFirstVelocity = 0.5, kFirstAccelerometerBias = 0.3, kFirstGyroBias = 0.05;
// opened when the estimate is suspected: m, m/s, rad
constexpr double kOpenPosition = 0.3, kOpenVelocity = 1.0, kOpenAttitude = 0.3;

enum Block { kP = 0, kV = 3, kR = 6, kA = 9, kG = 12 };

double square(double x) { return x * x; }

Vec3 bounded(const Vec3& v, double most) { return v.cwiseMax(-most).cwiseMin(most); }

}  // namespace

ErrorStateFilter::ErrorStateFilter(const ErrorStateConfig& config) : config_(config), samples_(kSamples) {}

void ErrorStateFilter::push(const Sample& s) {
  if (count_ == kSamples) use_up_oldest();  // no pose for long
  samples_[(first_ + count_++) % kSamples] = s;
}

ErrorStateFilter::Sample ErrorStateFilter::between(const Sample& a, const Sample& b, double t) const {
  const double share = std::clamp((t - a.t) / (b.t - a.t), 0.0, 1.0);
  return {t, a.f + share * (b.f - a.f), a.w + share * (b.w - a.w)};
}

void ErrorStateFilter::advance(Nominal& x, const Sample& a, const Sample& b) const {
  const double dt = std::clamp(b.t - a.t, 0.0, kLongestStep);
  const Quat q1 = (x.q * exp_rotation((0.5 * (a.w + b.w) - x.bg) * dt)).normalized();
  const Vec3 acceleration = 0.5 * (x.q * (a.f - x.ba) + q1 * (b.f - x.ba)) + Vec3(0, 0, -config_.gravity);
  x.p += x.v * dt + 0.5 * acceleration * dt * dt;
  x.v += acceleration * dt;
  x.q = q1;
}

/// P <- F P F^T + Q, block row by block row; x: before the step.
void ErrorStateFilter::advance(Covariance& P, const Nominal& x, const Sample& a, const Sample& b) const {
  const double gap = std::max(0.0, b.t - a.t), dt = std::min(gap, kLongestStep), unseen = gap - dt;
  const Vec3 w = 0.5 * (a.w + b.w) - x.bg, f = 0.5 * (a.f + b.f) - x.ba;
  const Mat3 R = x.q.toRotationMatrix();
  const Mat3 v_theta = -R * skew(f) * dt, v_ba = -R * dt;
  const Mat3 theta_theta = exp_rotation(w * dt).toRotationMatrix().transpose();
  P.middleRows<3>(kP) += dt * P.middleRows<3>(kV);
  P.middleRows<3>(kV) += v_theta * P.middleRows<3>(kR) + v_ba * P.middleRows<3>(kA);
  P.middleRows<3>(kR) = (theta_theta * P.middleRows<3>(kR) - dt * P.middleRows<3>(kG)).eval();
  P.middleCols<3>(kP) += dt * P.middleCols<3>(kV);
  P.middleCols<3>(kV) += P.middleCols<3>(kR) * v_theta.transpose() + P.middleCols<3>(kA) * v_ba.transpose();
  P.middleCols<3>(kR) = (P.middleCols<3>(kR) * theta_theta.transpose() - dt * P.middleCols<3>(kG)).eval();
  const auto add = [&P](Block block, double variance) { P.diagonal().segment<3>(block).array() += variance; };
  add(kV, square(config_.accelerometer_noise) * dt + square(kUnseenAcceleration * unseen));
  add(kR, square(config_.gyro_noise) * dt + square(kUnseenRate * unseen));
  add(kA, square(config_.accelerometer_walk) * gap);
  add(kG, square(config_.gyro_walk) * gap);
  if (unseen > 0) add(kP, square(unseen * (x.v.norm() + kUnseenAcceleration * unseen)));
}

/// Before the first pose there is no state to move, only the sample that it will start from.
void ErrorStateFilter::advance_base(const Sample& to) {
  if (ready_) {
    advance(P_, base_, base_sample_, to);
    advance(base_, base_sample_, to);
  }
  base_sample_ = to;
}

void ErrorStateFilter::use_up_oldest() {
  advance_base(sample(0));
  first_ = (first_ + 1) % kSamples;
  --count_;
}

void ErrorStateFilter::add_imu(double t, const Vec3& f, const Vec3& w) {
  if (!is_usable(t, f, w) || (has_imu_ && t <= newest_.t)) {
    ++refused_;
    return;
  }
  const Sample s{t, f, w};
  if (ready_ && t <= base_sample_.t) {  // before the instant of the last pose
    base_sample_ = {base_sample_.t, f, w};
    newest_ = s;
    has_imu_ = true;
    return;
  }
  if (!has_imu_) base_sample_ = ready_ ? Sample{base_sample_.t, f, w} : s;
  if (ready_) advance(now_, count_ > 0 ? newest_ : base_sample_, s);
  newest_ = s;
  has_imu_ = true;
  push(s);
  publish();
}

void ErrorStateFilter::publish() {
  if (ready_) state_ = {now_.p, now_.q, now_.v, newest_.w - now_.bg};
}

/// The present state from the base and the samples since.
void ErrorStateFilter::replay() {
  now_ = base_;
  Sample before = base_sample_;
  for (std::size_t k = 0; k < count_; ++k) {
    advance(now_, before, sample(k));
    before = sample(k);
  }
  publish();
}

ErrorStateFilter::Covariance ErrorStateFilter::covariance() const {
  Covariance P = P_;
  Nominal x = base_;
  Sample before = base_sample_;
  for (std::size_t k = 0; k < count_; ++k) {
    advance(P, x, before, sample(k));
    advance(x, before, sample(k));
    before = sample(k);
  }
  return P;
}

void ErrorStateFilter::open_covariance() {
  P_.topLeftCorner<9, 9>().setZero();
  P_.topRightCorner<9, 6>().setZero();
  P_.bottomLeftCorner<6, 9>().setZero();
  P_.diagonal().segment<3>(kP).setConstant(square(kOpenPosition));
  P_.diagonal().segment<3>(kV).setConstant(square(kOpenVelocity));
  P_.diagonal().segment<3>(kR).setConstant(square(kOpenAttitude));
}

/// False when the innovation is larger than noise explains.
bool ErrorStateFilter::update(const Vec3& e_p, const Vec3& e_R) {
  Eigen::Matrix<double, 15, 6> PHt;
  PHt << P_.middleCols<3>(kP), P_.middleCols<3>(kR);
  Mat6 S;
  S << PHt.middleRows<3>(kP), PHt.middleRows<3>(kR);
  S.diagonal().head<3>().array() += square(config_.position_noise);
  S.diagonal().tail<3>().array() += square(config_.attitude_noise);
  Vec6 e;
  e << e_p, e_R;
  const Eigen::LLT<Mat6> factor(S);
  innovation_ = e.dot(factor.solve(e));
  if (!(innovation_ <= config_.gate)) return false;
  const Eigen::Matrix<double, 15, 6> K = factor.solve(PHt.transpose()).transpose();
  const Eigen::Matrix<double, 15, 1> d = K * e;
  base_.p += d.segment<3>(kP);
  base_.v += d.segment<3>(kV);
  base_.q = (base_.q * exp_rotation(d.segment<3>(kR))).normalized();
  base_.ba = bounded(base_.ba + d.segment<3>(kA), kMostAccelerometerBias);
  base_.bg = bounded(base_.bg + d.segment<3>(kG), kMostGyroBias);
  P_ -= K * PHt.transpose();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  return true;
}

void ErrorStateFilter::add_mocap(double t, const Vec3& p, const Quat& q_measured) {
  if (!is_usable(t, p, q_measured) || t <= heard_time_ || (ready_ && t <= base_sample_.t)) {
    ++refused_;
    return;
  }
  const Quat q = q_measured.normalized();
  heard_time_ = t;
  // up to the instant of the pose; what is older is not needed any more
  while (count_ > 0 && sample(0).t <= t) use_up_oldest();
  if (count_ > 0 && base_sample_.t < t) advance_base(between(base_sample_, sample(0), t));
  if (!ready_) {
    base_ = {p, Vec3::Zero(), q, Vec3::Zero(), Vec3::Zero()};
    if (!has_imu_) base_sample_.t = t;
    open_covariance();
    P_.diagonal().segment<3>(kP).setConstant(square(config_.position_noise));
    P_.diagonal().segment<3>(kV).setConstant(square(kFirstVelocity));
    P_.diagonal().segment<3>(kR).setConstant(square(config_.attitude_noise));
    P_.diagonal().segment<3>(kA).setConstant(square(kFirstAccelerometerBias));
    P_.diagonal().segment<3>(kG).setConstant(square(kFirstGyroBias));
    ready_ = true;
    mocap_time_ = t;
    replay();
    return;
  }
  const double ahead = std::clamp(t - base_sample_.t, 0.0, kLongestAhead);
  const Vec3 e_p = p - (base_.p + base_.v * ahead);
  const Vec3 e_R =
      log_rotation((base_.q * exp_rotation((base_sample_.w - base_.bg) * ahead)).conjugate() * q);
  bool accepted = update(e_p, e_R);
  if (!accepted && refused_since_ >= 0 && t - refused_since_ > config_.recover_after) {
    open_covariance();  // poses alone say where the vehicle is
    accepted = update(e_p, e_R);
  }
  if (accepted) {
    mocap_time_ = t;
    refused_since_ = -1.0;
  } else {
    ++outliers_;
    if (refused_since_ < 0) refused_since_ = t;
  }
  replay();
}

}  // namespace omniflight::control

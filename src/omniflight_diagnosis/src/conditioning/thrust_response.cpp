#include "thrust_response.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace omniflight::diagnosis {
namespace {

// Chosen, not measured.
constexpr double kLeastExplained = 0.85;                // see thrust_response()
constexpr std::array kLeads{-1.0, 0.2, 0.4, 0.7, 1.0};  // 1
constexpr int kTimes = 13;                              // time constants, evenly in their logarithm
constexpr double kShortest = 0.004, kLongest = 0.1;     // s

double time_at(int k) { return kShortest * std::pow(kLongest / kShortest, k / (kTimes - 1.0)); }

/// Columns through a first-order lag that begins at rest.
Eigen::MatrixXd lagged(const Eigen::MatrixXd& x, double time, double rate_hz) {
  const double kept = std::exp(-1 / (rate_hz * time));
  Eigen::MatrixXd out = x;
  for (Eigen::Index i = 1; i < x.rows(); ++i)
    // exact for an input that is linear between samples, to the order of its curvature
    out.row(i) = kept * out.row(i - 1) + (1 - kept) * 0.5 * (x.row(i) + x.row(i - 1));
  return out;
}

/// One axis: what is measured, what the rotors do at once and as settled, and their spin-up.
struct Axis {
  Eigen::VectorXd y, now, spin_up;
};

/// Inner products of (now, settled, spin-up, 1) with each other and with y, over the samples in use.
struct Products {
  Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
  Eigen::Vector4d g = Eigen::Vector4d::Zero();
  double sum = 0, squares = 0, count = 0;

  Products(const Axis& a, const Eigen::VectorXd& settled, const std::vector<int>& rows, int shift) {
    for (const int i : rows) {
      const Eigen::Vector4d x(a.now[i - shift], settled[i - shift], a.spin_up[i - shift], 1);
      H += x * x.transpose();
      g += a.y[i] * x;
      sum += a.y[i];
      squares += a.y[i] * a.y[i];
    }
    count = static_cast<double>(rows.size());
  }
  /// Share of the variance of y that thrust with this lead leaves; 1 where its coefficient is not positive.
  double left(double lead) const {
    Eigen::Matrix<double, 4, 3> mix = Eigen::Matrix<double, 4, 3>::Zero();
    mix(0, 0) = 1 + lead;
    mix(1, 0) = -lead;
    mix(2, 1) = mix(3, 2) = 1;
    const Eigen::Matrix3d h = mix.transpose() * H * mix;
    const Vec3 b = mix.transpose() * g;
    const Vec3 scale = h.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    Eigen::Matrix3d scaled = scale.asDiagonal() * h * scale.asDiagonal();
    scaled.diagonal().array() += 1e-12;
    const Vec3 x = scaled.ldlt().solve(scale.cwiseProduct(b));
    const double all = squares - sum * sum / count;
    if (!(all > 0) || !(x[0] > 0)) return 1;
    return std::clamp((squares - scale.cwiseProduct(b).dot(x)) / all, 1e-6, 1.0);
  }
};

double log_mean_exp(const std::vector<double>& x) {
  const double most = *std::max_element(x.begin(), x.end());
  double sum = 0;
  for (const double v : x) sum += std::exp(v - most);
  return most + std::log(sum / static_cast<double>(x.size()));
}

class Axes {
 public:
  Axes(const Eigen::MatrixXd& dw, const Eigen::MatrixXd& force, const RotorExcitation& rotors, double rate_hz,
       const std::vector<char>& use)
      : rate_hz_(rate_hz), reach_(static_cast<int>(std::ceil(kReach * rate_hz))) {
    const auto n = static_cast<int>(dw.rows());
    for (int i = reach_; i < n - reach_; ++i)
      if (use[static_cast<std::size_t>(i)]) rows_.push_back(i);
    const auto add = [&](const Eigen::MatrixXd& y, const Eigen::MatrixXd& x, const Eigen::MatrixXd& up) {
      const Eigen::MatrixXd quick_y = quick_part(y, rate_hz), quick_x = quick_part(x, rate_hz),
                            quick_up = quick_part(up, rate_hz);
      for (Eigen::Index c = 0; c < 3; ++c) axes_.push_back({quick_y.col(c), quick_x.col(c), quick_up.col(c)});
    };
    add(dw, rotors.torque, rotors.spin_up);
    if (force.rows() == dw.rows()) add(force, rotors.force, Eigen::MatrixXd::Zero(rotors.spin_up.rows(), 3));
  }
  bool enough() const { return static_cast<double>(rows_.size()) >= 3 * rate_hz_; }
  int reach() const { return reach_; }

  /// ln likelihood of each of the leads with this time constant; their order is that of `leads`.
  template <class Leads>
  std::vector<double> of(double time, int shift, const Leads& leads) {
    std::vector<double> out(leads.size(), 0.0);
    for (const Axis& a : axes_) {
      const Eigen::VectorXd settled = time > 0 ? Eigen::VectorXd(lagged(a.now, time, rate_hz_)) : a.now;
      const Products p(a, settled, rows_, shift);
      for (std::size_t k = 0; k < leads.size(); ++k) {
        const double left = p.left(leads[k]);
        if (time > 0) explained_ = std::max(explained_, 1 - left);
        out[k] -= 0.5 * std::log(left) * static_cast<double>(rows_.size()) / (kCorrelation * rate_hz_);
      }
    }
    return out;
  }
  double explained() const { return explained_; }

 private:
  double rate_hz_;
  int reach_;
  std::vector<int> rows_;
  std::vector<Axis> axes_;
  double explained_ = 0;  ///< largest share of an axis that any response has explained so far
};

}  // namespace

std::optional<ThrustResponse> thrust_response(const Eigen::MatrixXd& dw, const Eigen::MatrixXd& force,
                                              const RotorExcitation& rotors, double rate_hz, double clock_s,
                                              const std::vector<char>& use) {
  Axes axes(dw, force, rotors, rate_hz, use);
  if (!axes.enough()) return std::nullopt;
  std::vector<double> clocks;
  for (int shift = -axes.reach(); shift <= axes.reach(); ++shift)
    clocks.push_back(axes.of(0, shift, std::array{0.0}).front());
  const double at_once = clocks[static_cast<std::size_t>(axes.reach())];
  const int tolerated = static_cast<int>(std::lround(clock_s * rate_hz));
  std::vector<double> all;
  std::array<std::array<double, kTimes>, kLeads.size()> best;
  for (auto& some : best) some.fill(-1e300);
  for (int k = 0; k < kTimes; ++k)
    for (int shift = -tolerated; shift <= tolerated; ++shift) {
      const std::vector<double> here = axes.of(time_at(k), shift, kLeads);
      all.insert(all.end(), here.begin(), here.end());
      for (std::size_t l = 0; l < kLeads.size(); ++l)
        best[l][static_cast<std::size_t>(k)] = std::max(best[l][static_cast<std::size_t>(k)], here[l]);
    }
  // where noise of the speeds or disturbances prevail, whatever smooths them fits better
  if (axes.explained() < kLeastExplained) return std::nullopt;
  ThrustResponse out;
  out.log_factor = log_mean_exp(all) - std::max(log_mean_exp(clocks), at_once);
  if (!(out.log_factor > 0)) return std::nullopt;
  double most = -1e300;
  int at = 0;
  std::size_t lead = 0;
  for (std::size_t l = 0; l < kLeads.size(); ++l)
    for (int k = 1; k + 1 < kTimes; ++k)  // not at the edge of the search
      if (const double here = best[l][static_cast<std::size_t>(k)]; here > most)
        most = here, at = k, lead = l;
  const auto k = static_cast<std::size_t>(at);
  const auto& row = best[lead];
  const double bend = -(row[k - 1] - 2 * row[k] + row[k + 1]);
  if (!(bend > 0) || row[k - 1] > row[k] || row[k + 1] > row[k]) return std::nullopt;
  const double step = std::log(time_at(1) / time_at(0));
  out.lead = kLeads[lead];
  out.time = time_at(at) * std::exp(0.5 * (row[k + 1] - row[k - 1]) / bend * step);
  out.time_se = out.time * step / std::sqrt(bend);
  return out;
}

Eigen::MatrixXd responding(const Eigen::MatrixXd& speed, const ThrustResponse& response, double rate_hz) {
  const Eigen::MatrixXd now = speed.cwiseProduct(speed.cwiseAbs());
  const Eigen::MatrixXd then = now + response.lead * (now - lagged(now, response.time, rate_hz));
  return then.array().abs().sqrt() * then.array().sign();
}

}  // namespace omniflight::diagnosis

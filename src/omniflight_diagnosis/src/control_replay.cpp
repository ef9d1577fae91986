#include "control_replay.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace omniflight::diagnosis {

void add_control(const recording::Recording& r, const ToldController& told, Diagnosis& d) {
  const recording::Signal *asked = r.find("qddr"), *ref_p = r.find("ref_position"),
                          *ref_v = r.find("ref_velocity"), *ref_a = r.find("ref_acceleration");
  const recording::Signal *p = r.find("position"), *v = r.find("velocity"), *integral = r.find("integral");
  if (!asked || asked->width() != 6 || !ref_p || !p || asked->size() < 200) return;
  const std::vector<double>& t = asked->t_s;
  const auto at = [&](const recording::Signal* s, Eigen::Index width) -> Eigen::MatrixXd {
    if (!s || s->width() < width) return Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(t.size()), width);
    return recording::resample(*s, t, 0.2).leftCols(width);
  };
  const Eigen::MatrixXd e = at(ref_p, 3) - at(p, 3);
  const Eigen::MatrixXd ev = v && ref_v ? Eigen::MatrixXd(at(ref_v, 3) - at(v, 3)) : at(nullptr, 3);
  const Eigen::MatrixXd ff = at(ref_a, 3), sum = at(integral, 3);
  Finding f;
  static constexpr const char* kAxis[] = {"x", "y", "z"};
  std::string words;
  double off = 0;
  for (Eigen::Index c = 0; c < 3; ++c) {
    std::vector<Eigen::Index> good;
    for (Eigen::Index i = 0; i < e.rows(); ++i)
      if (std::isfinite(e(i, c) + ev(i, c) + ff(i, c) + sum(i, c))) good.push_back(i);
    const auto n = static_cast<Eigen::Index>(good.size());
    if (n < 200) continue;
    Eigen::MatrixXd X(n, 4);
    Eigen::VectorXd y(n), replayed(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Eigen::Index i = good[static_cast<std::size_t>(k)];
      X.row(k) << e(i, c), ev(i, c), sum(i, c), 1.0;
      y[k] = asked->values(i, c) - ff(i, c);
      replayed[k] = told.kp[c] * e(i, c) + told.kv[c] * ev(i, c) + told.ki[c] * sum(i, c);
    }
    Eigen::MatrixXd H = X.transpose() * X;
    for (Eigen::Index k = 0; k < 4; ++k)
      if (H(k, k) < 1e-12) H(k, k) = 1;  // not logged
    const Eigen::VectorXd gains = H.ldlt().solve(X.transpose() * y);
    const Eigen::VectorXd rest = y - X * gains;
    const double s2 = rest.squaredNorm() / static_cast<double>(n);
    // neighbouring samples are alike: a standard error for independent ones would be too small
    const Eigen::MatrixXd cov = 25 * s2 * H.ldlt().solve(Eigen::MatrixXd::Identity(4, 4));
    const double told_gain[] = {told.kp[c], told.kv[c], told.ki[c]};
    static constexpr const char* kName[] = {"kp_", "kv_", "ki_"};
    static constexpr const char* kUnit[] = {"1/s2", "1/s", "1/s3"};
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double se = std::sqrt(std::max(0.0, cov(k, k))), difference = gains[k] - told_gain[k];
      if (X.col(k).squaredNorm() < 1e-10 ||
          std::abs(difference) < std::max(4 * se, 0.1 * std::abs(told_gain[k])) ||
          std::abs(difference) < 1e-6)
        continue;
      const std::string name = std::string(kName[k]) + kAxis[c];
      f.parameters.push_back({name, name, kUnit[k], gains[k], gains[k] - 1.96 * se, gains[k] + 1.96 * se});
      char text[120];
      std::snprintf(text, sizeof text, "%s%s is %.3g, told %.3g", words.empty() ? "" : "; ", name.c_str(),
                    gains[k], told_gain[k]);
      words += text;
    }
    off = std::max(off, std::sqrt((y - replayed).squaredNorm() / static_cast<double>(n)));
    if (!f.parameters.empty() && (f.channels.empty() || f.channels.back() != std::string("qddr_") + kAxis[c]))
      f.channels.push_back(std::string("qddr_") + kAxis[c]);
  }
  if (f.parameters.empty()) return;
  f.effect = "controller_mismatch";
  f.probability = 0.99;
  f.stage = physics::Stage::control;
  f.sentence = "The controller asks for something else than its told gains do: " + words + ".";
  f.equation = "qddr = ref_acceleration + kp e + kv de + ki integral(e)";
  d.findings.push_back(f);
  Mismatch m;
  m.stage = physics::Stage::control;
  m.channel = f.channels.front();
  m.frame = "world";
  m.unit = "m/s2";
  m.p_value = 1e-6;
  m.rms = off;
  m.where = words;
  d.mismatch.push_back(m);
}

}  // namespace omniflight::diagnosis

#include "allocation_check.hpp"

#include <cmath>

#include "../numerics/text.hpp"

namespace omniflight::diagnosis {

std::vector<Mismatch> locate_allocation(const recording::Recording& recording) {
  constexpr double kBlock = 0.5;  // s, windows closer than this are joined; chosen
  std::vector<Mismatch> out;
  const recording::Signal* desired = recording.find("qddr");
  const recording::Signal* allocated = recording.find("qdd");
  if (!desired || !allocated || desired->width() != 6 || allocated->width() != 6) return out;
  // the result may be logged one period later than the request: take the nearer of both samples
  const double period = desired->median_period_s();
  std::vector<double> later = desired->t_s;
  for (double& t : later) t += period;
  const Eigen::MatrixXd now = recording::resample(*allocated, desired->t_s, 0.1),
                        next = recording::resample(*allocated, later, 0.1);
  static constexpr const char* names[] = {"ax", "ay", "az", "dwx", "dwy", "dwz"};
  for (Eigen::Index c = 0; c < 6; ++c) {
    Eigen::VectorXd miss(now.rows());
    double difference = 0, size = 0;
    int count = 0;
    for (Eigen::Index i = 0; i < now.rows(); ++i) {
      const double asked = desired->values(i, c), a = now(i, c) - asked, b = next(i, c) - asked;
      miss[i] = std::abs(a) <= std::abs(b) || !std::isfinite(b) ? a : b;
      if (!std::isfinite(miss[i])) continue;
      difference += miss[i] * miss[i];
      size += asked * asked;
      ++count;
    }
    if (count < 50) continue;
    const double off = std::sqrt(difference / count), limit = 0.05 + 0.1 * std::sqrt(size / count);
    if (off < limit) continue;
    Mismatch m;
    m.stage = physics::Stage::allocation;
    m.channel = names[c];
    m.frame = c < 3 ? "world" : "body";
    m.unit = c < 3 ? "m/s2" : "rad/s2";
    int missed = 0;
    for (Eigen::Index i = 0; i < miss.size(); ++i) {
      if (!(std::abs(miss[i]) > limit)) continue;
      ++missed;
      const double t = desired->t_s[static_cast<std::size_t>(i)];
      if (!m.windows_s.empty() && t - m.windows_s.back().second < kBlock)
        m.windows_s.back().second = t;
      else
        m.windows_s.emplace_back(t, t);
    }
    m.where = format(
        "what the allocator could not give of what the controller asked, by more than %.2g %s for %.0f %% of "
        "the time; both are computed, so that this is a comparison without noise and its p-value is 0 by "
        "definition",
        limit, m.unit.c_str(), 100.0 * missed / count);
    m.p_value = 0;
    m.rms = off;
    out.push_back(std::move(m));
  }
  return out;
}

}  // namespace omniflight::diagnosis

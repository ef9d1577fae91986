#include "improvement.hpp"

#include <cmath>
#include <filesystem>

#include "../numerics/statistics.hpp"
#include "../numerics/text.hpp"
#include "../regression/channels.hpp"

namespace omniflight::diagnosis {
Flight part_of(const Flight& f, double from_s, double to_s, bool inside) {
  Flight out = f;
  out.segments.clear();
  const int settle = static_cast<int>(0.5 * f.rate_hz);
  for (const Segment& s : f.segments) {
    Segment open{-1, -1};
    for (int i = s.begin; i <= s.end; ++i) {
      const double t = i < s.end ? f.t[static_cast<std::size_t>(i)] : 0;
      const bool in = i < s.end && ((t >= from_s && t < to_s) == inside);
      if (in && open.begin < 0) open.begin = i;
      if (!in && open.begin >= 0) {
        if (i - open.begin > settle) out.segments.push_back({open.begin, i});
        open.begin = -1;
      }
    }
  }
  return out;
}

std::optional<Third> third_of(const Flight& flight, int k, double least_block_s, double least_rest_s) {
  const double from = flight.t.front(), span = flight.t.back() - from;
  const double a = from + span * k / kThirds, b = from + span * (k + 1) / kThirds;
  Third out{"", part_of(flight, a, b, true), part_of(flight, a, b, false)};
  if (out.rest.usable() < least_rest_s * flight.rate_hz ||
      out.block.usable() < least_block_s * flight.rate_hz)
    return {};
  out.name = format("%s [%.1f s to %.1f s, not fitted]",
                    std::filesystem::path(flight.file).filename().c_str(), a, b);
  return out;
}

Vec6 measured_wrench(const physics::Situation& s) {
  const Vec3& w = s.body.w_WB_B;
  Vec6 out;
  out << s.mass * (s.a_WB_B - s.g_B), s.inertia * s.dw_WB_B + w.cross(s.inertia * w);
  return out;
}

std::vector<ChannelFit> channel_fits(const std::string& name, const Eigen::VectorXd& measured,
                                     const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                                     int channels, double mass) {
  const Eigen::Index n = measured.size() / 6;
  const auto explained = [&](const Eigen::VectorXd& left, int c) {
    const auto m = measured.segment(c * n, n).array();
    const auto l = left.segment(c * n, n).array();
    const double all = (m - m.mean()).square().sum();
    return all > 0 ? 1 - (l - l.mean()).square().sum() / all : std::nan("");
  };
  std::vector<ChannelFit> out;
  for (int c = 0; c < channels; ++c)
    out.push_back({name, kChannels[static_cast<std::size_t>(c)], channel_unit(c),
                   rms(before.segment(c * n, n)), rms(after.segment(c * n, n)), explained(before, c),
                   explained(after, c)});
  static constexpr const char* kAcceleration[] = {"ax", "ay", "az"};
  for (int c = 0; c < 3; ++c)
    out.push_back({name, kAcceleration[c], "m/s2", rms(before.segment(c * n, n)) / mass,
                   rms(after.segment(c * n, n)) / mass, explained(before, c), explained(after, c)});
  return out;
}

std::map<std::string, double> tracking_rms_of(const Flight& flight) {
  std::map<std::string, double> out;
  if (flight.tracking_error.rows() == 0) return out;
  static constexpr const char* kAxis[] = {"px", "py", "pz"};
  for (int c = 0; c < 3; ++c) {
    double sum = 0;
    int count = 0;
    for (const Segment& s : flight.segments)
      for (int i = s.begin; i < s.end; ++i)
        if (std::isfinite(flight.tracking_error(i, c))) {
          sum += std::pow(flight.tracking_error(i, c), 2);
          ++count;
        }
    if (count > 0) out[kAxis[c]] = std::sqrt(sum / count);
  }
  return out;
}

}  // namespace omniflight::diagnosis

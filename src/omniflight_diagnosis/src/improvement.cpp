#include "improvement.hpp"

#include <cmath>
#include <filesystem>

#include "statistics.hpp"
#include "text.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;

/// RMS a channel and share explained, without and with effects: body wrench, specific force [m/s^2].
std::vector<ChannelFit> compare(const Flight& flight, const vehicle::Vehicle& vehicle, const Options& o,
                                const std::vector<ActiveEffect>& effects, const std::string& name) {
  const Flight* one[] = {&flight};
  const Problem problem(one, vehicle, o);
  const int n = problem.samples();
  if (n == 0) return {};
  std::vector<ActiveEffect> wrench;
  for (const ActiveEffect& e : effects)
    if (e.effect->can_replay()) wrench.push_back(e);
  Eigen::VectorXd after;
  problem.predict(wrench, Eigen::VectorXd::Zero(problem.offset_sigma().size()), after, nullptr);
  Eigen::VectorXd before = problem.residual();
  if (problem.forces_only()) {  // the scale of a modelled thrust comes from every flight anew, with any model
    const auto rotors = problem.offsets().col(0);
    for (Eigen::VectorXd* r : {&before, &after}) *r -= rotors.dot(*r) / rotors.squaredNorm() * rotors;
  }
  Eigen::VectorXd measured(6 * n);
  for (int i = 0; i < n; ++i) {
    const Vec6 now = measured_wrench(problem.situation(i));
    for (int c = 0; c < 6; ++c) measured[c * n + i] = now[c];
  }
  return channel_fits(name, measured, before, after, 6, vehicle.mass);
}

}  // namespace

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

std::vector<ChannelFit> on_fitted(const Problem& problem, const Eigen::VectorXd& rest) {
  std::vector<ChannelFit> out;
  const int n = problem.samples();
  for (int c = 0; c < 6; ++c)
    out.push_back({"", kChannels[static_cast<std::size_t>(c)], channel_unit(c),
                   rms(problem.residual().segment(c * n, n)), rms(rest.segment(c * n, n))});
  return out;
}

std::vector<ChannelFit> on_unseen(const std::vector<Flight>& unseen, const vehicle::Vehicle& vehicle,
                                  const std::vector<ActiveEffect>& effects, const Options& o) {
  std::vector<ChannelFit> out;
  for (const Flight& f : unseen)
    for (ChannelFit& c : compare(f, vehicle, o, effects, f.file)) out.push_back(std::move(c));
  return out;
}

std::vector<ChannelFit> on_unseen_thirds(const Flight& flight, const vehicle::Vehicle& vehicle,
                                         const std::vector<ActiveEffect>& effects, const Options& o) {
  std::vector<ChannelFit> out;
  for (int k = 0; k < kThirds; ++k) {
    const auto third = third_of(flight, k, 1, 2);
    if (!third) continue;
    const Flight* one[] = {&third->rest};
    const Problem without_block(one, vehicle, o);
    const Fit refitted = settle(without_block, fit_effects(without_block, effects, o), o);
    for (ChannelFit& c : compare(third->block, vehicle, o, refitted.effects, third->name))
      out.push_back(std::move(c));
  }
  return out;
}

Series series_of(const Flight& flight, const vehicle::Vehicle& vehicle, const Options& o,
                 const std::vector<ActiveEffect>& effects, const Eigen::VectorXd& offsets) {
  const Flight* one[] = {&flight};
  const Problem problem(one, vehicle, o);
  Eigen::VectorXd after;
  problem.predict(effects, offsets, after, nullptr);
  const int n = problem.samples();
  Series s;
  s.file = flight.file;
  for (const char* c : kChannels) s.channels.emplace_back(c);
  s.channels.emplace_back("Fz_world");
  s.before.resize(7);
  s.after.resize(7);
  for (int i = 0; i < n; ++i) {
    const physics::Situation& x = problem.situation(i);
    s.t_s.push_back(x.t);
    s.height_m.push_back(x.body.p_WB.z());
    Vec3 up_before, up_after;
    for (int c = 0; c < 6; ++c) {
      s.before[static_cast<std::size_t>(c)].push_back(problem.residual()[c * n + i]);
      s.after[static_cast<std::size_t>(c)].push_back(after[c * n + i]);
      if (c < 3) up_before[c] = problem.residual()[c * n + i], up_after[c] = after[c * n + i];
    }
    s.before[6].push_back(x.R_WB.row(2).dot(up_before));
    s.after[6].push_back(x.R_WB.row(2).dot(up_after));
  }
  return s;
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

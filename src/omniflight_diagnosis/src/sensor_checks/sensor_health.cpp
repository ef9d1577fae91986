#include "sensor_health.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "../conditioning/repeats.hpp"
#include "../conditioning/sensor_noise.hpp"
#include "../numerics/statistics.hpp"
#include "../numerics/text.hpp"
#include "findings.hpp"
#include "omniflight_physics/effect_ids.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Recording;
using recording::Signal;

constexpr double kStillEnough = 5.0;  // s at rest before a reading is judged as an error; chosen
constexpr const char* kJudged[] = {"acc",      "gyro",         "position",     "attitude",
                                   "velocity", "est_position", "est_attitude", "est_velocity"};

std::vector<Window> gaps_of(const Signal& s) {
  std::vector<Window> out;
  const double longest = std::max(0.08, 3 * s.median_period_s());
  for (std::size_t i = 1; i < s.t_s.size(); ++i)
    if (s.t_s[i] - s.t_s[i - 1] > longest) out.push_back({s.t_s[i - 1], s.t_s[i], "gap in " + s.name});
  return out;
}

std::vector<Window> frozen_of(const Recording& r, const Signal& s) {
  std::vector<Window> out;
  for (const auto& held : frozen(s, driven(r, s)))
    out.push_back({s.t_s[static_cast<std::size_t>(held.begin)], s.t_s[static_cast<std::size_t>(held.end - 1)],
                   s.name + " is frozen"});
  return out;
}

double seconds(const std::vector<Window>& windows) {
  double sum = 0;
  for (const Window& w : windows) sum += w.to_s - w.from_s;
  return sum;
}

/// Means of accelerometer and gyro over seconds at rest.
struct Still {
  std::vector<Vec3> acc, gyro;
  double seconds() const { return static_cast<double>(gyro.size()); }
};

struct Mean {
  Vec3 value = Vec3::Zero(), se = Vec3::Constant(1e9);
};
Mean mean_of(const std::vector<Vec3>& x) {
  Mean out;
  const auto n = static_cast<double>(x.size());
  if (n < 2) return out;
  for (const Vec3& v : x) out.value += v / n;
  Vec3 squares = Vec3::Zero();
  for (const Vec3& v : x) squares += (v - out.value).cwiseAbs2();
  out.se = (squares / (n * (n - 1))).cwiseSqrt();
  return out;
}

/// Mean over [from, to) if the scatter is that of white noise, and below `most`.
std::optional<Vec3> quiet_mean(const Signal& s, double from, double to, double most) {
  const auto a = std::lower_bound(s.t_s.begin(), s.t_s.end(), from) - s.t_s.begin(),
             b = std::lower_bound(s.t_s.begin(), s.t_s.end(), to) - s.t_s.begin();
  if (b - a < 20) return std::nullopt;
  const Eigen::MatrixXd x = s.values.middleRows(a, b - a);
  const Vec3 mean = x.colwise().mean().transpose();
  const Vec3 scatter = ((x.rowwise() - mean.transpose()).colwise().squaredNorm() / static_cast<double>(b - a))
                           .cwiseSqrt()
                           .transpose();
  if (scatter.maxCoeff() > std::min(most, 1.4 * white_noise(s, a, b) + 1e-9)) return std::nullopt;
  return mean;
}

/// Seconds at rest: accelerometer and gyro show white noise only, and the direction of the specific force
/// does not change between adjacent seconds, which excludes steady rotation. Limits chosen.
Still still_of(const Recording& r) {
  constexpr double kAcc = 0.4, kGyro = 0.06, kTurns = 0.3;  // m/s^2, rad/s, rad/s
  Still out;
  const Signal *acc = r.find("acc"), *gyro = r.find("gyro");
  if (!acc || !gyro || acc->width() != 3 || gyro->width() != 3) return out;
  const double last = std::min(acc->t_s.back(), gyro->t_s.back());
  Vec3 before = Vec3::Zero();
  bool was_calm = false;
  for (double t = std::max(acc->t_s.front(), gyro->t_s.front()); t + 1 <= last; t += 1) {
    const auto f = quiet_mean(*acc, t, t + 1, kAcc), w = quiet_mean(*gyro, t, t + 1, kGyro);
    const bool calm = f && w && w->norm() < kTurns;
    if (calm && was_calm && (f->normalized() - before).norm() < 0.5 * w->norm() + 0.002) {
      out.acc.push_back(*f);
      out.gyro.push_back(*w);
    }
    was_calm = calm;
    if (calm) before = f->normalized();
  }
  return out;
}

void add_tracking(const Recording& r, std::vector<SensorFact>& out) {
  const Signal *p = r.find("position"), *ref = r.find("ref_position");
  if (!p || !ref || p->width() != 3 || ref->width() != 3) return;
  const Eigen::MatrixXd error = p->values - recording::resample(*ref, p->t_s);
  for (int c = 0; c < 3; ++c) {
    double sum = 0, squares = 0;
    int n = 0;
    for (Eigen::Index i = 0; i < error.rows(); ++i)
      if (std::isfinite(error(i, c))) sum += error(i, c), squares += error(i, c) * error(i, c), ++n;
    if (n == 0) continue;
    const std::string axis(1, "xyz"[c]);
    out.push_back({"position", "tracking error " + axis + ", RMS", "m", std::sqrt(squares / n)});
    out.push_back({"position", "tracking error " + axis + ", mean", "m", sum / n});
  }
}

}  // namespace

std::vector<SensorFact> sensor_facts(const Recording& r) {
  std::vector<SensorFact> out;
  for (const char* name : kJudged) {
    const Signal* s = r.find(name);
    if (!s || s->size() < 20) continue;
    const double span = s->t_s.back() - s->t_s.front();
    const double turn =
        recording::is_attitude(s->name) ? 2 : 1;  // quaternion components change by half the angle
    out.push_back(
        {s->name, "white noise, RMS", turn > 1 ? "rad" : s->unit, turn * white_noise(*s, 0, s->size())});
    if (!(span > 0)) continue;
    out.push_back({s->name, "share of time in gaps", "1", seconds(gaps_of(*s)) / span});
    out.push_back({s->name, "share of time frozen", "1", seconds(frozen_of(r, *s)) / span});
  }
  if (const Signal* acc = r.find("acc")) {
    std::vector<double> size;
    for (Eigen::Index i = 0; i < acc->size(); ++i) size.push_back(acc->values.row(i).norm());
    out.push_back({"acc", "median magnitude", "m/s2", median(size)});
  }
  if (const Still still = still_of(r); still.seconds() >= 2) {
    out.push_back({"gyro", "time at rest", "s", still.seconds()});
    out.push_back({"acc", "magnitude at rest", "m/s2", mean_of(still.acc).value.norm()});
    for (int c = 0; c < 3; ++c)
      out.push_back({"gyro", std::string("at rest, ") + "xyz"[c], "rad/s", mean_of(still.gyro).value[c]});
  }
  add_tracking(r, out);
  return out;
}

void add_sensor_health(const Recording& r, const Options& o, Diagnosis& d, std::vector<Window>& windows) {
  for (const char* name : kJudged) {
    const Signal* s = r.find(name);
    if (!s || s->size() < 20) continue;
    for (Window& w : gaps_of(*s)) windows.push_back(std::move(w));
    const std::vector<Window> held = frozen_of(r, *s);
    const double share = seconds(held) / std::max(1e-9, s->t_s.back() - s->t_s.front());
    if (held.empty() || share < 0.005) continue;
    const bool inertial = s->name == "acc" || s->name == "gyro";
    add_sensor(d, physics::effect_id::stale_samples, s->name, s->unit.c_str(),
               format("'%s' holds one value and then jumps, %zu times, for %.1f %% of the time: old samples "
                      "were logged again.",
                      name, held.size(), 100 * share),
               {{inertial ? "imu" : "mocap", inertial ? "P_i" : "P_m", "1", share, share, share}}, share, 0);
    for (const Window& w : held) d.mismatch.back().windows_s.emplace_back(w.from_s, w.to_s);
    d.mismatch.back().where = format("%.1f %% of the time", 100 * share);
    windows.insert(windows.end(), held.begin(), held.end());
  }
  const Still still = still_of(r);
  if (still.seconds() < kStillEnough) return;
  const Mean gyro = mean_of(still.gyro), acc = mean_of(still.acc);
  Eigen::Index c = 0;
  const double rate = gyro.value.cwiseAbs().maxCoeff(&c);
  if (rate > std::max(3 * o.tolerance.gyro_bias, 5 * gyro.se[c])) {
    std::vector<ParameterValue> bias;
    for (int k = 0; k < 3; ++k) {
      const std::string axis(1, "xyz"[k]);
      bias.push_back({"bias_" + axis, "b_" + axis, "rad/s", gyro.value[k], gyro.value[k] - 1.96 * gyro.se[k],
                      gyro.value[k] + 1.96 * gyro.se[k]});
    }
    add_sensor(
        d, physics::effect_id::gyro_error, "gyro", "rad/s",
        format("The gyro reads %+.3g, %+.3g, %+.3g rad/s through %.0f s in which nothing moves: a bias.",
               gyro.value[0], gyro.value[1], gyro.value[2], still.seconds()),
        std::move(bias), rate, gyro.se[c]);
  }
  const double off = acc.value.norm() - o.environment.gravity, se = acc.se.maxCoeff();
  if (std::abs(off) > std::max(3 * o.tolerance.accelerometer_vertical, 5 * se))
    add_sensor(
        d, physics::effect_id::accelerometer_error, "acc", "m/s2",
        format("The accelerometer reads %.3f m/s2 through %.0f s in which nothing moves, gravity is %.3f: "
               "a bias or a scale, which one attitude cannot tell apart.",
               acc.value.norm(), still.seconds(), o.environment.gravity),
        {}, std::abs(off), se);
}

}  // namespace omniflight::diagnosis

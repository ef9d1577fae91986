#include "bursts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "statistics.hpp"

namespace omniflight::diagnosis {
namespace {

double median_of(std::vector<double> v) {
  if (v.empty()) return 0;
  std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
  return v[v.size() / 2];
}

}  // namespace

Eigen::MatrixXd slow_world_force(const Problem& p, const Eigen::VectorXd& r) {
  const int n = p.samples();
  Eigen::MatrixXd w(n, 3), out(n, 3);
  for (int i = 0; i < n; ++i)
    w.row(i) = (p.situation(i).R_WB * Vec3(r[i], r[n + i], r[2 * n + i])).transpose();
  const double dt = n > 1 ? std::max(1e-3, p.situation(1).t - p.situation(0).t) : 0.025;
  const int half = std::max(1, static_cast<int>(0.25 / dt));
  for (const Run& run : p.runs())
    for (int i = run.begin; i < run.end; ++i) {
      const int a = std::max(run.begin, i - half), b = std::min(run.end, i + half + 1);
      out.row(i) = w.middleRows(a, b - a).colwise().mean();
    }
  return out;
}

bool is_low(const physics::Situation& s, double height) {
  const double radius = s.rotor_count > 0 ? s.rotors[0].radius : 0.0;
  return height - s.environment.floor_z < 6 * radius;
}

std::vector<Burst> find_bursts(const Problem& p, const Eigen::VectorXd& residual) {
  std::vector<Burst> out;
  const int n = p.samples();
  if (n < 100) return out;
  const Eigen::MatrixXd f = slow_world_force(p, residual);
  Vec3 centre, spread;
  for (int c = 0; c < 3; ++c) {
    std::vector<double> x(f.col(c).begin(), f.col(c).end());
    centre[c] = median_of(x);
    for (double& v : x) v = std::abs(v - centre[c]);
    spread[c] = 1.4826 * median_of(std::move(x));
  }
  std::vector<char> high(static_cast<std::size_t>(n), 0);
  for (int i = 0; i < n; ++i)
    for (int c = 0; c < 3; ++c)
      if (std::abs(f(i, c) - centre[c]) > std::max(6 * spread[c], 0.03 * p.scale(0)))
        high[static_cast<std::size_t>(i)] = 1;
  int inside = 0;
  for (const Run& run : p.runs())
    for (int i = run.begin; i < run.end; ++i) {
      if (!high[static_cast<std::size_t>(i)]) continue;
      int j = i, last = i;  // a short dip does not end it
      while (j < run.end && p.situation(j).t - p.situation(last).t < 0.3) {
        if (high[static_cast<std::size_t>(j)]) last = j;
        ++j;
      }
      const double length = p.situation(last).t - p.situation(i).t;
      if (length > 0.25) {
        Burst b{run.flight, p.situation(i).t, p.situation(last).t, Vec3::Zero(), Vec3::Zero()};
        for (int k = i; k <= last; ++k) {
          b.place += p.situation(k).body.p_WB / (last - i + 1);
          const Vec3 here = f.row(k).transpose() - centre;
          if (here.norm() > b.force.norm()) b.force = here;
        }
        inside += last - i + 1;
        out.push_back(b);
      }
      i = last;
    }
  if (5 * inside > 2 * n) out.clear();
  return out;
}

double explained_in_bursts(const Problem& p, const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                           const std::vector<Burst>& bursts) {
  const Eigen::MatrixXd f0 = slow_world_force(p, before), f1 = slow_world_force(p, after);
  double was = 0, is = 0;
  for (const Run& run : p.runs())
    for (int i = run.begin; i < run.end; ++i) {
      const double t = p.situation(i).t;
      for (const Burst& b : bursts)
        if (b.flight == run.flight && t >= b.from_s && t <= b.to_s) {
          was += f0.row(i).squaredNorm();
          is += f1.row(i).squaredNorm();
          break;
        }
    }
  return was > 0 ? 1 - is / was : 1.0;
}

void add_bursts(const Problem& p, const Eigen::VectorXd& before, const Eigen::VectorXd& after, Diagnosis& d) {
  const std::vector<Burst> bursts = find_bursts(p, after);
  if (bursts.empty()) return;
  const Eigen::MatrixXd f0 = slow_world_force(p, before), f = slow_world_force(p, after);
  const int n = p.samples();
  for (int c = 0; c < 3; ++c) {
    double strongest = 0, inside = 0;
    Mismatch m;
    const Burst* most = nullptr;
    for (const Burst& b : bursts) {
      if (std::abs(b.force[c]) < 0.5 * b.force.norm()) continue;
      if (b.flight == 0) m.windows_s.emplace_back(b.from_s, b.to_s);
      if (std::abs(b.force[c]) > strongest) strongest = std::abs(b.force[c]), most = &b;
    }
    if (!most) continue;
    const double middle = f.col(c).mean();
    for (int i = 0; i < n; ++i) {
      const double t = p.situation(i).t;
      for (const Burst& b : bursts)
        if (t >= b.from_s && t <= b.to_s) {
          inside += std::pow(f(i, c) - middle, 2);
          break;
        }
    }
    const Eigen::VectorXd centred = (f.col(c).array() - middle).matrix();
    Unexplained u;
    u.channel = kChannels[static_cast<std::size_t>(c)];
    u.unit = "N";
    u.frame = "world";
    u.depends_on = {"time", "place"};
    u.parity = "none";
    u.share_of_residual = std::min(1.0, inside / std::max(1e-300, centred.squaredNorm()));
    const bool low = c == 2 && most->force[2] > 0 && is_low(p.situation(0), most->place.z());
    if (low) u.depends_on = {"height"};
    u.nearest = low ? "ground_effect: an upward force close to the floor"
                    : "an external force: wash of another vehicle, gust or contact";
    d.unexplained.push_back(u);
    char text[240];
    std::snprintf(
        text, sizeof text,
        "%s force of up to %.3g N in %d bursts, the strongest from %.1f s to %.1f s at (%.2f, %.2f, %.2f) m; "
        "not explained by the vehicle's own state",
        c == 2 ? (most->force[2] < 0 ? "downward" : "upward") : "sideward", strongest,
        static_cast<int>(bursts.size()), most->from_s, most->to_s, most->place.x(), most->place.y(),
        most->place.z());
    m.channel = u.channel;
    m.frame = "world";
    m.unit = "N";
    m.where = text;
    m.p_value = 1e-6;
    m.rms = rms(f0.col(c));
    m.noise_rms = std::sqrt(std::max(0.0, centred.squaredNorm() - inside) / n);
    d.mismatch.push_back(m);
  }
}

}  // namespace omniflight::diagnosis

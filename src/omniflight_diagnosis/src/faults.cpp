#include "faults.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "quantisation.hpp"

namespace omniflight::diagnosis {
namespace {

/// True where a column keeps exactly one value for longer than `hold_s`.
std::vector<char> stuck(const recording::Signal& s, Eigen::Index column, double hold_s) {
  const Eigen::Index n = s.size();
  std::vector<char> out(static_cast<std::size_t>(n), 0);
  for (Eigen::Index i = 0; i < n;) {
    Eigen::Index j = i;
    while (j < n && s.values(j, column) == s.values(i, column)) ++j;
    const double length = s.t_s[static_cast<std::size_t>(j - 1)] - s.t_s[static_cast<std::size_t>(i)];
    if (length > hold_s) std::fill(out.begin() + i, out.begin() + j, 1);
    i = j;
  }
  return out;
}

}  // namespace

std::vector<SensorFault> find_sensor_faults(const recording::Recording& recording) {
  std::vector<SensorFault> faults;
  if (const recording::Signal* speed = recording.find("rotor_speed"); speed && speed->width() >= 2) {
    std::vector<std::vector<char>> columns;
    for (Eigen::Index c = 0; c < speed->width(); ++c) columns.push_back(stuck(*speed, c, 0.2));
    for (std::size_t c = 0; c < columns.size(); ++c) {
      int bad = 0;  // stuck while at least half of the others move
      for (std::size_t i = 0; i < columns[c].size(); ++i) {
        if (!columns[c][i]) continue;
        std::size_t moving = 0;
        for (const auto& other : columns) moving += !other[i];
        bad += 2 * moving >= columns.size() - 1;
      }
      const double share = static_cast<double>(bad) / static_cast<double>(columns[c].size());
      if (share < 0.02) continue;
      const std::string name = "rotor" + std::to_string(c + 1) + "_speed";
      faults.push_back({"rotor_speed_sensor_fault", name,
                        "The speed of rotor " + std::to_string(c + 1) + " stands still for " +
                            std::to_string(static_cast<int>(std::lround(100 * share))) +
                            " % of the flight while the other rotors move: its sensor is stuck.",
                        share});
    }
  }
  // motors that run in steps stand still in between, and their sensors say so
  if (!faults.empty() && speed_step(recording)) faults.clear();
  if (const recording::Signal* vbat = recording.find("vbat"); vbat && vbat->size() > 50) {
    const double span = vbat->t_s.back() - vbat->t_s.front();
    if (span > 3.0 && vbat->values.maxCoeff() - vbat->values.minCoeff() < 1e-6)
      faults.push_back({"battery_sensor_fault", "vbat",
                        "The battery voltage never changes in " + std::to_string(static_cast<int>(span)) +
                            " s of flight: its sensor is frozen.",
                        1.0});
  }
  return faults;
}

std::vector<char> frozen_samples(const recording::Signal& rotor_speed, const std::string& channel,
                                 const std::vector<double>& t_s) {
  std::vector<char> out(t_s.size(), 0);
  const int rotor = channel.size() > 5 ? std::atoi(channel.c_str() + 5) - 1 : -1;
  if (rotor < 0 || rotor >= rotor_speed.width()) return out;
  const std::vector<char> bad = stuck(rotor_speed, rotor, 0.2);
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    const auto next = std::lower_bound(rotor_speed.t_s.begin(), rotor_speed.t_s.end(), t_s[i]);
    const auto k =
        std::min<std::ptrdiff_t>(next - rotor_speed.t_s.begin(), static_cast<std::ptrdiff_t>(bad.size()) - 1);
    out[i] = bad[static_cast<std::size_t>(k)];
  }
  return out;
}

}  // namespace omniflight::diagnosis

#include "collector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace omniflight::recording {
namespace {

/// Rows become unit quaternions. One that is a unit quaternion up to rounding stays as it is: to divide it
/// again would change its last bit with every export and import.
void normalize_attitudes(Eigen::MatrixXd& rows) {
  constexpr double kRounding = 1e-14;  // a few times the error of a normalised row's squared norm
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    if (std::abs(rows.row(i).squaredNorm() - 1) > kRounding) rows.row(i).normalize();
}

}  // namespace

void Collector::add(const std::string& signal, double t_s, const double* values, std::size_t width) {
  Samples& s = all_[signal];
  if (s.width == 0) s.width = width;
  if (width != s.width && width > 0 && ++s.misfits > s.t.size()) {  // the first ones were the odd ones
    s.refused += s.t.size();
    s.t.clear();
    s.values.clear();
    s.width = width;
    s.misfits = 0;
  }
  bool good = width > 0 && width == s.width && std::isfinite(t_s);
  for (std::size_t i = 0; good && i < width; ++i) good = std::isfinite(values[i]);
  if (good && is_attitude(signal)) {
    double norm = 0;
    for (std::size_t i = 0; i < width; ++i) norm += values[i] * values[i];
    good = width == 4 && norm > 0.25 && norm < 4.0;  // not a quaternion otherwise
  }
  if (!good) {
    ++s.refused;
    return;
  }
  s.t.push_back(t_s);
  s.values.insert(s.values.end(), values, values + width);
}

void Collector::describe(const std::string& signal, const std::string& unit, const std::string& source) {
  all_[signal].unit = unit;
  all_[signal].source = source;
}

std::size_t Collector::count(const std::string& signal) const {
  const auto found = all_.find(signal);
  return found == all_.end() ? 0 : found->second.t.size();
}

std::size_t Collector::refused(const std::string& signal) const {
  const auto found = all_.find(signal);
  return found == all_.end() ? 0 : found->second.refused;
}

void Collector::rename(const std::string& from, const std::string& to) {
  if (auto node = all_.extract(from)) {
    all_.erase(to);
    node.key() = to;
    all_.insert(std::move(node));
  }
}

void Collector::shift(const std::string& signal, double by_s) {
  const auto found = all_.find(signal);
  if (found == all_.end()) return;
  for (double& t : found->second.t) t += by_s;
}

void Collector::finish(Recording& recording) {
  double first = std::numeric_limits<double>::infinity(), last = -first;
  for (auto& [name, s] : all_) {
    if (s.refused > 0)
      recording.note(Note::Kind::ignored,
                     name + ": " + std::to_string(s.refused) +
                         " samples are not finite, have another width or are no "
                         "unit quaternion, and were left out",
                     s.refused);
    if (s.t.empty()) continue;
    std::vector<std::size_t> order(s.t.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::uint64_t back = 0;
    double furthest = 0;
    for (std::size_t i = 1; i < s.t.size(); ++i)
      if (s.t[i] < s.t[i - 1]) {
        ++back;
        furthest = std::max(furthest, s.t[i - 1] - s.t[i]);
      }
    // messages that overtake each other by a little are ordinary
    if (100 * back > s.t.size() || furthest > 0.5)
      recording.note(Note::Kind::damage,
                     name + ": time runs backwards " + std::to_string(back) + " times, by up to " +
                         std::to_string(furthest) + " s",
                     back);
    if (back > 0)
      std::stable_sort(order.begin(), order.end(), [&t = s.t](auto a, auto b) { return t[a] < t[b]; });
    Signal signal;
    signal.name = name;
    signal.unit = s.unit;
    signal.source = s.source;
    std::vector<std::size_t> kept;
    kept.reserve(order.size());
    for (const std::size_t i : order)
      if (kept.empty() || s.t[i] > s.t[kept.back()]) kept.push_back(i);
    if (kept.size() < order.size())
      recording.note(Note::Kind::ignored,
                     name + ": " + std::to_string(order.size() - kept.size()) +
                         " samples repeat a time and were left out",
                     order.size() - kept.size());
    signal.values.resize(static_cast<Eigen::Index>(kept.size()), static_cast<Eigen::Index>(s.width));
    signal.t_s.reserve(kept.size());
    for (std::size_t row = 0; row < kept.size(); ++row) {
      signal.t_s.push_back(s.t[kept[row]]);
      for (std::size_t c = 0; c < s.width; ++c)
        signal.values(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(c)) =
            s.values[kept[row] * s.width + c];
    }
    if (is_attitude(name)) normalize_attitudes(signal.values);
    first = std::min(first, signal.t_s.front());
    last = std::max(last, signal.t_s.back());
    recording.signals[name] = std::move(signal);
  }
  recording.duration_s = last >= first ? last - first : 0.0;
}

}  // namespace omniflight::recording

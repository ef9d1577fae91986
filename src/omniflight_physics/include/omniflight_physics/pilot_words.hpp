// How a pilot is told of an effect: "0.28 kg too heavy".
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace omniflight::physics {

/// Parameters of an effect that a flight has identified, by name, in SI units.
class KnownValues {
 public:
  explicit KnownValues(std::map<std::string, double> known) : known_(std::move(known)) {}

  /// Nothing where the flight does not identify it.
  std::optional<double> find(const std::string& name) const {
    const auto at = known_.find(name);
    return at == known_.end() ? std::nullopt : std::optional(at->second);
  }
  /// 0 where the flight does not identify it.
  double operator()(const std::string& name) const { return find(name).value_or(0.0); }
  const std::map<std::string, double>& all() const { return known_; }

 private:
  std::map<std::string, double> known_;
};

/// What an effect says of itself (EffectInfo::words).
struct PilotWords {
  std::vector<std::string> needs;  ///< parameters: without one of them, known and not 0, there are no words;
                                   ///< empty: there always are
  std::string (*say)(const KnownValues&) = nullptr;  ///< a clause; nullptr: there are no words
};

/// The words at these values; empty where there are none.
std::string say(const PilotWords& words, const KnownValues& values);

}  // namespace omniflight::physics

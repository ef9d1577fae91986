// What the same fits find where nothing is left out: the flight again in the simulator, disturbed as it was.
#pragma once

#include <memory>

#include "naming.hpp"

namespace omniflight::diagnosis {

class NullFlights {
 public:
  /// Flies Options::reflights times under noise drawn from the problem's noise model. Flights that cannot be
  /// flown or prepared are left out; empty() with fewer than four.
  NullFlights(const Problem& problem, const Flight& flight, const vehicle::Vehicle& vehicle,
              const Options& options);
  bool empty() const { return problems_.size() < 4; }

  /// How far each effect of a model stands out, in standard deviations: its whitened contribution, against
  /// those that the same set of effects takes on the null flights, seen along it.
  std::vector<double> standing_out(const Problem& problem, const Fit& model, const Options& options) const;

  /// The same for what a channel's residual still owes to state variables; see locate_unexplained.
  bool unexplained_stands_out(const Unexplained& found, const Options& options) const;

 private:
  std::vector<Flight> flights_;
  std::vector<std::unique_ptr<const Problem>> problems_;
};

}  // namespace omniflight::diagnosis

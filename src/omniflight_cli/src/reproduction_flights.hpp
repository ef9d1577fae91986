// The flights that figures of chapter 7 need, flown or kept, and their diagnosis.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "campaign_run.hpp"
#include "flight.hpp"
#include "omniflight_recording/recording.hpp"
#include "omniflight_reproduction/flights.hpp"

namespace omniflight::cli {

/// Until when work may begin. A budget of 0 s is none.
class WorkTime {
 public:
  explicit WorkTime(double budget_s);
  bool over() const;      ///< also after Ctrl-C
  double left_s() const;  ///< infinite without a budget

 private:
  double budget_s_;
  std::chrono::steady_clock::time_point begin_;
};

struct FlownFlights {
  std::map<std::string, recording::Recording> recordings;  ///< by name, what the figures read of them
  std::map<std::string, std::string> missing;              ///< by name: why it is not there
  std::vector<std::string> remarks;                        ///< flights that did not end as flown
};

/// Options of a flight whose folder is `folder`/NAME; writes its model and world beside it.
Result<FlightOptions> options_of(const reproduction::Flight& flight, const std::string& folder);

/// Those of `names` that are complete in `folder` and of the same inputs are kept; the others are flown by
/// the executor, first those in real time, and none is begun once the time is over. done(): how many are
/// there.
Result<FlownFlights> fly_all(const std::vector<std::string>& names, const std::string& folder,
                             jobs::Executor& executor, const WorkTime& time, const Common& common,
                             const std::function<void(std::size_t)>& done);
/// One of its jobs: a flight into the folder `out`. The exit code.
Result<int> fly_reproduction(const std::string& name, const std::string& out);

/// diagnosis.json over the flights through the boards, kept while their recordings are the same. In a process
/// of its own, ended at the latest after `most_s`.
Result<std::string> diagnose_flights(const std::vector<std::string>& names, const std::string& folder,
                                     double most_s);

}  // namespace omniflight::cli

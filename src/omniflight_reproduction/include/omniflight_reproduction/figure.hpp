// The figures and tables of the OmniMorph thesis, and how each is computed here.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "omniflight_recording/recording.hpp"
#include "omniflight_reproduction/finding.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::reproduction {

/// What the figures are computed from. Recordings come from whoever can fly; nothing here does.
struct Inputs {
  vehicle::Vehicle omnimorph;   ///< as shipped: 1.315 kg, 6.25 N
  vehicle::Vehicle omnicopter;  ///< as shipped; only its axes are used
  /// Recordings by the name of their Flight; those a figure asks for in `flights`.
  std::map<std::string, recording::Recording> flights;
  std::string
      diagnosis;  ///< text of diagnosis.json over the flights through the boards; empty: none was made
};

struct Figure {
  const char* id;     ///< "5.3", "A.8", "table 7.1"
  const char* title;  ///< what it shows
  bool assigned;      ///< the subject was put to this number here: only its number, not its caption, is known
  bool fast;          ///< below a second
  std::vector<std::string> flights;  ///< names of flights that it needs
  bool diagnosis;                    ///< needs the diagnosis of the flights
  Result<Finding> (*compute)(const Inputs& inputs);
};

/// All, in the order of the document.
const std::vector<Figure>& figures();
/// By id, letters of either case, with or without "figure"; nullptr: there is none.
const Figure* find_figure(const std::string& id);

}  // namespace omniflight::reproduction

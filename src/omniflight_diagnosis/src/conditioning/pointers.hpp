// Non-owning view of a vector of flights.
#pragma once

#include <vector>

#include "omniflight_diagnosis/flight.hpp"

namespace omniflight::diagnosis {

inline std::vector<const Flight*> pointers_to(const std::vector<Flight>& flights) {
  std::vector<const Flight*> out;
  for (const Flight& f : flights) out.push_back(&f);
  return out;
}

}  // namespace omniflight::diagnosis

// Identifiability of parameters, and marking of answers whose search did not end.
#include <algorithm>
#include <cmath>

#include "omniflight_diagnosis/diagnosis.hpp"

namespace omniflight::diagnosis {

bool identifiable(const std::string& effect, const ParameterValue& parameter) {
  const physics::Effect* const known = physics::find_effect(effect);
  if (!known) return true;
  const auto& all = known->info().parameters;
  const auto at =
      std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.name == parameter.name; });
  if (at == all.end()) return true;
  const double rounding = 1e-6 * (at->upper - at->lower);
  return !(parameter.low <= at->lower + rounding && parameter.high >= at->upper - rounding);
}

void mark_unfinished(Diagnosis& d) {
  d.verdict = Verdict::unfinished;
  for (Finding& f : d.findings) f.probability = std::nan("");
  d.sets.clear();
  d.probability_of_nothing = std::nan("");
  if (d.left_out.empty()) d.left_out.emplace_back("the search for left-out physics");
}

}  // namespace omniflight::diagnosis

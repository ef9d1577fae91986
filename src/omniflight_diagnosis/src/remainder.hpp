// What the library leaves over, and the names that it makes too weak.
#pragma once

#include "dictionary.hpp"
#include "naming.hpp"

namespace omniflight::diagnosis {

/// Terms that still predict what the named effects leave; crumbs of a law that is only nearly right are not
/// among them.
std::vector<Term> terms_beside(const Problem& problem, const Naming& naming, const Options& options);

/// The member that explains less than 70 % of what can be predicted along its own axes, the least first; -1
/// where every name holds. What it imitates is unknown physics, and must not go by its name.
int weakest_name(const Problem& problem, const Naming& naming, const std::vector<Term>& terms);

}  // namespace omniflight::diagnosis

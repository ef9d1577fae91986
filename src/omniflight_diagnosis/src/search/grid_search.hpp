// First tier of the search: hypotheses at the points of their shape grids are linear, so that the evidence of
// any set follows from one matrix of inner products.
#pragma once

#include "posterior.hpp"

namespace omniflight::diagnosis {

/// Starting values of sets, the most promising first: the best of every size, found by a beam search that
/// adds members one by one. The empty set is not among them.
std::vector<std::vector<SetMember>> promising_sets(const Evidence& evidence, const SearchLimits& limits);

}  // namespace omniflight::diagnosis

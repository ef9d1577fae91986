// First tier of the search: hypotheses at the points of their shape grids are linear, so that the evidence of
// any set follows from one matrix of inner products.
#pragma once

#include "posterior.hpp"

namespace omniflight::diagnosis {

/// A hypothesis that may join a set.
struct Candidate {
  double gain = 0;  ///< ln evidence plus ln prior that it would add, at a point of its grid
  SetMember member;
};

class GridSearch {
 public:
  GridSearch(const Evidence& evidence, const SearchLimits& limits);
  ~GridSearch();

  /// Of what sets consist: patterns are flexible, and where they are offered the beam may never see the
  /// laws that do the same with fewer numbers.
  enum class Offered { everything, laws };
  /// Starting values of sets, the most promising first: the best of every size, found by a beam search that
  /// adds members one by one. The empty set is not among them.
  std::vector<std::vector<SetMember>> promising_sets(Offered offered = Offered::everything);

  /// Whether a gain counts in the noise of the evidence, or about as it is in the noise that the set would
  /// leave itself.
  enum class Noise { given, own };
  /// What would join a fitted set, the most promising first. A law of several shapes shows only a part of its
  /// gain at a point of its grid, a pattern all of it: they do not compare.
  struct Additions {
    std::vector<Candidate> laws, patterns;
  };
  Additions additions(const SetFit& fit, Noise noise = Noise::given) const;
  /// A law alone, at the points of its grid that promise most.
  std::vector<SetMember> points_of(int hypothesis, std::size_t most) const;
  /// From now on additions() gives this member for its hypothesis, in place of one at a point of its grid.
  void begin_at(SetMember member);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace omniflight::diagnosis

// Small statistics of a score: how sure a rate is, and whether it could be luck.
#pragma once

#include <vector>

namespace omniflight::proof {

struct Interval {
  double low = 0, high = 1;
};
/// 95 % interval of a rate, k of n (Wilson 1927); [0, 1] when n is 0.
Interval wilson(int k, int n);
/// Middle of the values (mean of the two middle ones); NaN when there is none.
double median(std::vector<double> values);

}  // namespace omniflight::proof

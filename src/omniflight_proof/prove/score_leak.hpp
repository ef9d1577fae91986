// Does anything but the data give a case away? A classifier tries to guess the truth from names, sizes,
// times, order and everything else a file system shows, and from the telling file beside a recording.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::proof {

/// What can be seen of a case without reading its samples. All cases have the same features.
struct Outside {
  std::string id;
  std::vector<double> features;
};
/// Name of a feature by its place.
std::string outside_feature(std::size_t place);
/// Of one case folder: number in the name, place in the listing, files, sizes, times of every kind (relative
/// to the first case), inode order, owner, mode, gzip header, the numbers of told.yaml. Errors: cases whose
/// told.yaml have not the same keys.
Result<std::vector<Outside>> look_from_outside(const std::filesystem::path& cases);

struct LeakResult {
  double accuracy = 0;  ///< of guesses, each case left out once
  double chance = 0;    ///< the same with shuffled labels, mean
  double p_value = 1;   ///< share of shuffles that guess as well or better
  std::string feature;  ///< the most telling one
};
/// Nearest neighbours in one feature at a time, and in all together; the best of them counts, in the shuffles
/// too. labels[i] belongs to cases[i]. Deterministic.
/// What still passes for chance.
inline constexpr double kLeakMust = 0.01;
LeakResult guess(const std::vector<Outside>& cases, const std::vector<std::string>& labels,
                 int shuffles = 200);

}  // namespace omniflight::proof

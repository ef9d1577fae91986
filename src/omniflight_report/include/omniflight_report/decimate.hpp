// Thinning of samples for a screen.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace omniflight::report {

/// Which samples to keep, ascending, so that a line through them looks like the line through all: of every
/// bucket the first, the last, the smallest and the largest of each channel (the M4 aggregation of Jugel et
/// al., VLDB 2014), and the first and last sample of a gap (a sample is a gap when its first channel is not
/// finite). channels: at least one, all of one length n. Returns all of 0..n-1 when n <= max_samples,
/// otherwise at most max(max_samples, 4 + 2 * channels) indices; each channel's global extremes are always
/// among them.
std::vector<std::size_t> kept_samples(std::span<const std::span<const double>> channels,
                                      std::size_t max_samples);

}  // namespace omniflight::report

// Blocks of a flight that are left out in turn, or whose scatter says how uncertain a value is.
#pragma once

#include "problem.hpp"

namespace omniflight::diagnosis {

/// Blocks of a second or more, about twenty a flight; samples of one block share an index below `count`.
std::vector<int> blocks_of(const Problem& problem, int& count);
/// The same sizes, but every sample is dealt to a block at random (fixed seed).
std::vector<int> random_folds(const Problem& problem, int& count);

}  // namespace omniflight::diagnosis

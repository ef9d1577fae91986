// Systems whose truth is known, and data of theirs (synthetic).
#pragma once

#include "omniflight_core/random.hpp"
#include "omniflight_identification/fit.hpp"

namespace omniflight::identification::testing {

/// One input, a truth of the given structure and second order; poles of the plant 0.8 +- 0.2i or similar.
PolynomialModel known_system(Structure structure);

/// Data of a model driven by a random binary input of +-1 (bits of three samples) and white innovations.
Dataset data_of(const PolynomialModel& truth, double innovation_rms, Eigen::Index samples, Random& random);

Eigen::VectorXd random_binary(Eigen::Index samples, int bit, Random& random);

}  // namespace omniflight::identification::testing

// What was found free of feedback, held against the flight as it was measured.
#pragma once

#include <string>
#include <vector>

#include "fit.hpp"

namespace omniflight::diagnosis {

/// Ids of members beside others that do not earn their parameters on `measured`. Instruments are what a
/// simulator made of the reference: a strong effect turns the vehicle a little from it, and what that does to
/// the wrench is a share of the effect which others seem to explain. On the measured flight there is no such
/// share; what is really there shows on both. `candidates`: how many were tried.
/// So many as `least` are left whatever they earn.
std::vector<std::string> unconfirmed(const Problem& measured, const Fit& model, std::size_t candidates,
                                     const Options& o, std::size_t least = 1);

/// The law that instruments are blind to: beside `model` it alone takes nine tenths of what is left in one of
/// the channels of `measured`, and stays within its limits. Rotors that shiver around their reversal do so at
/// other moments in a simulated flight, so that nothing they do shows on instruments. Where so little is
/// left, feedback has little to bend. Laws with bends of their own must leave nearly nothing of what is much:
/// a rope that catches the vehicle holds it elsewhere than where it flies without. Null where there is none.
const physics::Effect* overlooked(const Problem& measured, const Fit& model,
                                  const std::vector<const physics::Effect*>& candidates, const Options& o);

}  // namespace omniflight::diagnosis

// A thrust that changes with the tilt is a rival of a weak thrust on one tilt, and none once the tilt has
// moved.
#include "../src/nested.hpp"

#include "../src/problem.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

bool adds_freedom(bool both_tilts, const char* named, const char* rival) {
  const vehicle::Vehicle v = test::omnimorph();
  const Options o;
  const physics::Effect *weak = physics::find_effect(named), *rich = physics::find_effect(rival);
  test::Flown low, high;
  low.alpha = 0.4, high.alpha = 0.6, high.seed = 2;
  const auto one = prepare_flight(test::fly(v, {{weak, {-0.1}}}, low), v, o),
             two = prepare_flight(test::fly(v, {{weak, {-0.1}}}, high), v, o);
  EXPECT_TRUE(one && two);
  if (!one || !two) return false;
  const Flight* flights[] = {&*one, &*two};
  const Problem problem(std::span(flights, both_tilts ? 2 : 1), v, o);
  const auto fitted = [&](const physics::Effect* e) {
    return fit_effects(problem, {{e, std::vector<double>(static_cast<std::size_t>(e->parameter_count()))}},
                       o);
  };
  return only_adds_freedom(problem, fitted(weak), 0, fitted(rich));
}

TEST(Nested, ALawThatContainsAnotherIsARivalOnlyWhereItsFreedomWouldNotShow) {
  EXPECT_FALSE(adds_freedom(false, "thrust_scale", "tilt_efficiency"));
  EXPECT_TRUE(adds_freedom(true, "thrust_scale", "tilt_efficiency"));
  EXPECT_FALSE(adds_freedom(true, "thrust_scale", "constant_pull")) << "it does not contain it";
  EXPECT_FALSE(adds_freedom(true, "thrust_scale", "payload_mass")) << "it is not richer";
}

}  // namespace
}  // namespace omniflight::diagnosis

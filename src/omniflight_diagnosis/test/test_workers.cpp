// Pieces of a search on several threads: the answer must not know how many there were.
#include "../src/workers.hpp"

#include "../src/naming.hpp"
#include "../src/whitening.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;
using physics::find_effect;

struct World {
  vehicle::Vehicle v = test::omnimorph();
  Options o;
  Flight flight;
  World() {
    test::Flown f;
    f.duration_s = 20, f.climb_m = 1.1, f.sway = 0.2;
    flight = *prepare_flight(
        test::fly(v, {{find_effect("hung_cable"), {0.15, 0.5, 1.2}}, {find_effect("thrust_scale"), {0.97}}},
                  f),
        v, o);
  }
};

TEST(Workers, ResultsStandInTheirOrderAndEndWhereTimeWasUp) {
  const World w;
  const Flight* one[] = {&w.flight};
  const Problem problem(one, w.v, w.o);
  for (const int threads : {1, 2, 5}) {
    const Workers workers(problem, threads);
    const auto squares =
        workers.map<int>(100, [](const Problem&, std::size_t i) { return static_cast<int>(i * i); });
    ASSERT_EQ(squares.size(), 100u);
    for (int i = 0; i < 100; ++i) EXPECT_EQ(squares[static_cast<std::size_t>(i)], i * i);
    EXPECT_TRUE(workers.map<int>(0, [](const Problem&, std::size_t) { return 1; }).empty());
    int asked = 0;
    const auto some_work = [](const Problem&, std::size_t i) {  // or others end before the caller is asked
      std::this_thread::sleep_for(std::chrono::microseconds(50));
      return i;
    };
    const auto begun = workers.map<std::size_t>(100000, some_work, [&] { return ++asked > 3; });
    EXPECT_LT(begun.size(), 100000u);
    for (std::size_t i = 0; i < begun.size(); ++i) EXPECT_EQ(begun[i], i);
  }
}

TEST(Workers, EveryThreadFindsTheSame) {
  const World w;
  const Flight* one[] = {&w.flight};
  std::vector<const physics::Effect*> offered;
  for (const char* id : {"hung_cable", "thrust_scale", "payload_mass", "taut_rope", "com_offset",
                         "constant_pull", "attachment_torque", "inertia_error"})
    offered.push_back(find_effect(id));
  std::vector<Naming> found;
  for (const int threads : {1, 3}) {
    Options o = w.o;
    o.threads = threads;
    const Problem problem(one, w.v, o);
    found.push_back(name_effects(problem, offered, o));
    tell_rivals(problem, o, found.back());
  }
  ASSERT_FALSE(found[0].named.empty());
  ASSERT_EQ(found[0].named.size(), found[1].named.size());
  EXPECT_EQ(found[0].model.log_likelihood, found[1].model.log_likelihood);  // to the bit
  EXPECT_EQ(found[0].aliases.cosine, found[1].aliases.cosine);
  for (std::size_t k = 0; k < found[0].named.size(); ++k) {
    EXPECT_EQ(found[0].model.effects[k].effect, found[1].model.effects[k].effect);
    EXPECT_EQ(found[0].model.effects[k].theta, found[1].model.effects[k].theta);
    EXPECT_EQ(found[0].named[k].probability, found[1].named[k].probability);
  }
}

TEST(Workers, WhatIsRememberedIsWhatWouldBeComputed) {
  const World w;
  const Flight* one[] = {&w.flight};
  const Problem problem(one, w.v, w.o);
  // a steady law, one that bends, one that makes the vehicle heavier, and steady ones beside a heavy one
  for (const std::vector<ActiveEffect>& model : std::vector<std::vector<ActiveEffect>>{
           {{find_effect("thrust_scale"), {0.9}}},
           {{find_effect("hung_cable"), {0.2, 0.4, 1.0}}, {find_effect("constant_pull"), {1, 2, 3}}},
           {{find_effect("payload_mass"), {0.3}}, {find_effect("thrust_scale"), {0.9}}}}) {
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(problem.offset_sigma().size());
    Eigen::VectorXd rest;
    Eigen::MatrixXd jacobian;
    problem.predict(model, none, rest, &jacobian);
    EXPECT_EQ(problem.whitened(model, jacobian), problem.noise().apply(problem, jacobian));
  }
}

}  // namespace
}  // namespace omniflight::diagnosis

// The order of the integrators, from the slope of the error over four halvings of the step.
#include <gtest/gtest.h>

#include "flying.hpp"

namespace omniflight::simulation {
namespace {

physics::Model model() {
  physics::Model m;
  m.effects.push_back({physics::find_effect("rotor_drag"), {1e-4}});
  m.effects.push_back({physics::find_effect("parasitic_drag"), {0.02}});
  m.effects.push_back({physics::find_effect("payload_mass"), {0.2}});
  return m;
}

/// Powered tumbling for 0.256 s; the rotors spin up on the way.
RigidState fly(Integrator integrator, double step) {
  PlantConfig c;
  c.step = step;
  c.integrator = integrator;
  c.initial.w_WB_B = Vec3(3, 5, -4);
  c.initial.v_WB_W = Vec3(1, -2, 0.5);
  c.initial_alpha = 0.5;
  Plant plant = make(omnimorph(), model(), c);
  plant.set_command(std::vector<double>{900, 700, 800, 650, 720, 810, 640, 905}, 0.5);
  const int n = static_cast<int>(std::lround(0.256 / step));
  for (int k = 0; k < n; ++k)
    if (!plant.step()) throw std::runtime_error("the integration failed");
  return plant.body();
}

double distance(const RigidState& a, const RigidState& b) {
  return (a.p_WB - b.p_WB).norm() + (a.v_WB_W - b.v_WB_W).norm() + (a.w_WB_B - b.w_WB_B).norm() +
         log_rotation(a.q_WB.conjugate() * b.q_WB).norm();
}

/// Least-squares slope of log2(error) over log2(step).
double order(Integrator integrator, double coarsest) {
  const RigidState exact = fly(Integrator::rk4, 0.0000625);
  double sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
  for (int k = 0; k < 5; ++k) {
    const double x = -k, y = std::log2(distance(fly(integrator, std::ldexp(coarsest, -k)), exact));
    sum_x += x, sum_y += y, sum_xx += x * x, sum_xy += x * y;
  }
  return (5 * sum_xy - sum_x * sum_y) / (5 * sum_xx - sum_x * sum_x);
}

TEST(Convergence, RungeKuttaIsOfFourthOrder) { EXPECT_NEAR(order(Integrator::rk4, 0.008), 4.0, 0.15); }

TEST(Convergence, SemiImplicitEulerIsOfFirstOrder) {
  EXPECT_NEAR(order(Integrator::semi_implicit_euler, 0.002), 1.0, 0.1);
}

}  // namespace
}  // namespace omniflight::simulation

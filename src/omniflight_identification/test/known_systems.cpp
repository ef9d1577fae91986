#include "known_systems.hpp"

namespace omniflight::identification::testing {

Eigen::VectorXd random_binary(Eigen::Index samples, int bit, Random& random) {
  Eigen::VectorXd u(samples);
  double level = 1;
  for (Eigen::Index t = 0; t < samples; ++t) {
    if (t % bit == 0) level = random.uniform() < 0.5 ? -1 : 1;
    u[t] = level;
  }
  return u;
}

PolynomialModel known_system(Structure structure) {
  PolynomialModel m;
  m.period_s = 0.01;
  m.delay = {2};
  const Eigen::Vector2d plant(-1.5, 0.6);
  m.b = Eigen::Vector2d(0.6, 0.3);
  switch (structure) {
    case Structure::arx:
      m.a = plant;
      break;
    case Structure::armax:
    case Structure::state_space:
      m.a = plant;
      m.c = Eigen::Vector2d(-0.9, 0.3);
      break;
    case Structure::output_error:
      m.f = plant;
      break;
    case Structure::box_jenkins:
      m.f = plant;
      m.c = Eigen::VectorXd::Constant(1, 0.5);
      m.d = Eigen::VectorXd::Constant(1, -0.8);
      break;
  }
  return m;
}

Dataset data_of(const PolynomialModel& truth, double innovation_rms, Eigen::Index samples, Random& random) {
  constexpr Eigen::Index kLead = 300;  // so that the data do not begin at rest
  Experiment e;
  const Eigen::Index n = samples + kLead;
  e.u = random_binary(n, 3, random);
  Eigen::VectorXd noise(n);
  for (double& x : noise) x = innovation_rms * random.normal();
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(1);
  e.y = simulated(truth, e) + filtered(one, monic(truth.a), filtered(monic(truth.c), monic(truth.d), noise));
  return {truth.period_s, {{e.y.tail(samples), e.u.bottomRows(samples)}}};
}

}  // namespace omniflight::identification::testing

#include "state_variables.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::diagnosis {

std::vector<StateVariable> state_variables(const RegressionProblem& problem) {
  const int n = problem.samples();
  std::vector<StateVariable> v{
      {"height", "m", {}, true},   {"forward speed", "m/s", {}},    {"sideward speed", "m/s", {}},
      {"climb speed", "m/s", {}},  {"tilt of the body", "rad", {}}, {"rotor tilt", "rad", {}},
      {"position x", "m", {}},     {"position y", "m", {}},         {"roll rate", "rad/s", {}},
      {"pitch rate", "rad/s", {}}, {"yaw rate", "rad/s", {}}};
  for (StateVariable& x : v) x.x.resize(n);
  for (int i = 0; i < n; ++i) {
    const physics::Situation& s = problem.measured(i);
    const Vec3 &p = s.body.p_WB, &w = s.body.w_WB_B;
    const double values[] = {p.z(),
                             s.v_WB_B.x(),
                             s.v_WB_B.y(),
                             s.body.v_WB_W.z(),
                             std::acos(std::clamp(s.R_WB(2, 2), -1.0, 1.0)),
                             s.alpha,
                             p.x(),
                             p.y(),
                             w.x(),
                             w.y(),
                             w.z()};
    for (std::size_t k = 0; k < v.size(); ++k) v[k].x[i] = values[k];
  }
  return v;
}

double spread(const Eigen::VectorXd& x) { return x.size() > 0 ? x.maxCoeff() - x.minCoeff() : 0.0; }

}  // namespace omniflight::diagnosis

// The part of every effect's derivative that does not depend on its equation.
#include <algorithm>

#include "omniflight_physics/effect.hpp"

namespace omniflight::physics {

template <class T>
void WrenchT<T>::add_at(const Vec3& p_B, const Eigen::Matrix<T, 3, 1>& f_B) {
  force_B += f_B;
  torque_B += p_B.cast<T>().cross(f_B);
}

template <class T>
Eigen::Matrix<T, 6, 1> WrenchT<T>::at(const Situation& s) const {
  Eigen::Matrix<T, 6, 1> w;
  w << force_B, torque_B;
  if (has_inertia) {
    Vec6 nu;
    nu << s.a_WB_B, s.dw_WB_B;
    w -= inertia * nu.cast<T>();
  }
  const Vec3 up = s.R_WB.row(2).transpose();
  w.template head<3>() -= mass * s.a_WB_B.cast<T>() + lifted_mass * (up.dot(s.a_WB_B) * up).cast<T>();
  return w;
}

template <class T>
Eigen::Matrix<T, 6, 6> WrenchT<T>::moving_inertia(const Situation& s) const {
  const Vec3 up = s.R_WB.row(2).transpose();
  Eigen::Matrix<T, 6, 6> all = inertia;
  all.template topLeftCorner<3, 3>() += lifted_mass * (up * up.transpose()).cast<T>();
  for (int k = 0; k < 3; ++k) all(k, k) += mass;
  return all;
}

template struct WrenchT<double>;
template struct WrenchT<Jet<kFewParameters>>;
template struct WrenchT<Jet<kJetParameters>>;

template <int N>
void make_jets(const double* theta, int count, Jet<N>* x) {
  for (int k = 0; k < count; ++k) x[k] = Jet<N>(theta[k], k);
}

template <int N>
void split_jets(const WrenchT<Jet<N>>& wrench, const Situation& s, int count, double* value, double* jacobian,
                std::size_t stride) {
  const Eigen::Matrix<Jet<N>, 6, 1> w = wrench.at(s);
  for (int row = 0; row < 6; ++row) {
    value[row] = w[row].a;
    if (!jacobian) continue;
    for (int k = 0; k < count; ++k)
      jacobian[static_cast<std::size_t>(k) * stride + static_cast<std::size_t>(row)] = w[row].v[k];
  }
}

template void make_jets<kFewParameters>(const double*, int, Jet<kFewParameters>*);
template void make_jets<kJetParameters>(const double*, int, Jet<kJetParameters>*);
template void split_jets<kFewParameters>(const WrenchT<Jet<kFewParameters>>&, const Situation&, int, double*,
                                         double*, std::size_t);
template void split_jets<kJetParameters>(const WrenchT<Jet<kJetParameters>>&, const Situation&, int, double*,
                                         double*, std::size_t);

}  // namespace omniflight::physics

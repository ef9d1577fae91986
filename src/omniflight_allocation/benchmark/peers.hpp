// Other people's solvers behind one small interface: solve(program), then u() [N].
#pragma once

#include "flight_programs.hpp"

#ifdef OMNIFLIGHT_HAVE_NLOPT
#include <nlopt.h>
#endif
#ifdef OMNIFLIGHT_HAVE_DLIB
#include <dlib/optimization.h>
#endif

namespace omniflight::allocation {

#ifdef OMNIFLIGHT_HAVE_QUADPROG
extern "C" void qpgen2_(double* D, double* d, const int* fdD, const int* n, double* x, double* lagr,
                        double* value, const double* A, const double* b, const int* fdA, const int* q,
                        const int* meq, int* iact, int* nact, int* iter, double* work, int* ierr);

/// Goldfarb and Idnani's dual method as the R package quadprog compiles it; minimises 1/2 x'Dx - d'x with
/// A'x >= b. It has no warm start.
class QuadprogPeer {
 public:
  QuadprogPeer() {
    A_.leftCols<kRotors>().setIdentity();
    A_.rightCols<kRotors>() = -Eigen::Matrix<double, kRotors, kRotors>::Identity();
  }
  void solve(const Qp& qp) {
    // weights of case A are stiff: scaled to a largest diagonal of 1, as our own solver does inside
    const double scale = 1.0 / qp.H.diagonal().maxCoeff();
    D_ = scale * qp.H;
    d_ = -scale * qp.g;
    b_ << qp.lower, -qp.upper;
    const int n = kRotors, q = 2 * kRotors, none = 0;
    int error = 0;
    qpgen2_(D_.data(), d_.data(), &n, &n, u_.data(), lagrangians_, &value_, A_.data(), b_.data(), &n, &q,
            &none, active_, &active_count_, iterations_, work_, &error);
  }
  const Eigen::Matrix<double, kRotors, 1>& u() const { return u_; }

 private:
  Eigen::Matrix<double, kRotors, kRotors> D_;
  Eigen::Matrix<double, kRotors, 1> d_, u_;
  Eigen::Matrix<double, kRotors, 2 * kRotors> A_;
  Eigen::Matrix<double, 2 * kRotors, 1> b_;
  double lagrangians_[2 * kRotors], value_ = 0;
  double work_[2 * kRotors + kRotors * (kRotors + 5) / 2 + 2 * (2 * kRotors) + 1];
  int active_[2 * kRotors], active_count_ = 0, iterations_[2];
};
#endif

#ifdef OMNIFLIGHT_HAVE_DLIB
/// dlib's coordinate descent with momentum for boxes, started at the answer before.
class DlibPeer {
 public:
  DlibPeer() { u_.setZero(); }
  void solve(const Qp& qp) {
    const double scale = 1.0 / qp.H.diagonal().maxCoeff();
    for (int i = 0; i < kRotors; ++i) {
      for (int j = 0; j < kRotors; ++j) Q_(i, j) = scale * qp.H(i, j);
      b_(i) = scale * qp.g[i];
      lower_(i) = qp.lower[i];
      upper_(i) = qp.upper[i];
      x_(i) = std::clamp(u_[i], qp.lower[i], qp.upper[i]);
    }
    dlib::solve_qp_box_constrained(Q_, b_, x_, lower_, upper_, 1e-10, 20000);
    for (int i = 0; i < kRotors; ++i) u_[i] = x_(i);
  }
  const Eigen::Matrix<double, kRotors, 1>& u() const { return u_; }

 private:
  dlib::matrix<double, kRotors, kRotors> Q_;
  dlib::matrix<double, kRotors, 1> b_, lower_, upper_, x_;
  Eigen::Matrix<double, kRotors, 1> u_;
};
#endif

#ifdef OMNIFLIGHT_HAVE_NLOPT
/// Sequential quadratic programming for general costs, started at the answer before.
class NloptPeer {
 public:
  NloptPeer() : opt_(nlopt_create(NLOPT_LD_SLSQP, kRotors)) {
    u_.setZero();
    nlopt_set_ftol_rel(opt_, 1e-12);
    nlopt_set_maxeval(opt_, 200);
  }
  ~NloptPeer() { nlopt_destroy(opt_); }
  NloptPeer(const NloptPeer&) = delete;
  NloptPeer& operator=(const NloptPeer&) = delete;
  void solve(const Qp& qp) {
    const double scale = 1.0 / qp.H.diagonal().maxCoeff();
    H_ = scale * qp.H;
    g_ = scale * qp.g;
    nlopt_set_lower_bounds(opt_, qp.lower.data());
    nlopt_set_upper_bounds(opt_, qp.upper.data());
    nlopt_set_min_objective(opt_, cost, this);
    double value = 0;
    nlopt_optimize(opt_, u_.data(), &value);
  }
  const Eigen::Matrix<double, kRotors, 1>& u() const { return u_; }

 private:
  static double cost(unsigned n, const double* x, double* gradient, void* data) {
    const auto& self = *static_cast<const NloptPeer*>(data);
    const Eigen::Map<const Eigen::Matrix<double, kRotors, 1>> u(x, n);
    const Eigen::Matrix<double, kRotors, 1> Hu = self.H_ * u;
    if (gradient != nullptr) Eigen::Map<Eigen::Matrix<double, kRotors, 1>>(gradient, n) = Hu + self.g_;
    return 0.5 * u.dot(Hu) + self.g_.dot(u);
  }
  nlopt_opt opt_;
  Eigen::Matrix<double, kRotors, kRotors> H_;
  Eigen::Matrix<double, kRotors, 1> g_, u_;
};
#endif

}  // namespace omniflight::allocation

// The general linear model of prediction-error identification, of which ARX, ARMAX, Output-Error and
// Box-Jenkins are special cases (L. Ljung, System Identification, 2nd ed., 1999, section 4.2):
//
//   A(q) y(t) = sum_i B_i(q) / F(q) u_i(t) + C(q) / D(q) e(t),   q^-1 x(t) = x(t - 1),  e white
//
// Several inputs share one F: what they drive is one motor.
#pragma once

#include <Eigen/Dense>
#include <complex>
#include <string>
#include <vector>

#include "omniflight_identification/data.hpp"

namespace omniflight::identification {

enum class Structure { arx, armax, output_error, box_jenkins, state_space };
/// "ARX", "ARMAX", "Output-Error", "Box-Jenkins", "state space".
const char* name_of(Structure structure);
const std::vector<Structure>& all_structures();

/// Numbers of coefficients beside the leading 1 of A, C, D, F; of B all of them.
struct Orders {
  int a = 0, b = 1, c = 0, d = 0, f = 0;
  std::vector<int> delay{1};  ///< samples, one an input: B_i begins with q^-delay; at least 0

  int count(Eigen::Index inputs) const { return a + c + d + f + b * static_cast<int>(inputs); }
};

/// Orders of a structure whose plant has `order` poles and `zeros` + 1 coefficients in B; the noise of ARMAX
/// and Box-Jenkins has the plant's order (at most 2 for Box-Jenkins). A state space model of one output in
/// innovations form is ARMAX(n, n, n) with no direct feedthrough (Ljung, section 4.3).
Orders orders_of(Structure structure, int order, int zeros, std::vector<int> delay);

struct PolynomialModel {
  double period_s = 0.0;
  Eigen::VectorXd a, c, d, f;  ///< without the leading 1
  Eigen::MatrixXd b;           ///< a column an input
  std::vector<int> delay;      ///< samples, one an input

  Orders orders() const;
  /// a, b (input by input), c, d, f in one vector, and back.
  Eigen::VectorXd parameters() const;
  void set_parameters(const Eigen::VectorXd& theta);
  /// "a1", "b1", "b1 of input 2", ... in the order of parameters().
  std::vector<std::string> parameter_names() const;

  /// Poles of A F, the plant's; |p| < 1 when it is stable.
  std::vector<std::complex<double>> poles() const;
  std::vector<std::complex<double>> zeros(Eigen::Index input) const;
  bool stable() const;  ///< A and F; a predictor also needs C
  /// Change of the output per change of an input that lasts, sum(B) / (A(1) F(1)).
  double static_gain(Eigen::Index input) const;
  /// G(exp(i w T)) of an input at w [rad/s].
  std::complex<double> response(Eigen::Index input, double w_radps) const;
  /// Output after a unit step of an input at t = 0, `count` samples from t = 0 on.
  Eigen::VectorXd step(Eigen::Index input, Eigen::Index count) const;
};

/// x(t) of a system with the given output and innovations form: x+ = A x + B u + K e, y = C x + e, in
/// observer canonical form. Inputs with a delay of more than one sample come delayed by delay - 1.
struct StateSpace {
  Eigen::MatrixXd A, B, C, K;
};
/// Of a model with A, B and C only (ARX, ARMAX, state space), or with F only (K = 0).
StateSpace state_space(const PolynomialModel& model);

/// numerator(q) / denominator(q) x from rest; both with their leading coefficient, denominator(0) = 1.
Eigen::VectorXd filtered(const Eigen::VectorXd& numerator, const Eigen::VectorXd& denominator,
                         const Eigen::VectorXd& x);
/// 1 followed by the coefficients.
Eigen::VectorXd monic(const Eigen::VectorXd& coefficients);
/// Whether z^n + c1 z^n-1 + ... has all its roots inside the unit circle (Schur-Cohn); true when empty.
bool schur_stable(const Eigen::VectorXd& coefficients);
/// Roots of z^n + c1 z^n-1 + ...
std::vector<std::complex<double>> roots(const Eigen::VectorXd& coefficients);
/// The same polynomial with the roots outside the unit circle put to 1 / conj(root), and none nearer to it
/// than 1e-3.
Eigen::VectorXd stabilised(const Eigen::VectorXd& coefficients);

/// Output of B / (A F) u from rest: the simulation, without noise.
Eigen::VectorXd simulated(const PolynomialModel& model, const Experiment& experiment);
/// The simulation with the initial state for which it fits best (what MATLAB's `compare` does).
Eigen::VectorXd simulated_from_best_start(const PolynomialModel& model, const Experiment& experiment);
/// One-step prediction errors (D / C)(A y - B / F u), from rest.
Eigen::VectorXd residuals(const PolynomialModel& model, const Experiment& experiment);

/// 100 (1 - |y - estimate| / |y - mean(y)|) [%], the definition of MATLAB's `compare`; 100 is perfect, 0 as
/// good as the mean. -inf when y does not move.
double fit_percent(const Eigen::VectorXd& y, const Eigen::VectorXd& estimate);
/// Of the simulation from the best start, all experiments weighed by their length.
double fit_percent(const PolynomialModel& model, const Dataset& data);

}  // namespace omniflight::identification

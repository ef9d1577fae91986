#include "omniflight_identification/polynomial_model.hpp"

#include <limits>

namespace omniflight::identification {
namespace {

/// x(t - delay), zero before the start.
Eigen::VectorXd delayed(const Eigen::VectorXd& x, Eigen::Index delay) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(x.size());
  if (delay < x.size()) out.tail(x.size() - delay) = x.head(x.size() - delay);
  return out;
}

Eigen::VectorXd convolved(const Eigen::VectorXd& p, const Eigen::VectorXd& q) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(p.size() + q.size() - 1);
  for (Eigen::Index i = 0; i < p.size(); ++i) out.segment(i, q.size()) += p[i] * q;
  return out;
}

Eigen::VectorXd plant_denominator(const PolynomialModel& m) { return convolved(monic(m.a), monic(m.f)); }

}  // namespace

const char* name_of(Structure structure) {
  switch (structure) {
    case Structure::arx:
      return "ARX";
    case Structure::armax:
      return "ARMAX";
    case Structure::output_error:
      return "Output-Error";
    case Structure::box_jenkins:
      return "Box-Jenkins";
    case Structure::state_space:
      return "state space";
  }
  return "";
}

const std::vector<Structure>& all_structures() {
  static const std::vector<Structure> all{Structure::arx, Structure::armax, Structure::output_error,
                                          Structure::box_jenkins, Structure::state_space};
  return all;
}

Orders orders_of(Structure structure, int order, int zeros, std::vector<int> delay) {
  Orders o;
  o.delay = std::move(delay);
  o.b = zeros + 1;
  const int noise = std::min(order, 2);
  switch (structure) {
    case Structure::arx:
      o.a = order;
      break;
    case Structure::armax:
      o.a = o.c = order;
      break;
    case Structure::output_error:
      o.f = order;
      break;
    case Structure::box_jenkins:
      o.f = order;
      o.c = o.d = noise;
      break;
    case Structure::state_space:
      o.a = o.c = o.b = order;
      break;
  }
  return o;
}

Orders PolynomialModel::orders() const {
  return {static_cast<int>(a.size()), static_cast<int>(b.rows()), static_cast<int>(c.size()),
          static_cast<int>(d.size()), static_cast<int>(f.size()), delay};
}

Eigen::VectorXd PolynomialModel::parameters() const {
  Eigen::VectorXd theta(a.size() + b.size() + c.size() + d.size() + f.size());
  theta << a, b.reshaped(), c, d, f;
  return theta;
}

void PolynomialModel::set_parameters(const Eigen::VectorXd& theta) {
  Eigen::Index at = 0;
  const auto take = [&](Eigen::VectorXd& part) {
    part = theta.segment(at, part.size()).eval();
    at += part.size();
  };
  take(a);
  b = theta.segment(at, b.size()).reshaped(b.rows(), b.cols()).eval();
  at += b.size();
  take(c);
  take(d);
  take(f);
}

std::vector<std::string> PolynomialModel::parameter_names() const {
  std::vector<std::string> names;
  const auto add = [&](const char* letter, Eigen::Index count, const std::string& behind = {}) {
    for (Eigen::Index k = 0; k < count; ++k) names.push_back(letter + std::to_string(k + 1) + behind);
  };
  add("a", a.size());
  for (Eigen::Index i = 0; i < b.cols(); ++i)
    add("b", b.rows(), i == 0 ? "" : " of input " + std::to_string(i + 1));
  add("c", c.size());
  add("d", d.size());
  add("f", f.size());
  return names;
}

std::vector<std::complex<double>> PolynomialModel::poles() const {
  auto out = roots(a);
  for (const auto& p : roots(f)) out.push_back(p);
  return out;
}

std::vector<std::complex<double>> PolynomialModel::zeros(Eigen::Index input) const {
  const Eigen::VectorXd numerator = b.col(input);
  Eigen::Index first = 0;
  while (first < numerator.size() && std::abs(numerator[first]) < 1e-12 * numerator.cwiseAbs().maxCoeff())
    ++first;
  if (first >= numerator.size()) return {};
  return roots(numerator.tail(numerator.size() - first - 1) / numerator[first]);
}

bool PolynomialModel::stable() const { return schur_stable(a) && schur_stable(f); }

double PolynomialModel::static_gain(Eigen::Index input) const {
  return b.col(input).sum() / ((1.0 + a.sum()) * (1.0 + f.sum()));
}

std::complex<double> PolynomialModel::response(Eigen::Index input, double w_radps) const {
  const std::complex<double> step = std::exp(std::complex<double>(0, -w_radps * period_s));
  const auto at = [&](const Eigen::VectorXd& p) {
    std::complex<double> sum = 0, power = 1;
    for (Eigen::Index k = 0; k < p.size(); ++k, power *= step) sum += p[k] * power;
    return sum;
  };
  const double late = delay[static_cast<std::size_t>(input)];
  return std::pow(step, late) * at(b.col(input)) / (at(monic(a)) * at(monic(f)));
}

Eigen::VectorXd PolynomialModel::step(Eigen::Index input, Eigen::Index count) const {
  Experiment e{Eigen::VectorXd::Zero(count), Eigen::MatrixXd::Zero(count, b.cols())};
  e.u.col(input).setOnes();
  return simulated(*this, e);
}

StateSpace state_space(const PolynomialModel& m) {
  const Eigen::VectorXd a = m.a.size() > 0 ? m.a : m.f;
  const Eigen::Index n = std::max<Eigen::Index>(a.size(), m.b.rows());
  StateSpace s{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, m.b.cols()), Eigen::MatrixXd::Zero(1, n),
               Eigen::MatrixXd::Zero(n, 1)};
  s.A.col(0).head(a.size()) = -a;
  s.A.topRightCorner(n - 1, n - 1).setIdentity();
  s.B.topRows(m.b.rows()) = m.b;
  s.C(0, 0) = 1.0;
  if (m.a.size() > 0) {
    s.K.col(0).head(m.c.size()) += m.c;
    s.K.col(0).head(a.size()) -= a;
  }
  return s;
}

Eigen::VectorXd simulated(const PolynomialModel& m, const Experiment& e) {
  const Eigen::VectorXd denominator = plant_denominator(m);
  Eigen::VectorXd driven = Eigen::VectorXd::Zero(e.u.rows());
  for (Eigen::Index i = 0; i < m.b.cols(); ++i)
    driven += filtered(m.b.col(i), Eigen::VectorXd::Ones(1),
                       delayed(e.u.col(i), m.delay[static_cast<std::size_t>(i)]));
  return filtered(Eigen::VectorXd::Ones(1), denominator, driven);
}

Eigen::VectorXd simulated_from_best_start(const PolynomialModel& m, const Experiment& e) {
  const Eigen::VectorXd forced = simulated(m, e);
  const Eigen::VectorXd denominator = plant_denominator(m);
  const Eigen::Index n = denominator.size() - 1;
  if (n == 0 || e.y.size() <= n) return forced;
  // the free responses are those to a kick of the output at samples 0 .. n-1
  Eigen::MatrixXd free(e.y.size(), n);
  for (Eigen::Index k = 0; k < n; ++k)
    free.col(k) = filtered(Eigen::VectorXd::Ones(1), denominator, Eigen::VectorXd::Unit(e.y.size(), k));
  return forced + free * free.colPivHouseholderQr().solve(e.y - forced);
}

Eigen::VectorXd residuals(const PolynomialModel& m, const Experiment& e) {
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(1);
  Eigen::VectorXd driven = Eigen::VectorXd::Zero(e.u.rows());
  for (Eigen::Index i = 0; i < m.b.cols(); ++i)
    driven += filtered(m.b.col(i), one, delayed(e.u.col(i), m.delay[static_cast<std::size_t>(i)]));
  const Eigen::VectorXd noise = filtered(monic(m.a), one, e.y) - filtered(one, monic(m.f), driven);
  return filtered(monic(m.d), monic(m.c), noise);
}

double fit_percent(const Eigen::VectorXd& y, const Eigen::VectorXd& estimate) {
  const double spread = (y.array() - y.mean()).matrix().norm();
  if (!(spread > 0)) return -std::numeric_limits<double>::infinity();
  return 100.0 * (1.0 - (y - estimate).norm() / spread);
}

double fit_percent(const PolynomialModel& m, const Dataset& data) {
  double sum = 0;
  for (const Experiment& e : data.experiments)
    sum += static_cast<double>(e.y.size()) * fit_percent(e.y, simulated_from_best_start(m, e));
  return sum / static_cast<double>(data.samples());
}

}  // namespace omniflight::identification

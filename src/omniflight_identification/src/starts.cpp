#include "starts.hpp"

#include <limits>

namespace omniflight::identification {
namespace {

constexpr int kLongOrder = 12;         // of the ARX model whose residuals stand in for the innovations
constexpr int kRounds = 12;            // of Steiglitz and McBride; they settle in about five
constexpr double kSettledLoss = 1e-6;  // change of the loss from round to round
constexpr double kRank = 1e-10;        // smallest pivot per largest, of columns scaled to one

/// Least squares of stacked rows, by normal equations of columns scaled to one. Errors: rank.
class Regression {
 public:
  explicit Regression(Eigen::Index columns)
      : information_(Eigen::MatrixXd::Zero(columns, columns)), moment_(Eigen::VectorXd::Zero(columns)) {}
  void add(const Eigen::MatrixXd& X, const Eigen::VectorXd& y) {
    information_ += X.transpose() * X;
    moment_ += X.transpose() * y;
  }
  Result<Eigen::VectorXd> solve() const {
    const Eigen::VectorXd scale = information_.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * information_ * scale.asDiagonal();
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(scaled);
    const Eigen::VectorXd pivots = ldlt.vectorD().cwiseAbs();
    if (ldlt.info() != Eigen::Success || !(pivots.minCoeff() > kRank * pivots.maxCoeff()))
      return bad_input("the inputs do not excite a model of these orders (its regression has no full rank)",
                       "excitation",
                       "Record a command that moves at more frequencies, or choose a lower order");
    return Eigen::VectorXd(scale.asDiagonal() * ldlt.solve(scale.asDiagonal() * moment_));
  }

 private:
  Eigen::MatrixXd information_;
  Eigen::VectorXd moment_;
};

/// Columns -y(t-1).., u_1(t-delay).., u_2.., for t = skip .. end; 0 before the start.
Eigen::MatrixXd arx_columns(const Orders& o, const Eigen::VectorXd& y, const Eigen::MatrixXd& u,
                            Eigen::Index skip) {
  const Eigen::Index n = y.size();
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(n - skip, o.a + o.b * u.cols());
  Eigen::Index k = 0;
  const auto put = [&](const auto& x, Eigen::Index late) {
    const Eigen::Index from = std::max(skip, late);
    if (from < n) X.col(k).tail(n - from) = x.segment(from - late, n - from);
    ++k;
  };
  for (int i = 1; i <= o.a; ++i) put(-y, i);
  for (Eigen::Index j = 0; j < u.cols(); ++j)
    for (int i = 0; i < o.b; ++i) put(u.col(j), o.delay[static_cast<std::size_t>(j)] + i);
  return X;
}

double simulation_loss(const PolynomialModel& m, const Dataset& data, Eigen::Index skip) {
  double sum = 0;
  for (const Experiment& e : data.experiments) {
    const Eigen::Index n = e.y.size() - skip;
    sum += (e.y - simulated(m, e)).tail(n).squaredNorm();
  }
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

}  // namespace

PolynomialModel zero_model(const Orders& o, const Dataset& data) {
  PolynomialModel m;
  m.period_s = data.period_s;
  m.delay = o.delay;
  m.a.setZero(o.a);
  m.b.setZero(o.b, data.inputs());
  m.c.setZero(o.c);
  m.d.setZero(o.d);
  m.f.setZero(o.f);
  return m;
}

Result<PolynomialModel> least_squares_arx(const Orders& o, const Dataset& data, Eigen::Index skip) {
  Regression regression(o.a + o.b * data.inputs());
  for (const Experiment& e : data.experiments)
    regression.add(arx_columns(o, e.y, e.u, skip), e.y.tail(e.y.size() - skip));
  const auto theta = regression.solve();
  if (!theta) return Failure(theta.error());
  Orders arx = o;
  arx.c = arx.d = arx.f = 0;
  PolynomialModel m = zero_model(arx, data);
  m.set_parameters(*theta);
  return m;
}

Result<PolynomialModel> steiglitz_mcbride(const Orders& o, const Dataset& data, Eigen::Index skip) {
  Orders arx = o;
  arx.a = o.f;
  arx.c = arx.d = arx.f = 0;
  PolynomialModel best = zero_model(o, data);
  double least = std::numeric_limits<double>::infinity();
  Eigen::VectorXd f = Eigen::VectorXd::Zero(o.f);
  for (int round = 0; round < kRounds; ++round) {
    Dataset inverse = data;
    const Eigen::VectorXd one = Eigen::VectorXd::Ones(1);
    for (Experiment& e : inverse.experiments) {
      e.y = filtered(one, monic(f), e.y);
      for (Eigen::Index i = 0; i < e.u.cols(); ++i) e.u.col(i) = filtered(one, monic(f), e.u.col(i));
    }
    const auto fitted = least_squares_arx(arx, inverse, skip);
    if (!fitted) {
      if (std::isfinite(least)) break;
      return Failure(fitted.error());
    }
    f = stabilised(fitted->a);
    PolynomialModel candidate = zero_model(o, data);
    candidate.b = fitted->b;
    candidate.f = f;
    const double loss = simulation_loss(candidate, data, skip);
    const bool settled = std::abs(loss - least) < kSettledLoss * loss;
    if (loss < least) {
      least = loss;
      best = candidate;
    }
    if (settled) break;
  }
  return best;
}

Result<PolynomialModel> hannan_rissanen(const Orders& o, const Dataset& data, Eigen::Index skip,
                                        const Eigen::VectorXd* denominator) {
  const bool driven = o.b > 0;
  Orders longer = o;
  longer.a = kLongOrder;
  longer.b = driven ? std::max(o.b, kLongOrder / 2) : 0;
  const auto first = least_squares_arx(longer, data, std::max<Eigen::Index>(skip, kLongOrder));
  if (!first) return Failure(first.error());
  const int free_a = denominator != nullptr ? 0 : o.a;
  const Eigen::Index plant = free_a + o.b * data.inputs();
  Regression regression(plant + o.c);
  for (const Experiment& e : data.experiments) {
    const Eigen::VectorXd innovation = residuals(*first, e);
    const Eigen::Index from = std::max<Eigen::Index>(skip, kLongOrder + o.c);
    Orders of = o;
    of.a = free_a;
    Eigen::MatrixXd X(e.y.size() - from, plant + o.c);
    X.leftCols(plant) = arx_columns(of, e.y, e.u, from);
    for (int i = 1; i <= o.c; ++i) X.col(plant + i - 1) = innovation.segment(from - i, e.y.size() - from);
    const Eigen::VectorXd response =
        denominator != nullptr ? filtered(monic(*denominator), Eigen::VectorXd::Ones(1), e.y) : e.y;
    regression.add(X, response.tail(e.y.size() - from));
  }
  const auto theta = regression.solve();
  if (!theta) return Failure(theta.error());
  PolynomialModel m = zero_model(o, data);
  m.a = denominator != nullptr ? *denominator : Eigen::VectorXd(theta->head(free_a));
  m.b = theta->segment(free_a, o.b * data.inputs()).reshaped(o.b, data.inputs());
  m.c = stabilised(theta->tail(o.c));
  return m;
}

}  // namespace omniflight::identification

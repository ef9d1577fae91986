#include "family_oracle.hpp"

#include <cmath>

#include "family_aliases.hpp"
#include "family_columns.hpp"

namespace omniflight::proof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Whitens a first-order process with the correlation time of the turbulence, seen through white noise:
/// innovations of the stationary Kalman filter, of unit variance.
class Whitener {
 public:
  Whitener(double process_rms, double white_rms, double correlation_time) {
    keep_ = std::exp(-1 / (kSeriesRate * std::max(1e-3, correlation_time)));
    const double drive = process_rms * process_rms * (1 - keep_ * keep_),
                 white = std::max(1e-24, white_rms * white_rms);
    double predicted = process_rms * process_rms;
    for (int k = 0; k < 2000; ++k) {
      gain_ = predicted / (predicted + white);
      predicted = keep_ * keep_ * (1 - gain_) * predicted + drive;
    }
    scale_ = 1 / std::sqrt(predicted + white);
  }
  void operator()(Eigen::Ref<VectorXd> x) const {
    double expected = 0;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const double innovation = x[i] - expected;
      expected = keep_ * (expected + gain_ * innovation);
      x[i] = innovation * scale_;
    }
  }

 private:
  double keep_ = 0, gain_ = 0, scale_ = 1;
};

/// Energy of `what` that no combination of the columns removes, in sigma; the calibration columns cost what
/// their priors say (unit variance each).
double beyond(const VectorXd& what, const std::vector<VectorXd>& free, const std::vector<VectorXd>& known) {
  const auto columns = static_cast<Eigen::Index>(free.size() + known.size());
  MatrixXd A(what.size(), columns);
  Eigen::Index c = 0;
  for (const auto* list : {&free, &known})
    for (const VectorXd& column : *list) A.col(c++) = column;
  MatrixXd gram = A.transpose() * A;
  const VectorXd moment = A.transpose() * what;
  for (Eigen::Index k = 0; k < columns; ++k)  // a free column is scaled so that its prior does not matter
    gram(k, k) += k < static_cast<Eigen::Index>(free.size()) ? 1e-9 * std::max(1e-12, gram(k, k)) : 1.0;
  const double left = what.squaredNorm() - moment.dot(gram.ldlt().solve(moment));
  return std::sqrt(std::max(0.0, left));
}

}  // namespace

Separability ask_oracle(const FamilyPlan& plan, const Laboratory& lab,
                        const std::array<double, 6>& turbulence, const FamilyFlown& flown) {
  Separability out;
  if (plan.kind != Kind::single && plan.kind != Kind::unknown) return out;
  const Hidden& h = hidden_effects()[plan.hidden[0]];
  const bool in_wrench = h.measure == Hidden::Measure::wrench;
  // with rotor speeds measured, what commands do not give is seen before any turbulence: nothing for this
  // oracle
  if (!in_wrench && (h.measure != Hidden::Measure::command || plan.where.speed())) return out;
  const FlightSeries& s = flown.series;
  const auto n = static_cast<Eigen::Index>(s.wrench.size());
  if (n < 100) return out;
  std::vector<Whitener> whiten;
  for (std::size_t c = 0; c < 6; ++c)
    whiten.emplace_back(turbulence[c], lab.sensor_noise[c], lab.told_turbulence.correlation_time);
  const auto whitened = [&](const MatrixXd& column) {
    VectorXd all(6 * n);
    for (int c = 0; c < 6; ++c) {
      all.segment(c * n, n) = column.col(c);
      whiten[static_cast<std::size_t>(c)](all.segment(c * n, n));
    }
    return all;
  };
  MatrixXd hidden(n, 6);
  for (Eigen::Index i = 0; i < n; ++i)
    hidden.row(i) = (s.wrench[static_cast<std::size_t>(i)] +
                     (plan.where.speed() ? Vec6(Vec6::Zero()) : s.command[static_cast<std::size_t>(i)]))
                        .transpose();
  const VectorXd what = whitened(hidden);
  const Calibration& k = lab.calibration;
  std::vector<VectorXd> known;
  for (const MatrixXd& c :
       calibration_columns(lab.flight.vehicle, s, std::max(1e-6, k.thrust_scale), std::max(1e-6, k.level),
                           std::max(1e-6, k.trim), k.accelerometer))
    known.push_back(whitened(c));
  for (const MatrixXd& c : untold_columns(lab.flight.vehicle, s)) known.push_back(whitened(c));
  out.judged = true;
  out.detect = beyond(what, {}, known);
  out.rival = out.detect;
  const std::string own = family_names(h.id, plan.where);
  for (const ColumnGroup& g : textbook_columns(lab.flight.vehicle, s)) {
    if (family_names(g.id, plan.where) == own) continue;
    if (std::find(h.along.begin(), h.along.end(), g.id) != h.along.end()) continue;
    std::vector<VectorXd> free;
    for (const MatrixXd& c : g.columns) free.push_back(whitened(c));
    const double left = beyond(what, free, known);
    if (left < out.rival) out.rival = left, out.nearest = g.id;
  }
  out.separable = out.rival >= kSeparable;
  return out;
}

}  // namespace omniflight::proof

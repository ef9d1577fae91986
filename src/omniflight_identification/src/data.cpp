#include "omniflight_identification/data.hpp"

#include <cmath>
#include <string>

namespace omniflight::identification {
namespace {

constexpr Eigen::Index kFewestSamples = 50, kMostSamples = 2'000'000, kMostInputs = 4;

Eigen::VectorXd without_trend(const Eigen::VectorXd& x, Trend trend) {
  if (trend == Trend::mean) return x.array() - x.mean();
  Eigen::MatrixXd basis(x.size(), 2);
  basis.col(0).setOnes();
  basis.col(1).setLinSpaced(-1.0, 1.0);
  return x - basis * basis.colPivHouseholderQr().solve(x);
}

}  // namespace

Eigen::Index Dataset::samples() const {
  Eigen::Index n = 0;
  for (const Experiment& e : experiments) n += e.y.size();
  return n;
}

Eigen::Index Dataset::inputs() const { return experiments.empty() ? 0 : experiments.front().u.cols(); }

Status check(const Dataset& data) {
  if (!(data.period_s > 0) || !std::isfinite(data.period_s))
    return bad_input("is " + std::to_string(data.period_s) + " s, must be more than 0", "sampling period");
  if (data.experiments.empty())
    return bad_input("there is no recording to identify from", "experiments", "Give at least one");
  const Eigen::Index inputs = data.inputs();
  if (inputs < 1 || inputs > kMostInputs)
    return bad_input("there are " + std::to_string(inputs) + " inputs, 1 to 4 are possible", "inputs");
  for (std::size_t k = 0; k < data.experiments.size(); ++k) {
    const Experiment& e = data.experiments[k];
    const std::string where = "experiment " + std::to_string(k + 1);
    if (e.y.size() < kFewestSamples || e.y.size() > kMostSamples)
      return bad_input("has " + std::to_string(e.y.size()) + " samples, 50 to 2000000 are possible", where,
                       "Record longer, or leave it out");
    if (e.u.rows() != e.y.size() || e.u.cols() != inputs)
      return bad_input("inputs and output differ in size", where);
    if (!e.y.allFinite() || !e.u.allFinite()) return bad_input("has samples that are not finite", where);
  }
  for (Eigen::Index i = 0; i < inputs; ++i) {
    bool moves = false;
    for (const Experiment& e : data.experiments)
      moves =
          moves || e.u.col(i).maxCoeff() - e.u.col(i).minCoeff() > 1e-9 * e.u.col(i).cwiseAbs().maxCoeff();
    if (!moves)
      return bad_input("is constant, so that nothing follows from it", "input " + std::to_string(i + 1),
                       i == 0 ? "Record a motor whose command moves, for instance a PRBS" : "Leave it out");
  }
  return {};
}

Dataset detrended(Dataset data, Trend trend) {
  for (Experiment& e : data.experiments) {
    e.y = without_trend(e.y, trend);
    for (Eigen::Index i = 0; i < e.u.cols(); ++i) e.u.col(i) = without_trend(e.u.col(i), trend);
  }
  return data;
}

std::pair<Dataset, Dataset> split(const Dataset& data, double share) {
  Dataset first{data.period_s, {}}, second{data.period_s, {}};
  for (const Experiment& e : data.experiments) {
    const auto n = static_cast<Eigen::Index>(share * static_cast<double>(e.y.size()));
    first.experiments.push_back({e.y.head(n), e.u.topRows(n)});
    second.experiments.push_back({e.y.tail(e.y.size() - n), e.u.bottomRows(e.y.size() - n)});
  }
  return {first, second};
}

}  // namespace omniflight::identification

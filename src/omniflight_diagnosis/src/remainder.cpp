#include "remainder.hpp"

namespace omniflight::diagnosis {
namespace {

/// Share of the effect's own energy, every channel in units of its noise, along the axis of a term.
double share_along(const Problem& problem, const Eigen::VectorXd& contribution, const Term& term) {
  const int n = problem.samples();
  double along = 0, all = 1e-300;
  for (int i = 0; i < n; ++i) {
    Vec6 w;
    for (int c = 0; c < 6; ++c) w[c] = contribution[c * n + i];
    const double value = term.world ? problem.situation(i).R_WB.row(term.channel).dot(w.head<3>().transpose())
                                    : w[term.channel];
    along += std::pow(value / problem.scale(term.channel), 2);
    for (int c = 0; c < 6; ++c) all += std::pow(w[c] / problem.scale(c), 2);
  }
  return along / all;
}

}  // namespace

std::vector<Term> terms_beside(const Problem& problem, const Naming& naming, const Options& o) {
  std::vector<Term> terms = select_terms(problem, naming.model.residual, o);
  const double crumb = 0.1 * (naming.model.log_likelihood - naming.null_model.log_likelihood);
  std::erase_if(terms, [&](const Term& t) { return t.gain < crumb; });
  return terms;
}

int weakest_name(const Problem& problem, const Naming& naming, const std::vector<Term>& terms) {
  constexpr double kEnough = 0.7, kOwnAxis = 0.2;
  int weakest = -1;
  double least = kEnough;
  for (std::size_t k = 0; k < naming.named.size(); ++k) {
    const Eigen::VectorXd own = contribution_of(problem, naming.model, k);
    double left = 0;
    for (const Term& t : terms)
      if (share_along(problem, own, t) > kOwnAxis) left += t.gain;
    const double gain = std::max(0.0, naming.named[k].gain), share = gain / std::max(1e-300, gain + left);
    if (share < least) least = share, weakest = static_cast<int>(k);
  }
  return weakest;
}

}  // namespace omniflight::diagnosis

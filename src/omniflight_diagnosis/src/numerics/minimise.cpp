#include "minimise.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace omniflight::diagnosis {

namespace {

/// One simplex, until it is flat; `spent` counts.
Minimum descend(const Objective& f, Minimum start, const Eigen::VectorXd& steps, double tolerance,
                int evaluations, int& spent) {
  const Eigen::Index n = start.at.size();
  std::vector<Minimum> corners{std::move(start)};
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::VectorXd at = corners.front().at;
    at[k] += steps[k];
    corners.push_back({at, f(at)});
  }
  spent += static_cast<int>(n);
  const auto less = [](const Minimum& a, const Minimum& b) { return a.value < b.value; };
  std::stable_sort(corners.begin(), corners.end(), less);
  while (spent < evaluations && !(corners.back().value - corners.front().value < tolerance)) {
    Eigen::VectorXd middle = Eigen::VectorXd::Zero(n);
    for (std::size_t k = 0; k + 1 < corners.size(); ++k)
      middle += corners[k].at / static_cast<double>(corners.size() - 1);
    const auto beyond = [&](double factor) {
      Minimum out{middle + factor * (corners.back().at - middle), 0};
      out.value = f(out.at);
      ++spent;
      return out;
    };
    Minimum next = beyond(-1);
    if (next.value < corners.front().value) {
      Minimum farther = beyond(-2);
      if (farther.value < next.value) next = std::move(farther);
    } else if (!(next.value < corners[corners.size() - 2].value)) {
      next = beyond(next.value < corners.back().value ? -0.5 : 0.5);
    }
    if (next.value < corners.back().value) {
      corners.back() = std::move(next);
    } else {  // towards the best corner
      for (std::size_t k = 1; k < corners.size(); ++k) {
        corners[k].at = 0.5 * (corners[k].at + corners[0].at);
        corners[k].value = f(corners[k].at);
        ++spent;
      }
    }
    std::stable_sort(corners.begin(), corners.end(), less);
  }
  return corners.front();
}

}  // namespace

Minimum minimise(const Objective& f, const Eigen::VectorXd& start, const Eigen::VectorXd& steps,
                 double tolerance, int evaluations) {
  int spent = 1;
  Minimum best{start, f(start)};
  while (spent < evaluations) {
    best = descend(f, std::move(best), steps, tolerance, evaluations, spent);
    // a simplex may have lost a direction: each is looked at once more, finely and coarsely
    bool better = false;
    for (Eigen::Index k = 0; k < start.size(); ++k)
      for (const double share : {1.0, -1.0, 0.1, -0.1}) {
        Eigen::VectorXd at = best.at;
        at[k] += share * steps[k];
        const double value = f(at);
        ++spent;
        if (!(value < best.value - tolerance)) continue;
        best = {std::move(at), value};
        better = true;
      }
    if (!better) break;
  }
  return best;
}

Eigen::MatrixXd curvature(const Objective& f, const Minimum& m, const Eigen::VectorXd& steps, double least) {
  const Eigen::Index n = m.at.size();
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd step = steps;
  const auto risen = [&](Eigen::Index k, double by) {
    Eigen::VectorXd at = m.at;
    at[k] += by;
    return f(at) - m.value;
  };
  for (Eigen::Index k = 0; k < n; ++k) {
    double rise = 0;
    for (int tries = 0; tries < 12; ++tries) {
      rise = 0.5 * (risen(k, step[k]) + risen(k, -step[k]));
      if (rise > 0.3 && rise < 3) break;
      step[k] *= rise >= 3 ? 0.5 : step[k] < 2 ? 2.0 : 1.0;
    }
    H(k, k) = std::isfinite(rise) ? std::max(least, 2 * rise / (step[k] * step[k]))
                                  : std::max(least, 1 / (step[k] * step[k]));
  }
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < i; ++j) {
      double mixed = 0;
      for (const double by_i : {step[i], -step[i]})
        for (const double by_j : {step[j], -step[j]}) {
          Eigen::VectorXd at = m.at;
          at[i] += by_i;
          at[j] += by_j;
          mixed += f(at) / (4 * by_i * by_j);
        }
      if (std::isfinite(mixed)) H(i, j) = H(j, i) = mixed;
    }
  // along a ridge the differences leave less than there is
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(H);
  H = axes.eigenvectors() * axes.eigenvalues().cwiseMax(least).asDiagonal() * axes.eigenvectors().transpose();
  return H;
}

}  // namespace omniflight::diagnosis

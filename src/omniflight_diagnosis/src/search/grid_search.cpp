#include "grid_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "parallel.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr std::size_t kReturned = 16;  ///< sets that are fitted in the second tier
constexpr std::size_t kSingles = 5;    ///< of them sets of one member

/// A hypothesis at one point of its grid: columns [begin, begin + size) of the matrix.
struct Block {
  int hypothesis = 0, point = 0;
  Eigen::Index begin = 0, size = 0;
  std::vector<char> half;  ///< amplitudes of one sign
};

class GridSearch {
 public:
  GridSearch(const Evidence& evidence, const SearchLimits& limits) : evidence_(evidence), limits_(limits) {
    Eigen::Index total = evidence.calibration_columns().cols();
    fixed_ = total;
    const auto& hypotheses = evidence.hypotheses();
    for (std::size_t h = 0; h < hypotheses.size(); ++h) {
      const auto add = [&](int point, const Eigen::MatrixXd& columns, std::vector<char> half) {
        if (columns.cols() == 0 || !columns.allFinite()) return;
        blocks_.push_back({static_cast<int>(h), point, total, columns.cols(), std::move(half)});
        total += columns.cols();
      };
      if (hypotheses[h].pattern) {
        add(-1, hypotheses[h].pattern->whitened, {});
        continue;
      }
      for (std::size_t p = 0; p < hypotheses[h].points.size(); ++p) {
        const ShapePoint& at = hypotheses[h].points[p];
        std::vector<char> half;
        for (const std::size_t k : at.amplitude)
          half.push_back(evidence.problem().prior(*hypotheses[h].effect, k).law ==
                         physics::ParameterPrior::Law::half_normal);
        add(static_cast<int>(p), at.columns, std::move(half));
      }
    }
    // single precision: inner products of unit-variance rows, of which the determinant is taken with + I
    Eigen::MatrixXf C(evidence.whitened_residual().size(), total);
    C.leftCols(fixed_) = evidence.calibration_columns().cast<float>();
    for (const Block& b : blocks_) C.middleCols(b.begin, b.size) = columns_of(b).cast<float>();
    gram_.resize(total, total);
    constexpr Eigen::Index kTile = 192;
    const auto tiles = static_cast<std::size_t>((total + kTile - 1) / kTile);
    parallel_for(tiles, limits.threads, [&](std::size_t t) {
      const auto first = static_cast<Eigen::Index>(t) * kTile;
      const Eigen::Index width = std::min(kTile, total - first);
      gram_.block(0, first, first + width, width).noalias() =
          C.leftCols(first + width).transpose() * C.middleCols(first, width);
    });
    for (Eigen::Index c = 0; c < total; ++c)
      for (Eigen::Index r = c + 1; r < total; ++r) gram_(r, c) = gram_(c, r);
    b_ = (C.transpose() * evidence.whitened_residual().cast<float>()).cast<double>();
  }

  std::vector<std::vector<SetMember>> run() {
    std::vector<State> beam{solve({})}, all;
    for (int size = 0; size < limits_.most_members; ++size) {
      if (limits_.stop && limits_.stop()) break;
      std::vector<std::vector<State>> found(beam.size());
      parallel_for(beam.size(), limits_.threads, [&](std::size_t k) { found[k] = extend(beam[k]); });
      std::vector<State> next;
      std::set<std::vector<int>> seen;
      for (auto& some : found)
        for (State& s : some)
          if (seen.insert(s.blocks).second) next.push_back(std::move(s));
      std::sort(next.begin(), next.end(), [](const State& a, const State& b) { return a.joint > b.joint; });
      const double best_so_far = beam.front().joint;
      if (next.size() > kBeam) next.resize(kBeam);
      for (std::size_t k = 0; k < next.size() && (size > 0 || k < kSingles); ++k) all.push_back(next[k]);
      if (next.empty() || next.front().joint < best_so_far - 1) break;
      beam = std::move(next);
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const State& a, const State& b) { return a.joint > b.joint; });
    std::vector<std::vector<SetMember>> out;
    std::set<std::vector<int>> named;
    const auto take = [&](const State& s) {
      std::vector<int> key;
      for (const int b : s.blocks) key.push_back(blocks_[static_cast<std::size_t>(b)].hypothesis);
      std::sort(key.begin(), key.end());
      if (named.insert(key).second) out.push_back(members_of(s));
    };
    for (const State& s : all)
      if (out.size() < kReturned - kSingles) take(s);
    for (const State& s : all)
      if (s.blocks.size() == 1) take(s);
    return out;
  }

 private:
  static constexpr std::size_t kBeam = 10, kChildren = 10;

  struct State {
    std::vector<int> blocks;  ///< sorted
    double joint = -1e300;
    std::vector<Eigen::Index> index;
    Eigen::MatrixXd precision;
    Eigen::VectorXd mean;
  };

  const Eigen::MatrixXd& columns_of(const Block& b) const {
    const Hypothesis& h = evidence_.hypotheses()[static_cast<std::size_t>(b.hypothesis)];
    return b.point < 0 ? h.pattern->whitened : h.points[static_cast<std::size_t>(b.point)].columns;
  }

  State solve(std::vector<int> blocks) const {
    State s;
    s.blocks = std::move(blocks);
    for (Eigen::Index k = 0; k < fixed_; ++k) s.index.push_back(k);
    std::vector<Eigen::Index> half;
    double prior = 0;
    for (const int at : s.blocks) {
      const Block& b = blocks_[static_cast<std::size_t>(at)];
      prior += evidence_.hypotheses()[static_cast<std::size_t>(b.hypothesis)].log_odds;
      // a grid point stands for its share of the prior of the shapes
      for (Eigen::Index k = 0; k < b.size; ++k) {
        if (static_cast<std::size_t>(k) < b.half.size() && b.half[static_cast<std::size_t>(k)])
          half.push_back(static_cast<Eigen::Index>(s.index.size()));
        s.index.push_back(b.begin + k);
      }
    }
    const auto n = static_cast<Eigen::Index>(s.index.size());
    s.precision.resize(n, n);
    Eigen::VectorXd b(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      b[i] = b_[s.index[static_cast<std::size_t>(i)]];
      for (Eigen::Index j = 0; j < n; ++j)
        s.precision(i, j) = gram_(s.index[static_cast<std::size_t>(i)], s.index[static_cast<std::size_t>(j)]);
      s.precision(i, i) += 1;
    }
    const Eigen::LLT<Eigen::MatrixXd> factor(s.precision);
    s.mean = factor.solve(b);
    double log_evidence = 0.5 * b.dot(s.mean) - factor.matrixLLT().diagonal().array().log().sum();
    if (!half.empty()) {
      const Eigen::MatrixXd covariance = factor.solve(Eigen::MatrixXd::Identity(n, n));
      for (const Eigen::Index k : half) {
        const double x = s.mean[k] / std::sqrt(covariance(k, k));
        log_evidence += std::log(2.0) + log_normal_cdf(x);
      }
    }
    s.joint = std::isfinite(log_evidence) ? log_evidence + prior : -1e300;
    return s;
  }

  std::vector<State> extend(const State& s) const {
    const Eigen::LLT<Eigen::MatrixXd> factor(s.precision);
    std::vector<std::pair<double, int>> promise;
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
      const Block& b = blocks_[k];
      const bool in = std::any_of(s.blocks.begin(), s.blocks.end(), [&](int other) {
        return blocks_[static_cast<std::size_t>(other)].hypothesis == b.hypothesis;
      });
      if (in) continue;
      Eigen::MatrixXd cross(static_cast<Eigen::Index>(s.index.size()), b.size);
      for (std::size_t i = 0; i < s.index.size(); ++i)
        cross.row(static_cast<Eigen::Index>(i)) =
            gram_.row(s.index[i]).segment(b.begin, b.size).cast<double>();
      Eigen::MatrixXd A = gram_.block(b.begin, b.begin, b.size, b.size).cast<double>();
      const Eigen::MatrixXd half = factor.matrixL().solve(cross);
      A -= half.transpose() * half;
      A.diagonal().array() += 1;
      const Eigen::VectorXd g = b_.segment(b.begin, b.size) - cross.transpose() * s.mean;
      const Eigen::LLT<Eigen::MatrixXd> own(A);
      const Eigen::VectorXd mean = own.solve(g);
      double gain = 0.5 * g.dot(mean) - own.matrixLLT().diagonal().array().log().sum();
      const Eigen::MatrixXd covariance = own.solve(Eigen::MatrixXd::Identity(b.size, b.size));
      for (std::size_t i = 0; i < b.half.size(); ++i)
        if (const auto at = static_cast<Eigen::Index>(i); b.half[i])
          gain += std::log(2.0) + log_normal_cdf(mean[at] / std::sqrt(covariance(at, at)));
      gain += evidence_.hypotheses()[static_cast<std::size_t>(b.hypothesis)].log_odds;
      if (std::isfinite(gain)) promise.emplace_back(gain, static_cast<int>(k));
    }
    std::sort(promise.rbegin(), promise.rend());
    std::vector<State> out;
    std::map<int, int> of_hypothesis;
    for (const auto& [gain, k] : promise) {
      if (out.size() >= kChildren || gain < -3) break;
      const int h = blocks_[static_cast<std::size_t>(k)].hypothesis;
      if (++of_hypothesis[h] > 1) continue;
      std::vector<int> blocks = s.blocks;
      blocks.insert(std::upper_bound(blocks.begin(), blocks.end(), k), k);
      out.push_back(solve(std::move(blocks)));
    }
    return out;
  }

  std::vector<SetMember> members_of(const State& s) const {
    std::vector<SetMember> out;
    Eigen::Index at = fixed_;
    for (const int k : s.blocks) {
      const Block& b = blocks_[static_cast<std::size_t>(k)];
      out.push_back(evidence_.member_at(b.hypothesis, b.point, s.mean.segment(at, b.size)));
      at += b.size;
    }
    return out;
  }

  const Evidence& evidence_;
  const SearchLimits& limits_;
  Eigen::Index fixed_ = 0;
  std::vector<Block> blocks_;
  Eigen::MatrixXf gram_;
  Eigen::VectorXd b_;
};

}  // namespace

std::vector<std::vector<SetMember>> promising_sets(const Evidence& evidence, const SearchLimits& limits) {
  return GridSearch(evidence, limits).run();
}

}  // namespace omniflight::diagnosis

#include "grid_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "../evidence/inner_products.hpp"
#include "../numerics/parallel.hpp"

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

}  // namespace

class GridSearch::Implementation {
 public:
  Implementation(const Evidence& evidence, const SearchLimits& limits)
      : evidence_(evidence), limits_(limits) {
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
        if (at.amplitude.empty()) half.push_back(true);
        add(static_cast<int>(p), at.columns, std::move(half));
      }
    }
    // single precision: inner products of unit-variance rows, of which the determinant is taken with + I
    columns_.resize(evidence.whitened_residual().size(), total);
    columns_.leftCols(fixed_) = evidence.calibration_columns().cast<float>();
    own_.resize(blocks_.size());
    slab_.resize(blocks_.size());
    parallel_for(blocks_.size(), limits.threads, [&](std::size_t k) {
      const Block& b = blocks_[k];
      auto part = columns_.middleCols(b.begin, b.size);
      part = columns_of(b).cast<float>();
      own_[k] = inner_products(part, part).cast<double>();
    });
    b_ = (columns_.transpose() * evidence.whitened_residual().cast<float>()).cast<double>();
    fixed_slab_ = inner_products(columns_.leftCols(fixed_), columns_, limits.threads);
  }

  std::vector<std::vector<SetMember>> run(Offered offered) {
    std::set<int> left_out;
    for (std::size_t h = 0; h < evidence_.hypotheses().size() && offered == Offered::laws; ++h)
      if (evidence_.hypotheses()[h].pattern) left_out.insert(static_cast<int>(h));
    std::vector<State> beam{solve({})}, all;
    for (int size = 0; size < limits_.most_members; ++size) {
      if (limits_.stop && limits_.stop()) break;
      std::vector<std::vector<State>> found(beam.size());
      for (const State& state : beam) prepare(state.blocks);
      parallel_for(beam.size(), limits_.threads,
                   [&](std::size_t k) { found[k] = extend(beam[k], left_out); });
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

  Additions additions(const SetFit& fit, Noise noise) const {
    std::set<int> taken;
    for (const SetMember& m : fit.members) taken.insert(m.hypothesis);
    const Eigen::Index shared = fit.calibration_columns->cols();
    Eigen::MatrixXf own(columns_.rows(), shared + fit.columns.cols());
    own << fit.calibration_columns->cast<float>(), fit.columns.cast<float>();
    const Eigen::MatrixXf slab = inner_products(own, columns_, limits_.threads);
    const Eigen::VectorXd left = (columns_.transpose() * fit.rest.cast<float>()).cast<double>();
    const Eigen::LLT<Eigen::MatrixXd> factor(fit.precision);
    std::vector<Promise> all = promises(slab, factor, left, taken);
    if (noise == Noise::own) {
      parallel_for(all.size(), limits_.threads, [&](std::size_t k) {
        const Block& b = blocks_[static_cast<std::size_t>(all[k].block)];
        const Eigen::VectorXf mean = all[k].mean.cast<float>();
        const Eigen::VectorXf moved =
            factor.solve((slab.middleCols(b.begin, b.size) * mean).cast<double>()).cast<float>();
        const Eigen::VectorXf less = columns_.middleCols(b.begin, b.size) * mean - own * moved;
        all[k].gain += evidence_.noise().gain_of_own_noise(fit.rest, fit.rest - less.cast<double>());
      });
      std::stable_sort(all.begin(), all.end(),
                       [](const Promise& x, const Promise& y) { return x.gain > y.gain; });
    }
    Additions out;
    for (const Promise& p : all) {
      const Block& b = blocks_[static_cast<std::size_t>(p.block)];
      const bool pattern = evidence_.hypotheses()[static_cast<std::size_t>(b.hypothesis)].pattern != nullptr;
      const auto begin = begin_.find(b.hypothesis);
      (pattern ? out.patterns : out.laws)
          .push_back({p.gain, begin != begin_.end() ? begin->second
                                                    : evidence_.member_at(b.hypothesis, b.point, p.mean)});
    }
    return out;
  }

  void begin_at(SetMember member) { begin_[member.hypothesis] = std::move(member); }

  std::vector<SetMember> points_of(int hypothesis, std::size_t most) const {
    const State nothing = solve({});
    const Eigen::LLT<Eigen::MatrixXd> factor(nothing.precision);
    const Eigen::VectorXd left = b_ - (fixed_slab_.transpose() * nothing.mean.cast<float>()).cast<double>();
    std::vector<Promise> all;
    for (std::size_t k = 0; k < blocks_.size(); ++k)
      if (blocks_[k].hypothesis == hypothesis) all.push_back(promise(k, fixed_slab_, factor, left));
    std::erase_if(all, [](const Promise& p) { return !std::isfinite(p.gain); });
    std::stable_sort(all.begin(), all.end(),
                     [](const Promise& x, const Promise& y) { return x.gain > y.gain; });
    std::vector<SetMember> out;
    for (std::size_t k = 0; k < std::min(most, all.size()); ++k)
      out.push_back(evidence_.member_at(hypothesis, blocks_[static_cast<std::size_t>(all[k].block)].point,
                                        all[k].mean));
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
    std::vector<std::pair<Eigen::Index, Eigen::Index>> missing;
    for (Eigen::Index i = 0; i < n; ++i) {
      b[i] = b_[s.index[static_cast<std::size_t>(i)]];
    }
    Eigen::Index row = 0;
    const auto put = [&](const Eigen::MatrixXf& slab) {
      for (Eigen::Index r = 0; r < slab.rows(); ++r, ++row)
        for (Eigen::Index j = 0; j < n; ++j)
          s.precision(row, j) = slab(r, s.index[static_cast<std::size_t>(j)]);
    };
    put(fixed_slab_);
    // the last block may be new: its inner products with the others are those of the others with it
    for (const int at : s.blocks) {
      const Eigen::MatrixXf& slab = slab_[static_cast<std::size_t>(at)];
      if (slab.size() > 0) {
        put(slab);
        continue;
      }
      const Block& own = blocks_[static_cast<std::size_t>(at)];
      s.precision.block(row, row, own.size, own.size) = own_[static_cast<std::size_t>(at)];
      missing.emplace_back(row, own.size);
      row += own.size;
    }
    for (const auto& [begin, size] : missing)
      for (Eigen::Index r = begin; r < begin + size; ++r)
        for (Eigen::Index c = 0; c < n; ++c)
          if (c < begin || c >= begin + size) s.precision(r, c) = s.precision(c, r);
    s.precision.diagonal().array() += 1;
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

  /// Inner products of these blocks with all columns, once each.
  void prepare(const std::vector<int>& blocks) {
    for (const int at : blocks) {
      const Block& b = blocks_[static_cast<std::size_t>(at)];
      Eigen::MatrixXf& slab = slab_[static_cast<std::size_t>(at)];
      if (slab.size() == 0)
        slab = inner_products(columns_.middleCols(b.begin, b.size), columns_, limits_.threads);
    }
  }

  struct Promise {
    double gain = 0;  ///< ln evidence plus ln prior that it adds
    int block = 0;
    Eigen::VectorXd mean;
  };
  /// What a block would add to a model whose columns have these inner products with all columns, this
  /// posterior precision, and leave these inner products with the residual.
  Promise promise(std::size_t k, const Eigen::MatrixXf& slab, const Eigen::LLT<Eigen::MatrixXd>& factor,
                  const Eigen::VectorXd& left) const {
    const Block& b = blocks_[k];
    const Eigen::MatrixXd half = factor.matrixL().solve(slab.middleCols(b.begin, b.size).cast<double>());
    Eigen::MatrixXd A = own_[k];
    A -= half.transpose() * half;
    A.diagonal().array() += 1;
    const Eigen::VectorXd g = left.segment(b.begin, b.size);
    const Eigen::LLT<Eigen::MatrixXd> own(A);
    Promise p;
    p.block = static_cast<int>(k);
    p.mean = own.solve(g);
    p.gain = 0.5 * g.dot(p.mean) - own.matrixLLT().diagonal().array().log().sum();
    const Eigen::MatrixXd covariance = own.solve(Eigen::MatrixXd::Identity(b.size, b.size));
    for (std::size_t i = 0; i < b.half.size(); ++i)
      if (const auto at = static_cast<Eigen::Index>(i); b.half[i])
        p.gain += std::log(2.0) + log_normal_cdf(p.mean[at] / std::sqrt(covariance(at, at)));
    p.gain += evidence_.hypotheses()[static_cast<std::size_t>(b.hypothesis)].log_odds;
    return p;
  }

  /// The same of each block outside `taken`: the best point of every hypothesis, the most promising first.
  std::vector<Promise> promises(const Eigen::MatrixXf& slab, const Eigen::LLT<Eigen::MatrixXd>& factor,
                                const Eigen::VectorXd& left, const std::set<int>& taken) const {
    std::map<int, Promise> best;
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
      const Block& b = blocks_[k];
      if (taken.contains(b.hypothesis)) continue;
      Promise p = promise(k, slab, factor, left);
      if (!std::isfinite(p.gain)) continue;
      const auto known = best.find(b.hypothesis);
      if (known == best.end() || known->second.gain < p.gain) best[b.hypothesis] = std::move(p);
    }
    std::vector<Promise> out;
    for (auto& [hypothesis, p] : best) out.push_back(std::move(p));
    std::stable_sort(out.begin(), out.end(),
                     [](const Promise& x, const Promise& y) { return x.gain > y.gain; });
    return out;
  }

  /// With one more member, none of `taken`.
  std::vector<State> extend(const State& s, std::set<int> taken) const {
    Eigen::MatrixXf slab(static_cast<Eigen::Index>(s.index.size()), columns_.cols());
    slab.topRows(fixed_) = fixed_slab_;
    Eigen::Index row = fixed_;
    for (const int at : s.blocks) {
      const Eigen::MatrixXf& own = slab_[static_cast<std::size_t>(at)];
      slab.middleRows(row, own.rows()) = own;
      row += own.rows();
      taken.insert(blocks_[static_cast<std::size_t>(at)].hypothesis);
    }
    const Eigen::VectorXd left = b_ - (slab.transpose() * s.mean.cast<float>()).cast<double>();
    std::vector<State> out;
    for (const Promise& p : promises(slab, Eigen::LLT<Eigen::MatrixXd>(s.precision), left, taken)) {
      if (out.size() >= kChildren || p.gain < -3) break;
      std::vector<int> blocks = s.blocks;
      blocks.insert(std::upper_bound(blocks.begin(), blocks.end(), p.block), p.block);
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
  Eigen::MatrixXf columns_;            ///< calibration, then all blocks
  Eigen::MatrixXf fixed_slab_;         ///< inner products of calibration with all columns
  std::vector<Eigen::MatrixXf> slab_;  ///< of a block with all columns; empty until it is needed
  std::vector<Eigen::MatrixXd> own_;   ///< of a block with itself
  Eigen::VectorXd b_;                  ///< of all columns with the residual
  std::map<int, SetMember> begin_;     ///< see GridSearch::begin_at()
};

GridSearch::GridSearch(const Evidence& evidence, const SearchLimits& limits)
    : implementation_(std::make_unique<Implementation>(evidence, limits)) {}
GridSearch::~GridSearch() = default;

std::vector<std::vector<SetMember>> GridSearch::promising_sets(Offered offered) {
  return implementation_->run(offered);
}

GridSearch::Additions GridSearch::additions(const SetFit& fit, Noise noise) const {
  return implementation_->additions(fit, noise);
}

void GridSearch::begin_at(SetMember member) { implementation_->begin_at(std::move(member)); }

std::vector<SetMember> GridSearch::points_of(int hypothesis, std::size_t most) const {
  return implementation_->points_of(hypothesis, most);
}

}  // namespace omniflight::diagnosis

// The columns of a problem under its noise, and what a step of a fit needs of them.
#include "problem.hpp"
#include "whitening.hpp"

namespace omniflight::diagnosis {

const Eigen::MatrixXd* Problem::kept(const physics::ActiveEffect& at, bool beside_inertia) const {
  if (beside_inertia) return nullptr;
  if (has_constant_columns(*at.effect)) return &constant(*at.effect).whitened;
  Bent* known = remembered(at);
  if (!known) return nullptr;
  if (known->whitened.size() == 0) known->whitened = noise_->apply(*this, known->columns);
  return &known->whitened;
}

Eigen::MatrixXd Problem::whitened(const std::vector<physics::ActiveEffect>& effects,
                                  const Eigen::MatrixXd& jacobian) const {
  const bool heavy = has_inertia(effects);
  Eigen::MatrixXd out(jacobian.rows(), jacobian.cols());
  Eigen::Index at = 0;
  for (const physics::ActiveEffect& e : effects) {
    const Eigen::Index own = e.effect->parameter_count();
    if (const Eigen::MatrixXd* known = kept(e, heavy))
      out.middleCols(at, own) = *known;
    else
      out.middleCols(at, own) = noise_->apply(*this, jacobian.middleCols(at, own));
    at += own;
  }
  out.rightCols(offsets_.cols()) = whitened_offsets_;
  return out;
}

namespace {

/// X'Y by single products, so that Y'X has the same bits.
Eigen::MatrixXd products_of(const Eigen::MatrixXd& X, const Eigen::MatrixXd& Y) {
  Eigen::MatrixXd out(X.cols(), Y.cols());
  for (Eigen::Index j = 0; j < Y.cols(); ++j)
    for (Eigen::Index i = 0; i < X.cols(); ++i) out(i, j) = X.col(i).dot(Y.col(j));
  return out;
}

}  // namespace

const Eigen::MatrixXd& Problem::product(const physics::Effect* left, const physics::Effect* right) const {
  const auto columns = [&](const physics::Effect* e) -> const Eigen::MatrixXd& {
    return e ? constant(*e).whitened : whitened_offsets_;
  };
  const std::pair key{left, right};
  auto known = products_.find(key);
  if (known == products_.end())
    known = products_.emplace(key, products_of(columns(left), columns(right))).first;
  return known->second;
}

Problem::NormalEquations Problem::normal_equations(const std::vector<physics::ActiveEffect>& effects,
                                                   const Eigen::MatrixXd& jacobian,
                                                   const Eigen::VectorXd& r) const {
  struct Block {
    const Eigen::MatrixXd* X;
    const physics::Effect* effect;  ///< null: the offsets
    bool constant;
    Eigen::Index at;
  };
  const bool heavy = has_inertia(effects);
  std::list<Eigen::MatrixXd> own;
  std::vector<Block> blocks;
  Eigen::Index at = 0;
  for (const physics::ActiveEffect& e : effects) {
    const Eigen::Index count = e.effect->parameter_count();
    const Eigen::MatrixXd* X = kept(e, heavy);
    if (!X) X = &own.emplace_back(noise_->apply(*this, jacobian.middleCols(at, count)));
    blocks.push_back({X, e.effect, !heavy && has_constant_columns(*e.effect), at});
    at += count;
  }
  blocks.push_back({&whitened_offsets_, nullptr, true, at});
  NormalEquations out{Eigen::MatrixXd(jacobian.cols(), jacobian.cols()), Eigen::VectorXd(jacobian.cols())};
  for (const Block& a : blocks) {
    out.g.segment(a.at, a.X->cols()) = a.X->transpose() * r;
    for (const Block& b : blocks) {
      if (b.at > a.at) break;
      auto block = out.H.block(a.at, b.at, a.X->cols(), b.X->cols());
      if (a.constant && b.constant)
        block = product(a.effect, b.effect);
      else
        block = products_of(*a.X, *b.X);
      if (b.at < a.at) out.H.block(b.at, a.at, b.X->cols(), a.X->cols()) = block.transpose();
    }
  }
  return out;
}

}  // namespace omniflight::diagnosis

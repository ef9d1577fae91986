#include "omniflight_planning/wrench_limits.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <limits>
#include <numeric>
#include <vector>

namespace omniflight::planning {
namespace {

using Generators = Eigen::MatrixXd;  // rank x n

/// Unit normals of all facets: each is orthogonal to rank - 1 independent generators.
std::vector<Eigen::VectorXd> facet_normals(const Generators& g) {
  const int rank = static_cast<int>(g.rows()), n = static_cast<int>(g.cols()), k = rank - 1;
  std::vector<Eigen::VectorXd> normals;
  std::vector<int> pick(static_cast<std::size_t>(k));
  std::iota(pick.begin(), pick.end(), 0);
  Eigen::MatrixXd chosen(rank, k);
  while (true) {
    for (int j = 0; j < k; ++j) chosen.col(j) = g.col(pick[static_cast<std::size_t>(j)]).normalized();
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(chosen);
    if (k == 0 || std::abs(qr.matrixR()(k - 1, k - 1)) > 1e-9) {
      const Eigen::VectorXd normal = Eigen::MatrixXd(qr.householderQ()).col(rank - 1);
      const bool known = std::any_of(normals.begin(), normals.end(), [&](const Eigen::VectorXd& other) {
        return std::abs(normal.dot(other)) > 1.0 - 1e-12;
      });
      if (!known) normals.push_back(normal);
    }
    int j = k - 1;
    while (j >= 0 && pick[static_cast<std::size_t>(j)] == n - k + j) --j;
    if (j < 0) return normals;
    ++pick[static_cast<std::size_t>(j)];
    for (int l = j + 1; l < k; ++l)
      pick[static_cast<std::size_t>(l)] = pick[static_cast<std::size_t>(l - 1)] + 1;
  }
}

}  // namespace

WrenchLimits::WrenchLimits(const vehicle::Vehicle& vehicle, double alpha)
    : alpha_(alpha), mass_(vehicle.mass), inertia_(vehicle.inertia), p_BBcm_(vehicle.center_of_mass) {
  const Eigen::VectorXd low = vehicle.lower_thrusts(), high = vehicle.upper_thrusts();
  const Eigen::Matrix<double, 6, Eigen::Dynamic> a = vehicle.allocation_matrix(alpha);
  middle_ = a * (0.5 * (low + high));
  Eigen::MatrixXd g = a * (0.5 * (high - low)).asDiagonal();
  // Torques are divided by a typical arm, so that the rank does not depend on the unit of length.
  Vec6 scale = Vec6::Ones();
  double arm = 0.0;
  for (const auto& rotor : vehicle.rotors) arm = std::max(arm, rotor.p_BR.norm());
  if (arm > 0.0) scale.tail<3>().setConstant(1.0 / arm);
  g = scale.asDiagonal() * g;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(g, Eigen::ComputeThinU);
  rank_ = 0;
  while (rank_ < svd.singularValues().size() && svd.singularValues()[rank_] > 1e-7 * svd.singularValues()[0])
    ++rank_;
  const Eigen::MatrixXd basis = svd.matrixU().leftCols(rank_);
  const Generators reduced = basis.transpose() * g;
  const auto normals = facet_normals(reduced);
  facets_.resize(static_cast<Eigen::Index>(normals.size()), 6);
  for (std::size_t f = 0; f < normals.size(); ++f) {
    const double reach = (normals[f].transpose() * reduced).cwiseAbs().sum();
    facets_.row(static_cast<Eigen::Index>(f)) = (basis * normals[f]).transpose() * scale.asDiagonal() / reach;
  }
  outside_ = (Mat6::Identity() - basis * basis.transpose()) * scale.asDiagonal();
}

double WrenchLimits::load(const Vec6& wrench_B) const {
  const Vec6 w = wrench_B - middle_;
  if (!w.allFinite()) return std::numeric_limits<double>::infinity();
  if (rank_ < 6 && (outside_ * w).norm() > 1e-6 * (1.0 + w.norm()))
    return std::numeric_limits<double>::infinity();
  return (facets_ * w).cwiseAbs().maxCoeff();
}

Vec6 WrenchLimits::required_wrench(const Reference& m) const {
  const Vec3 g_W(0.0, 0.0, -kGravity);
  const Vec3 acceleration_B = m.q_WB.conjugate() * (m.a_WB_W - g_W) + m.dw_WB_B.cross(p_BBcm_) +
                              m.w_WB_B.cross(m.w_WB_B.cross(p_BBcm_));
  Vec6 wrench;
  wrench.head<3>() = mass_ * acceleration_B;
  wrench.tail<3>() =
      inertia_ * m.dw_WB_B + m.w_WB_B.cross(inertia_ * m.w_WB_B) + p_BBcm_.cross(wrench.head<3>());
  return wrench;
}

double WrenchLimits::hover_load(const Quat& q_WB) const {
  Reference hover;
  hover.q_WB = q_WB;
  return motion_load(hover);
}

HoverCheck hover_check(const vehicle::Vehicle& vehicle, double headroom) {
  // The limits of the last tilt are kept; a mission asks for one tilt only.
  struct Memory {
    vehicle::Vehicle vehicle;
    std::unique_ptr<WrenchLimits> limits;
  };
  return [memory = std::make_shared<Memory>(Memory{vehicle, nullptr}), headroom](const Quat& q_WB,
                                                                                 double alpha) {
    if (!memory->limits || memory->limits->alpha() != alpha)
      memory->limits = std::make_unique<WrenchLimits>(memory->vehicle, alpha);
    return memory->limits->hover_load(q_WB) <= 1.0 - headroom;
  };
}

}  // namespace omniflight::planning

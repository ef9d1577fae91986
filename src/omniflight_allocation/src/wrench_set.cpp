#include "omniflight_allocation/wrench_set.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>

namespace omniflight::allocation {
namespace {

constexpr double kRankTolerance = 1e-9;  // of the largest singular value
constexpr double kMerge = 1e-9;          // of the reach
constexpr double kUnreachable = 1e-6;    // of a wrench: more of it outside the span counts

using Columns = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;
using Normal = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 6, 1>;

// Unit vector orthogonal to the given columns; false when they do not leave exactly one direction.
bool normal_to(const Columns& columns, double scale, Normal& normal) {
  const Eigen::Index r = columns.rows();
  if (columns.cols() == 0) {
    normal = Normal::Ones(1);
    return r == 1;
  }
  const Eigen::ColPivHouseholderQR<Columns> qr(columns);
  if (std::abs(qr.matrixR()(r - 2, r - 2)) <= kRankTolerance * scale) return false;
  normal = qr.householderQ() * Normal::Unit(r, r - 1);
  return true;
}

// The next subset of k out of n in lexicographic order.
bool next_subset(std::vector<int>& subset, int n) {
  const int k = static_cast<int>(subset.size());
  int i = k - 1;
  while (i >= 0 && subset[static_cast<std::size_t>(i)] == n - k + i) --i;
  if (i < 0) return false;
  ++subset[static_cast<std::size_t>(i)];
  for (int j = i + 1; j < k; ++j)
    subset[static_cast<std::size_t>(j)] = subset[static_cast<std::size_t>(j - 1)] + 1;
  return true;
}

}  // namespace

Result<WrenchSet> WrenchSet::create(const vehicle::Vehicle& v, double alpha, double f_max) {
  if (const Status ok = vehicle::validate(v); !ok) return Failure(ok.error());
  if (!std::isfinite(alpha)) return bad_input("tilt is not finite, rad", "alpha", "Give an angle");
  if (!(f_max >= 0) || !std::isfinite(f_max))
    return bad_input("largest thrust must be positive, or 0 for the vehicle's, N", "f_max",
                     "Give a positive thrust");
  const int n = v.rotor_count();
  vehicle::RotorVector lower = v.lower_thrusts(), upper = v.upper_thrusts();
  if (f_max > 0) {
    for (int i = 0; i < n; ++i) {
      upper[i] = f_max;
      if (v.rotors[static_cast<std::size_t>(i)].bidirectional) lower[i] = -f_max;
      if (lower[i] >= f_max)
        return bad_input("largest thrust is not above the smallest thrust of rotor " + std::to_string(i + 1),
                         "f_max", "Give a larger thrust in N");
    }
  }
  WrenchSet s;
  vehicle::AllocationMatrix B = v.allocation_matrix(alpha);
  double lever = 0.0;
  for (int i = 0; i < n; ++i) {
    B.block<3, 1>(3, i) -= v.center_of_mass.cross(B.block<3, 1>(0, i));
    lever = std::max(lever, B.block<3, 1>(3, i).norm());
  }
  if (lever > 0) s.lever_ = lever;
  B.bottomRows<3>() /= s.lever_;
  const Eigen::MatrixXd generators = B * (0.5 * (upper - lower)).asDiagonal();
  s.centre_ = B * (0.5 * (upper + lower));
  s.reach_ = generators.colwise().norm().sum() + s.centre_.norm();

  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(generators, Eigen::ComputeFullU);
  const double largest = svd.singularValues()[0];
  for (Eigen::Index i = 0; i < svd.singularValues().size(); ++i)
    s.rank_ += svd.singularValues()[i] > kRankTolerance * largest;
  s.span_ = svd.matrixU().leftCols(s.rank_);
  const Eigen::MatrixXd inner = s.span_.transpose() * generators;

  std::vector<int> subset(static_cast<std::size_t>(s.rank_ - 1));
  for (std::size_t i = 0; i < subset.size(); ++i) subset[i] = static_cast<int>(i);
  std::vector<Vec6> normals;
  do {
    Normal inner_normal;
    if (!normal_to(inner(Eigen::all, subset), largest, inner_normal)) continue;
    const Vec6 normal = s.span_ * inner_normal;
    bool known = false;
    for (const Vec6& o : normals)
      known = known || std::min((normal - o).squaredNorm(), (normal + o).squaredNorm()) < 1e-18;
    if (!known) normals.push_back(normal);
  } while (next_subset(subset, n));
  Vec6 scale = Vec6::Ones();
  scale.tail<3>() /= s.lever_;
  s.loads_.resize(static_cast<Eigen::Index>(normals.size()), 6);
  s.outside_ = (Mat6::Identity() - s.span_ * s.span_.transpose()) * scale.asDiagonal();
  for (const Vec6& normal : normals) {
    const double half_width = (normal.transpose() * generators).cwiseAbs().sum(),
                 middle = normal.dot(s.centre_);
    s.loads_.row(static_cast<Eigen::Index>(s.faces_.size() / 2)) =
        normal.cwiseProduct(scale).transpose() / half_width;
    s.faces_.push_back({normal, middle + half_width});
    s.faces_.push_back({-normal, -middle + half_width});
  }
  Vec6 middle = s.centre_;
  middle.tail<3>() *= s.lever_;
  s.load_of_none_ = -s.loads_ * middle;
  return s;
}

double WrenchSet::load(const Vec6& wrench) const {
  Vec6 w = wrench;
  w.head<3>() -= centre_.head<3>();
  w.tail<3>() -= lever_ * centre_.tail<3>();
  if (!w.allFinite()) return HUGE_VAL;
  if (rank_ < 6 && (outside_ * w).norm() > kUnreachable * (reach_ + w.norm())) return HUGE_VAL;
  return (loads_ * w).cwiseAbs().maxCoeff();
}

double WrenchSet::load_of_force(const Vec3& force) const {
  if (rank_ < 6 || !force.allFinite()) {
    Vec6 wrench = Vec6::Zero();
    wrench.head<3>() = force;
    return load(wrench);
  }
  return (loads_.leftCols<3>().lazyProduct(force) + load_of_none_).cwiseAbs().maxCoeff();
}

double WrenchSet::load_slope_of_force() const {
  return rank_ < 6 ? HUGE_VAL : loads_.leftCols<3>().rowwise().norm().maxCoeff();
}

WrenchSet::Slice WrenchSet::slice(Part shown, const Vec3& fixed_value) const {
  Slice out;
  if (!fixed_value.allFinite()) return out;
  const Eigen::MatrixXd shown_rows = shown == Part::force ? span_.topRows<3>() : span_.bottomRows<3>();
  const Eigen::MatrixXd fixed_rows = shown == Part::force ? span_.bottomRows<3>() : span_.topRows<3>();
  // wrench = centre + span y with the fixed part held: y = y0 + N z
  const Vec3 rest = fixed_value - (shown == Part::force ? centre_.tail<3>() : centre_.head<3>());
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(fixed_rows, Eigen::ComputeFullU | Eigen::ComputeFullV);
  int fixed_rank = 0;
  for (Eigen::Index i = 0; i < svd.singularValues().size(); ++i)
    fixed_rank += svd.singularValues()[i] > kRankTolerance;
  Eigen::VectorXd y0 = Eigen::VectorXd::Zero(rank_);
  for (int i = 0; i < fixed_rank; ++i)
    y0 += svd.matrixV().col(i) * (svd.matrixU().col(i).dot(rest) / svd.singularValues()[i]);
  if ((fixed_rows * y0 - rest).norm() > kMerge * reach_) return out;
  const Eigen::MatrixXd N = svd.matrixV().rightCols(rank_ - fixed_rank);
  out.empty = false;
  const Vec6 at = centre_ + span_ * y0;
  out.flat.origin = shown == Part::force ? at.head<3>() : at.tail<3>();
  // the fixed part does not change along N, so the shown part of span N is orthonormal
  out.flat.basis = shown_rows * N;
  const Eigen::MatrixXd directions = span_ * N;
  for (const Face& face : faces_) {
    const Vec3 a = out.flat.basis * (directions.transpose() * face.normal);
    const double b = face.offset - face.normal.dot(at), length = a.norm();
    if (length > kRankTolerance)
      out.half_spaces.push_back({a / length, b / length + (a / length).dot(out.flat.origin)});
    else if (b < -kMerge * reach_)
      out.empty = true;
  }
  return out;
}

Polytope WrenchSet::body(const Slice& s, double scale) const {
  if (s.empty) return {};
  Polytope out = intersect(s.flat, s.half_spaces, 2.0 * reach_, kMerge * reach_);
  for (HalfSpace& h : out.facets) h.offset *= scale;
  for (Vec3& v : out.vertices) v *= scale;
  return out;
}

Polytope WrenchSet::force_at_torque(const Vec3& torque) const {
  return body(slice(Part::force, torque / lever_), 1.0);
}

Polytope WrenchSet::torque_at_force(const Vec3& force) const {
  return body(slice(Part::torque, force), lever_);
}

Polytope WrenchSet::torque_at_any_attitude(double weight) const {
  // a face n_f . f + n_t . t <= h must hold for every f of length weight: n_t . t <= h - weight |n_f|
  if (rank_ < 6 || !(weight >= 0) || !std::isfinite(weight)) return {};
  Slice s;
  s.empty = false;
  for (const Face& face : faces_) {
    const Vec3 a = face.normal.tail<3>();
    const double b = face.offset - weight * face.normal.head<3>().norm(), length = a.norm();
    if (length > kRankTolerance)
      s.half_spaces.push_back({a / length, b / length});
    else if (b < 0)
      return {};
  }
  return body(s, lever_);
}

double WrenchSet::omnidirectional_force() const {
  const Slice s = slice(Part::force, Vec3::Zero());
  if (s.empty || s.flat.basis.cols() < 3) return 0.0;
  double nearest = HUGE_VAL;
  for (const HalfSpace& h : s.half_spaces) nearest = std::min(nearest, h.offset);
  return std::max(nearest, 0.0);
}

}  // namespace omniflight::allocation

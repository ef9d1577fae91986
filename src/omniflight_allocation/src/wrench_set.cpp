#include "omniflight_allocation/wrench_set.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>

namespace omniflight::allocation {
namespace {

constexpr double kRankTolerance = 1e-9;  // of the largest singular value
constexpr double kMerge = 1e-9;          // of the reach
constexpr double kUnreachable = 1e-6;    // of a wrench: more of it outside the span counts

constexpr double kClearlyFullRank = 1e-6;  // of pivots: implies kRankTolerance of singular values
constexpr double kAlike = 1e-12;           // of the cosine: worth a closer look
constexpr Eigen::Index kLane = 4;          // rows of loads are padded to a multiple

using Basis = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;
using Columns =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, vehicle::kMaxRotors>;

/// The directions that are orthogonal to all but one dimension of a span's generators, each once: unit
/// vectors without regard to sign. Every choice of generators is one Householder reflection away from that
/// with one generator less.
class Normals {
 public:
  /// columns: the generators in the coordinates of `span`, whose columns are orthonormal; no longer ones than
  /// `least` count as dependent.
  Normals(const Basis& span, const Columns& columns, double least) : least_(least) { choose(span, columns); }

  const std::vector<Vec6>& all() const { return all_; }

 private:
  /// basis: of what is orthogonal to the generators that are chosen; columns: those that may follow, in its
  /// coordinates.
  void choose(const Basis& basis, const Columns& columns) {
    const Eigen::Index d = basis.cols(), n = columns.cols();
    if (d == 1) return add(basis.col(0));
    for (Eigen::Index i = 0; i + d - 1 <= n; ++i) {
      const double length = columns.col(i).norm();
      if (length <= least_) continue;
      if (d == 2) {
        add(basis.lazyProduct(Eigen::Vector2d(-columns(1, i), columns(0, i)) / length));
        continue;
      }
      Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 6, 1> mirror = columns.col(i);
      mirror[0] += mirror[0] < 0.0 ? -length : length;
      const double scale = 2.0 / mirror.squaredNorm();
      Basis next(6, d - 1);
      const Vec6 out = scale * basis.lazyProduct(mirror);
      for (Eigen::Index k = 1; k < d; ++k) next.col(k - 1) = basis.col(k) - mirror[k] * out;
      Columns later(d - 1, n - i - 1);
      for (Eigen::Index k = i + 1; k < n; ++k) {
        const double along = scale * mirror.dot(columns.col(k));
        later.col(k - i - 1) = columns.col(k).tail(d - 1) - along * mirror.tail(d - 1);
      }
      choose(next, later);
    }
  }

  void add(const Vec6& normal) {
    for (const Vec6& o : all_) {
      const double cosine = normal.dot(o);
      if (std::abs(cosine) < 1.0 - kAlike) continue;
      if ((normal - std::copysign(1.0, cosine) * o).squaredNorm() < 1e-18) return;
    }
    all_.push_back(normal);
  }

  double least_;
  std::vector<Vec6> all_;
};

/// The largest magnitude in A w + c, where A has whole lanes of rows.
template <int kColumns, class Constant>
double largest_magnitude(const Eigen::Matrix<double, Eigen::Dynamic, 6>& A,
                         const Eigen::Matrix<double, kColumns, 1>& w, const Constant& constant) {
  using Lane = Eigen::Array<double, kLane, 1>;
  Lane most = Lane::Zero();
  for (Eigen::Index i = 0; i < A.rows(); i += kLane) {
    Lane sum = constant(i);
    for (int k = 0; k < kColumns; ++k) sum += A.col(k).segment<kLane>(i).array() * w[k];
    most = most.max(sum.abs());
  }
  return most.maxCoeff();
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
  const Generators generators = B * (0.5 * (upper - lower)).asDiagonal();
  s.centre_ = B * (0.5 * (upper + lower));
  s.reach_ = generators.colwise().norm().sum() + s.centre_.norm();
  const double largest = s.find_span(generators);

  const Columns inner = s.rank_ == 6 ? Columns(generators) : Columns(s.span_.transpose() * generators);
  const Normals found(s.span_, inner, kRankTolerance * largest);
  const std::vector<Vec6>& normals = found.all();
  Vec6 scale = Vec6::Ones();
  scale.tail<3>() /= s.lever_;
  s.loads_.setZero((static_cast<Eigen::Index>(normals.size()) + kLane - 1) / kLane * kLane, 6);
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

double WrenchSet::find_span(const Generators& generators) {
  const Eigen::ColPivHouseholderQR<Generators> qr(generators);
  const auto pivot = [&](Eigen::Index i) { return std::abs(qr.matrixQR()(i, i)); };
  if (generators.cols() >= 6 && pivot(5) > kClearlyFullRank * pivot(0)) {
    rank_ = 6;
    span_ = Mat6::Identity();
    return generators.norm();
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(generators, Eigen::ComputeFullU);
  const double largest = svd.singularValues()[0];
  for (Eigen::Index i = 0; i < svd.singularValues().size(); ++i)
    rank_ += svd.singularValues()[i] > kRankTolerance * largest;
  span_ = svd.matrixU().leftCols(rank_);
  return largest;
}

double WrenchSet::load(const Vec6& wrench) const {
  Vec6 w = wrench;
  w.head<3>() -= centre_.head<3>();
  w.tail<3>() -= lever_ * centre_.tail<3>();
  if (!w.allFinite()) return HUGE_VAL;
  if (rank_ < 6 && (outside_ * w).norm() > kUnreachable * (reach_ + w.norm())) return HUGE_VAL;
  return largest_magnitude<6>(loads_, w, [](Eigen::Index) { return Eigen::Array<double, kLane, 1>::Zero(); });
}

double WrenchSet::load_of_force(const Vec3& force) const {
  if (rank_ < 6 || !force.allFinite()) {
    Vec6 wrench = Vec6::Zero();
    wrench.head<3>() = force;
    return load(wrench);
  }
  return largest_magnitude<3>(loads_, force,
                              [&](Eigen::Index i) { return load_of_none_.segment<kLane>(i).array(); });
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

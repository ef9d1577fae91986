#include "omniflight_allocation/actuation.hpp"

#include <Eigen/SVD>
#include <cstdio>

#include "omniflight_allocation/rotor_load.hpp"
#include "omniflight_allocation/wrench_set.hpp"
#include "scaled_matrix.hpp"

namespace omniflight::allocation {
namespace {

using Matrix = Eigen::MatrixXd;

constexpr double kActuationRankTolerance = 1e-9;  // of the largest singular value, as in WrenchSet
constexpr double kLooseRank = 1e-6;               // where a minimum over the tilt counts as zero
constexpr int kAzimuths = 24;                     // directions of lean
constexpr double kStep = kPi / 180.0;

int rank_of(const Matrix& m, double tolerance = kActuationRankTolerance) {
  if (m.size() == 0) return 0;
  const Eigen::VectorXd s = Eigen::JacobiSVD<Matrix>(m).singularValues();
  return static_cast<int>((s.array() > tolerance * s[0]).count());
}

/// Singular value number `rank` over the largest; 0 with fewer rotors.
double smallest_share(const vehicle::Vehicle& v, double alpha, int rank) {
  const Eigen::VectorXd s = Eigen::JacobiSVD<Matrix>(scaled_matrix(v, alpha)).singularValues();
  return rank < 1 || s.size() < rank ? 0.0 : s[rank - 1] / s[0];
}

/// Share of the rotors' range that carries the weight with `up_B` upward.
double hover_load(const RotorLoad& rotors, const Vec3& up_B) {
  return rotors.hover_load(shortest_rotation(up_B, Vec3::UnitZ()));
}

/// The load is convex along a ray of forces: from its lowest place it rises to 1 once.
double largest_force(const RotorLoad& rotors, const vehicle::Vehicle& v, const Vec3& up_B) {
  const auto load = [&](double newton) {
    Vec6 wrench;
    wrench << newton * up_B, v.center_of_mass.cross(newton * up_B);
    return rotors.load(wrench);
  };
  double low = 0.0, high = v.upper_thrusts().sum();
  double a = low, b = high;
  for (int i = 0; i < 60; ++i) {
    const double x = a + (b - a) / 3, y = b - (b - a) / 3;
    (load(x) <= load(y) ? b : a) = load(x) <= load(y) ? y : x;
  }
  low = 0.5 * (a + b);
  if (!(load(low) <= 1.0)) return 0.0;
  for (int i = 0; i < 60; ++i) (load(0.5 * (low + high)) <= 1.0 ? low : high) = 0.5 * (low + high);
  return low;
}

/// Largest lean [rad] up to which the weight is carried whatever the direction of the lean.
double lean_limit(const RotorLoad& rotors, const Vec3& up_B) {
  const Vec3 x = up_B.unitOrthogonal(), y = up_B.cross(x);
  double least = kPi;
  for (int k = 0; k < kAzimuths; ++k) {
    const double azimuth = 2.0 * kPi * k / kAzimuths;
    const Vec3 side = std::cos(azimuth) * x + std::sin(azimuth) * y;
    const auto holds = [&](double lean) {
      return hover_load(rotors, std::cos(lean) * up_B + std::sin(lean) * side) <= 1.0;
    };
    double good = 0.0;
    while (good < least && holds(std::min(least, good + kStep))) good = std::min(least, good + kStep);
    if (good >= least) continue;
    double bad = good + kStep;
    for (int i = 0; i < 20; ++i) (holds(0.5 * (good + bad)) ? good : bad) = 0.5 * (good + bad);
    least = good;
  }
  return least < 1e-6 ? 0.0 : least;
}

/// The one direction of force where there is one, else the body axis or mean rotor axis that lifts most.
Vec3 thrust_axis(const RotorLoad& rotors, const vehicle::Vehicle& v, const Matrix& forces, int force_rank) {
  std::vector<Vec3> candidates;
  if (force_rank == 1) {
    const Vec3 axis = Eigen::JacobiSVD<Matrix>(forces, Eigen::ComputeFullU).matrixU().col(0);
    candidates = {axis, -axis};
    for (Vec3& c : candidates) c = (c.array().abs() < 1e-12).select(0.0, c);
  } else {
    Vec3 mean = Vec3::Zero();
    for (int i = 0; i < v.rotor_count(); ++i) mean += v.rotor_axis(i, rotors.alpha());
    if (mean.norm() > 1e-6) candidates.push_back(mean.normalized());
    for (const double sign : {1.0, -1.0})
      for (const Vec3& axis : {Vec3(Vec3::UnitZ()), Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY())})
        candidates.push_back(sign * axis);
  }
  Vec3 best = candidates.front();
  double most = -1.0;
  for (const Vec3& axis : candidates) {
    const double force = largest_force(rotors, v, axis);
    // of equals, the one that points up in the body: rotors that turn both ways lift either way
    if (force > most * (1 + 1e-6) || (force > most * (1 - 1e-6) && axis.z() > best.z() + 1e-6))
      most = force, best = axis;
  }
  return best;
}

std::string name_of(const Vec6& direction) {
  const bool torque = direction.tail<3>().norm() > direction.head<3>().norm();
  const Vec3 v = (torque ? direction.tail<3>() : direction.head<3>()).normalized();
  for (int k = 0; k < 3; ++k)
    if (std::abs(v[k]) > 0.999) return std::string(torque ? "torque about " : "force along ") + "xyz"[k];
  char text[80];
  std::snprintf(text, sizeof text, "%s (%.2f, %.2f, %.2f)", torque ? "torque about" : "force along", v.x(),
                v.y(), v.z());
  return text;
}

/// Words for a subspace of wrenches: body axes where they span it, else the vectors of its basis.
std::string names_of(const Matrix& basis) {
  std::vector<std::string> axes, vectors;
  for (int k = 0; k < 6; ++k)
    if (basis.row(k).norm() > 0.999) axes.push_back(name_of(Vec6::Unit(k)));
  for (Eigen::Index k = 0; k < basis.cols(); ++k) vectors.push_back(name_of(basis.col(k)));
  std::string out;
  for (const std::string& name : static_cast<Eigen::Index>(axes.size()) == basis.cols() ? axes : vectors)
    out += (out.empty() ? "" : ", ") + name;
  return out;
}

/// The place of the smallest share between two tilts, by golden section.
double minimum_between(const vehicle::Vehicle& v, int rank, double a, double b) {
  constexpr double kGolden = 0.6180339887498949;
  double x = b - kGolden * (b - a), y = a + kGolden * (b - a);
  double fx = smallest_share(v, x, rank), fy = smallest_share(v, y, rank);
  while (b - a > 1e-9) {
    if (fx < fy) {
      b = y, y = x, fy = fx;
      x = b - kGolden * (b - a), fx = smallest_share(v, x, rank);
    } else {
      a = x, x = y, fx = fy;
      y = a + kGolden * (b - a), fy = smallest_share(v, y, rank);
    }
  }
  return 0.5 * (a + b);
}

std::vector<SingularTilt> singular_tilts(const vehicle::Vehicle& v, const std::vector<double>& alphas) {
  std::vector<SingularTilt> out;
  int rank = 0;  // of nearly all tilts
  for (const double alpha : alphas) rank = std::max(rank, rank_of(scaled_matrix(v, alpha), kLooseRank));
  std::vector<double> share;
  for (const double alpha : alphas) share.push_back(smallest_share(v, alpha, rank));
  for (std::size_t i = 0; i < alphas.size(); ++i) {
    const bool falls = i == 0 || share[i] <= share[i - 1],
               rises = i + 1 == alphas.size() || share[i] <= share[i + 1];
    if (!falls || !rises) continue;
    const double at =
        minimum_between(v, rank, alphas[i == 0 ? 0 : i - 1], alphas[std::min(i + 1, alphas.size() - 1)]);
    const Matrix B = scaled_matrix(v, at);
    if (smallest_share(v, at, rank) > kLooseRank) continue;
    SingularTilt s;
    s.alpha = std::abs(at) < 1e-8 ? 0.0 : at;
    s.rank = rank_of(B, kLooseRank);
    // what the thrusts that give nothing here give beside it, beyond what there is here
    const Eigen::JacobiSVD<Matrix> svd(B, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Matrix null = svd.matrixU().rightCols(6 - s.rank);
    const Matrix idle = svd.matrixV().rightCols(B.cols() - s.rank);
    const double beside = at + (at + kStep <= alphas.back() ? kStep : -kStep);
    const Matrix more = null * (null.transpose() * scaled_matrix(v, beside) * idle);
    const Matrix lost = Eigen::JacobiSVD<Matrix>(more, Eigen::ComputeFullU).matrixU().leftCols(rank - s.rank);
    s.lost_B = lost.col(0);
    s.lost = names_of(lost);
    out.push_back(s);
  }
  return out;
}

}  // namespace

const char* to_string(ActuationKind kind) {
  switch (kind) {
    case ActuationKind::omnidirectional:
      return "omnidirectional";
    case ActuationKind::fully_actuated:
      return "fully actuated";
    case ActuationKind::underactuated:
      return "underactuated";
    case ActuationKind::restricted:
      return "forces in a plane";
    case ActuationKind::no_full_torque:
      return "no full torque";
  }
  return "unknown";
}

Result<ActuationAtTilt> actuation_at(const vehicle::Vehicle& v, double alpha) {
  const auto set = WrenchSet::create(v, alpha);
  if (!set) return Failure(set.error());
  const auto rotors = RotorLoad::create(v, alpha);
  if (!rotors) return Failure(rotors.error());
  const Matrix B = scaled_matrix(v, alpha);
  ActuationAtTilt a;
  a.alpha = alpha;
  a.rank = rank_of(B);
  // forces that leave the torque zero: F N with N the null space of the torque rows
  const Eigen::JacobiSVD<Matrix> torque(B.bottomRows<3>(), Eigen::ComputeFullV);
  const int torque_rank = static_cast<int>(
      (torque.singularValues().array() > kActuationRankTolerance * torque.singularValues()[0]).count());
  const Matrix forces = B.topRows<3>() * torque.matrixV().rightCols(B.cols() - torque_rank);
  a.force_rank = a.rank - torque_rank;
  a.thrust_axis_B = thrust_axis(*rotors, v, forces, a.force_rank);
  a.hover_load = hover_load(*rotors, a.thrust_axis_B);
  a.thrust_to_weight = largest_force(*rotors, v, a.thrust_axis_B) / (v.mass * kGravity);
  if (a.hovers() && a.force_rank > 1) a.lean = lean_limit(*rotors, a.thrust_axis_B);
  if (a.rank == 6)
    a.kind = set->omnidirectional_force() >= v.mass * kGravity ? ActuationKind::omnidirectional
                                                               : ActuationKind::fully_actuated;
  else if (torque_rank < 3 || a.force_rank == 0)
    a.kind = ActuationKind::no_full_torque;
  else
    a.kind = a.force_rank == 1 ? ActuationKind::underactuated : ActuationKind::restricted;
  return a;
}

Result<ActuationClass> classify_actuation(const vehicle::Vehicle& v) {
  const bool tilts = v.tilt.kind != vehicle::TiltKind::none && v.tilt.max > v.tilt.min;
  std::vector<double> alphas{tilts ? v.tilt.min : 0.0};
  while (tilts && alphas.back() < v.tilt.max - 1e-9)
    alphas.push_back(std::min(v.tilt.max, v.tilt.min + static_cast<double>(alphas.size()) * kStep));
  ActuationClass out;
  out.individual = v.tilt.kind == vehicle::TiltKind::individual;
  for (const double alpha : alphas) {
    auto a = actuation_at(v, alpha);
    if (!a) return Failure(a.error());
    out.tilts.push_back(std::move(*a));
  }
  if (tilts) out.singular = singular_tilts(v, alphas);
  return out;
}

const ActuationAtTilt& ActuationClass::strongest() const {
  return *std::max_element(tilts.begin(), tilts.end(), [](const auto& a, const auto& b) {
    return a.thrust_to_weight < b.thrust_to_weight;
  });
}

std::string ActuationClass::range(std::size_t first, std::size_t last) const {
  if (tilts.size() < 2) return {};
  char text[100];
  if (last > first)
    std::snprintf(text, sizeof text, " from %.3g to %.3g deg", to_degrees(tilts[first].alpha),
                  to_degrees(tilts[last].alpha));
  else
    std::snprintf(text, sizeof text, " at %.3g deg", to_degrees(tilts[first].alpha));
  return text;
}

std::string ActuationClass::words() const {
  std::string out;
  char text[200];
  for (std::size_t i = 0; i < tilts.size();) {
    std::size_t last = i;
    const auto same = [&](const ActuationAtTilt& t) {
      return t.kind == tilts[i].kind && t.hovers() == tilts[i].hovers();
    };
    while (last + 1 < tilts.size() && same(tilts[last + 1])) ++last;
    const ActuationAtTilt& t = tilts[i];
    out +=
        (out.empty() ? "" : ", ") + std::string(t.hovers() ? "" : "too heavy to hover, ") + to_string(t.kind);
    if (t.kind == ActuationKind::underactuated) {
      std::snprintf(text, sizeof text, " (thrust along %.2f %.2f %.2f)", t.thrust_axis_B.x(),
                    t.thrust_axis_B.y(), t.thrust_axis_B.z());
      out += text;
    }
    out += range(i, last);
    i = last + 1;
  }
  for (const SingularTilt& s : singular) {
    std::snprintf(text, sizeof text, "; at %.2f deg rank %d, without ", to_degrees(s.alpha), s.rank);
    out += text + s.lost;
  }
  if (individual) out += "; all of it at a common tilt, the rotors tilt one by one";
  return out;
}

}  // namespace omniflight::allocation

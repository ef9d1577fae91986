#include "omniflight_physics/cable_chain.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::physics {
namespace {

constexpr double kFloorRate = 400;  // rad/s, sqrt(stiffness/mass) of a node on the floor
constexpr double kFloorDamping = 0.7;
constexpr double kSlipSpeed = 0.01;  // m/s, friction grows up to here
constexpr double kTolerance = 1e-8;  // of a link's length
constexpr double kLift = 0.1;        // of a link: so high its lower end has left the floor
constexpr double kMost = 0.98;       // of a link may belong to one end: a node without mass has no motion
constexpr double kHeap = 0.05;       // of a link, radius of a heap
constexpr int kRounds = 3;           // of the search for the links that pull
constexpr int kArraysOfWork = 13;

/// The step in progress; index 0 is the upper end, index i the node below link i.
struct Work {
  double *w_xy, *w_z;         // inverse masses, horizontal and vertical
  double *nx, *ny, *nz;       // direction of link i, from node i-1 to i
  double *gap, *off, *pivot;  // how much link i is too long; tridiagonal system
  double *multiplier, *sum;   // of this iteration; of the whole step
  double* pulls;              // 1 where link i pulls
  double *mass, *weight;      // m, length of cable that moves with a node, and that hangs from it
};

Work workspace(double* work, int nodes) {
  const auto part = [&](int k) { return work + k * (nodes + 2); };
  return {part(0), part(1), part(2), part(3),  part(4),  part(5), part(6),
          part(7), part(8), part(9), part(10), part(11), part(12)};
}

/// Length [m] of the link from node i-1 to node i that its higher end has from the floor, as the catenary
/// that rises from there under the tension of the last step: hanging^2 = rise^2 + 2 rise H/(lambda g), less
/// what the straight link pulls down there by itself.
double rising(const CableConfig& c, const CableArrays& s, double link, int i, double rise) {
  if (!(s.tension[i] > 0)) return std::min(rise, kMost * link);
  const double dx = s.x[i] - s.x[i - 1], dy = s.y[i] - s.y[i - 1];
  const double square = dx * dx + dy * dy, flat = std::min(std::sqrt(square), link);
  const double pull = s.tension[i] / (c.linear_density * c.gravity * std::sqrt(square + rise * rise) + 1e-12);
  const double hanging = std::min(std::sqrt(rise * rise + 2 * rise * pull * flat), link);
  const double most = 0.5 * hanging * hanging * flat / (link * link);  // of what a link pulls that still lies
  return std::min(hanging - std::min(pull * rise, most), kMost * link);
}

/// Weighs the nodes: every link belongs to its ends by halves, but one that comes from the floor to its
/// higher end as far as it hangs. What leaves one end for the other takes its velocity along, so that a cable
/// that is lifted is gathered and not snatched node by node.
void weigh(const CableConfig& c, const CableArrays& s, double link, double* mass, double* weight) {
  const int n = c.nodes;
  const double lifted = c.floor_z + kLift * link, half = 0.5 * link;
  bool aloft = s.z[0] >= lifted;
  for (int i = 1; i <= n; ++i) aloft = aloft & (s.z[i] >= lifted) & (s.split[i] == half);
  if (aloft) {
    for (double* length : {mass, weight}) {
      std::fill_n(length, n + 1, link);
      length[0] = length[n] = half;
    }
    return;
  }
  mass[0] = weight[0] = 0.0;
  for (int i = 1; i <= n; ++i) {
    mass[i - 1] += s.split[i];
    mass[i] = link - s.split[i];
    weight[i] = 0.0;
  }
  for (int i = 1; i <= n; ++i) {
    const double rise = s.z[i - 1] - s.z[i], low = std::min(s.z[i - 1], s.z[i]);
    double share = half;
    if (low >= lifted) {
      weight[i - 1] += share;
      weight[i] += share;
    } else {
      const double lies = std::min((lifted - low) / (kLift * link), 1.0);
      const double higher = rising(c, s, link, i, std::abs(rise));
      const double up = share + lies * (higher - share);
      share = rise > 0 ? up : share + lies * (std::min(-rise / kLift, share) - share);
      weight[i - 1] += share;
      weight[i] += rise > 0 ? link - up : up;
    }
    const double moved = share - s.split[i];
    if (moved == 0) continue;
    s.split[i] = share;
    const int to = moved > 0 ? i - 1 : i, from = moved > 0 ? i : i - 1;
    mass[to] += std::abs(moved);
    mass[from] -= std::abs(moved);
    if (to == 0) continue;
    const double part = std::abs(moved) / mass[to];
    s.vx[to] += part * (s.vx[from] - s.vx[to]);
    s.vy[to] += part * (s.vy[from] - s.vy[to]);
    s.vz[to] += part * (s.vz[from] - s.vz[to]);
  }
}

/// Free motion over a step with gravity, damping and the floor; inverse masses follow from the implicit
/// floor.
void move_freely(const CableConfig& c, const CableArrays& s, double h, const Work& k) {
  const int n = c.nodes;
  const double link = c.length / n;
  const double keep = 1.0 / (1.0 + h * c.damping), settling = std::sqrt(c.gravity / link);
  const double weight = c.gravity * c.linear_density, slowness = 1.0 / (c.gravity + 1e-300);
  weigh(c, s, link, k.mass, k.weight);
  for (int i = 1; i <= n; ++i) {
    const double m = c.linear_density * k.mass[i];
    double force = -weight * k.weight[i];
    // A slack link hangs from its ends: each carries its leg, and the floor what is left. The straighter and
    // the more inclined it is, the more it hangs as a taut one, by halves.
    const auto share = [&](int other) {
      const double dx = s.x[i] - s.x[other], dy = s.y[i] - s.y[other], rise = s.z[i] - s.z[other];
      const double air = std::min((std::min(s.z[i], s.z[other]) - c.floor_z) / (kLift * link), 1.0);
      if (air <= 0) return 0.0;  // weigh() has counted it
      const double reach = link * link - rise * rise;
      const double loose = reach > 0 ? std::max(0.0, 1.0 - (dx * dx + dy * dy) / reach) : 1.0;
      const double above = std::clamp(s.z[i] - c.floor_z, 0.0, link);
      const double leg = std::clamp(0.5 * (link + rise), 0.0, above);
      return -weight * loose * air * (leg - 0.5 * link);
    };
    if (!(s.tension[i] > 0)) force += share(i - 1);
    if (i < n && !(s.tension[i + 1] > 0)) force += share(i + 1);
    // where the floor or the links above bear the weight, a heap swallows what motion is left
    const double inverse = 1.0 / m, borne = 1.0 + force * inverse * slowness;
    const double heap = s.z[i] - c.floor_z < link && borne > 0 ? 2.0 * h * settling * borne : 0.0;
    double vz = s.vz[i] * keep / (1.0 + heap) + h * force * inverse, tangential = 1.0 / (1.0 + heap);
    k.w_z[i] = k.w_xy[i] = inverse;
    if (s.z[i] + h * vz < c.floor_z) {
      const double implicit = 2 * kFloorDamping * kFloorRate * h + kFloorRate * kFloorRate * h * h;
      vz = (vz + h * kFloorRate * kFloorRate * (c.floor_z - s.z[i])) / (1.0 + implicit);
      k.w_z[i] /= 1.0 + implicit;
      const double slip = std::sqrt(s.vx[i] * s.vx[i] + s.vy[i] * s.vy[i]);
      tangential = 1.0 / (1.0 + h * c.friction * c.gravity / (slip + kSlipSpeed));
      k.w_xy[i] *= tangential;
    }
    if (i == n && c.fixed_end) {
      k.w_z[i] = k.w_xy[i] = 0.0;
      s.vx[i] = s.vy[i] = s.vz[i] = 0.0;
      continue;
    }
    s.vx[i] *= keep * tangential;
    s.vy[i] *= keep * tangential;
    s.vz[i] = vz;
    s.x[i] += h * s.vx[i];
    s.y[i] += h * s.vy[i];
    s.z[i] += h * vz;
  }
}

/// Directions and excess lengths of all links.
void measure(int n, double link, const CableArrays& s, const Work& k) {
  for (int i = 1; i <= n; ++i) {
    const double dx = s.x[i] - s.x[i - 1], dy = s.y[i] - s.y[i - 1], dz = s.z[i] - s.z[i - 1];
    const double length = std::sqrt(dx * dx + dy * dy + dz * dz);
    const double inverse = 1.0 / std::max(length, 1e-12);
    k.nx[i] = dx * inverse;
    k.ny[i] = dy * inverse;
    k.nz[i] = dz * inverse;
    k.gap[i] = length - link;
  }
}

/// Solves the constraints of the links that pull, from the far end upwards, so that the last pivot is the
/// inverse of the effective mass at the upper end.
void solve(int n, const Work& k) {
  double pivot = 1.0, rhs = 0.0;
  for (int i = n; i >= 1; --i) {
    const double horizontal = k.nx[i] * k.nx[i] + k.ny[i] * k.ny[i], vertical = k.nz[i] * k.nz[i];
    const double diagonal = (k.w_xy[i - 1] + k.w_xy[i]) * horizontal + (k.w_z[i - 1] + k.w_z[i]) * vertical;
    double off = 0.0;
    if (i < n && k.pulls[i] > 0 && k.pulls[i + 1] > 0)
      off = -k.w_xy[i] * (k.nx[i] * k.nx[i + 1] + k.ny[i] * k.ny[i + 1]) - k.w_z[i] * k.nz[i] * k.nz[i + 1];
    const double ratio = off / pivot;
    rhs = k.gap[i] - ratio * rhs;
    pivot = diagonal - ratio * off;
    if (k.pulls[i] == 0) {
      rhs = 0.0;
      pivot = 1.0;
    }
    k.off[i] = off;
    k.pivot[i] = pivot;
    k.multiplier[i] = rhs;
  }
  double above = 0.0;
  for (int i = 1; i <= n; ++i) {
    const double off = i > 1 ? k.off[i - 1] : 0.0;
    above = k.multiplier[i] = (k.multiplier[i] - off * above) / k.pivot[i];
  }
}

void apply(int n, const CableArrays& s, const Work& k) {
  for (int i = 1; i <= n; ++i) {
    const double up = k.multiplier[i], down = i < n ? k.multiplier[i + 1] : 0.0;
    const double fx = (i < n ? down * k.nx[i + 1] : 0.0) - up * k.nx[i];
    const double fy = (i < n ? down * k.ny[i + 1] : 0.0) - up * k.ny[i];
    const double fz = (i < n ? down * k.nz[i + 1] : 0.0) - up * k.nz[i];
    s.x[i] += k.w_xy[i] * fx;
    s.y[i] += k.w_xy[i] * fy;
    s.z[i] += k.w_z[i] * fz;
    k.sum[i] += up;
  }
}

}  // namespace

CableAnswer step_cable(const CableConfig& c, const CableArrays& s, const Vec3& upper_end, double h,
                       double* work) {
  const int n = c.nodes;
  const double link = c.length / n;
  const Work k = workspace(work, n);
  double* const old_x = work + kArraysOfWork * (n + 2);
  double* const old_y = old_x + (n + 1);
  double* const old_z = old_y + (n + 1);
  std::copy_n(s.x, n + 1, old_x);
  std::copy_n(s.y, n + 1, old_y);
  std::copy_n(s.z, n + 1, old_z);
  const Vec3 old_velocity(s.vx[0], s.vy[0], s.vz[0]);
  s.x[0] = upper_end.x();
  s.y[0] = upper_end.y();
  s.z[0] = upper_end.z();
  k.w_xy[0] = k.w_z[0] = 0.0;
  move_freely(c, s, h, k);

  measure(n, link, s, k);
  std::fill_n(k.sum, n + 1, 0.0);
  for (int i = 1; i <= n; ++i) k.pulls[i] = s.tension[i] > 0 || k.gap[i] > 0 ? 1.0 : 0.0;
  for (int round = 0; round < kRounds; ++round) {
    solve(n, k);
    bool pushes = false;
    for (int i = 1; i <= n; ++i)
      if (k.pulls[i] > 0 && k.multiplier[i] < 0) {
        k.pulls[i] = 0.0;
        pushes = true;
      }
    if (!pushes) break;
    if (round + 1 == kRounds)
      for (int i = 1; i <= n; ++i) k.multiplier[i] = std::max(0.0, k.multiplier[i]);
  }
  const double effective = k.pulls[1] > 0 ? 1.0 / k.pivot[1] : 0.0;
  apply(n, s, k);
  // once more for what the change of direction within the step left over, and for links that went taut
  measure(n, link, s, k);
  double worst = 0;
  for (int i = 1; i <= n; ++i) {
    if (k.gap[i] > 0) k.pulls[i] = 1.0;
    worst = std::max(worst, k.pulls[i] * std::abs(k.gap[i]));
  }
  if (worst > kTolerance * link) {
    solve(n, k);
    for (int i = 1; i <= n; ++i) k.multiplier[i] = std::max(k.multiplier[i], -k.sum[i]);
    apply(n, s, k);
  }

  const double rate = 1.0 / h;
  for (int i = 0; i <= n; ++i) {
    s.vx[i] = (s.x[i] - old_x[i]) * rate;
    s.vy[i] = (s.y[i] - old_y[i]) * rate;
    s.vz[i] = (s.z[i] - old_z[i]) * rate;
  }
  for (int i = 1; i <= n; ++i) s.tension[i] = k.sum[i] * rate * rate;
  CableAnswer answer;
  answer.direction = Vec3(s.x[1] - s.x[0], s.y[1] - s.y[0], s.z[1] - s.z[0]).normalized();
  const Vec3 acceleration = (Vec3(s.vx[0], s.vy[0], s.vz[0]) - old_velocity) * rate;
  answer.mass = effective;
  answer.pull = s.tension[1] + effective * answer.direction.dot(acceleration);
  answer.end_mass = c.linear_density * k.mass[0];
  if (s.tension[1] <= 0) answer.mass = answer.pull = 0;  // slack
  return answer;
}

void hang_cable(const CableConfig& c, const CableArrays& s, const Vec3& upper_end) {
  const double link = c.length / c.nodes, hangs = std::min(upper_end.z() - c.floor_z, c.length);
  for (int i = 0; i <= c.nodes; ++i) {
    const double z = upper_end.z() - i * link;
    const bool lies = z < c.floor_z;
    s.x[i] = upper_end.x() + (lies ? kHeap * link * std::cos(2.4 * i) : 0.0);
    s.y[i] = upper_end.y() + (lies ? kHeap * link * std::sin(2.4 * i) : 0.0);
    s.z[i] = std::max(z, c.floor_z);
    s.vx[i] = s.vy[i] = s.vz[i] = 0.0;
    const double below = hangs - (i - 0.5) * link;  // the middle of link i
    s.tension[i] = i > 0 && !lies ? c.gravity * c.linear_density * std::max(below, 0.0) : 0.0;
    s.split[i] = lies ? std::clamp(z + link - c.floor_z, 0.0, kMost * link) : 0.5 * link;
  }
}

Result<CableChain> CableChain::create(const CableConfig& c) {
  const auto refuse = [](const char* field, double value, const char* range) {
    return bad_input("is " + std::to_string(value) + ", outside " + range, std::string("cable.") + field);
  };
  if (c.nodes < 2 || c.nodes > 1000) return refuse("nodes", c.nodes, "2 to 1000");
  if (!(c.length > 0 && c.length < 1e4)) return refuse("length", c.length, "(0, 10000) m");
  if (!(c.linear_density > 0 && c.linear_density < 1e4))
    return refuse("linear_density", c.linear_density, "(0, 10000) kg/m");
  if (!(c.damping >= 0 && c.damping < 1e4)) return refuse("damping", c.damping, "[0, 10000) 1/s");
  if (!(c.friction >= 0 && c.friction < 100)) return refuse("friction", c.friction, "[0, 100)");
  if (!(c.gravity >= 0 && c.gravity < 1e3)) return refuse("gravity", c.gravity, "[0, 1000) m/s2");
  if (!std::isfinite(c.floor_z)) return refuse("floor_z", c.floor_z, "finite m");
  return CableChain(c);
}

CableChain::CableChain(const CableConfig& config) : config_(config) {
  state_.assign(static_cast<std::size_t>(kCableArrays * (config.nodes + 1)), 0.0);
  work_.assign(static_cast<std::size_t>(cable_work_size(config.nodes)), 0.0);
  hang(Vec3(0, 0, config.floor_z + config.length));
}

CableArrays CableChain::arrays() {
  const auto a = [this](int k) { return state_.data() + static_cast<std::size_t>(k * (config_.nodes + 1)); };
  return {a(0), a(1), a(2), a(3), a(4), a(5), a(6), a(7)};
}

void CableChain::hang(const Vec3& upper_end) { hang_cable(config_, arrays(), upper_end); }

void CableChain::stretch(const Vec3& upper_end, const Vec3& far_end) {
  const CableArrays s = arrays();
  const Vec3 side = (far_end - upper_end).unitOrthogonal();
  for (int i = 0; i <= config_.nodes; ++i) {
    const double f = static_cast<double>(i) / config_.nodes;
    const Vec3 p = upper_end + f * (far_end - upper_end) + 1e-3 * config_.length * f * (1 - f) * side;
    s.x[i] = p.x();
    s.y[i] = p.y();
    s.z[i] = p.z();
    s.vx[i] = s.vy[i] = s.vz[i] = s.tension[i] = 0.0;
    s.split[i] = 0.5 * config_.length / config_.nodes;
  }
}

void CableChain::step(const Vec3& upper_end, double step) {
  answer_ = step_cable(config_, arrays(), upper_end, step, work_.data());
}

Vec3 CableChain::end_force() const {
  return tension(1) * answer_.direction - answer_.end_mass * config_.gravity * Vec3::UnitZ();
}

double CableChain::energy() const {
  const double mass = config_.linear_density * config_.length / config_.nodes;
  double sum = 0;
  for (int i = 1; i <= config_.nodes; ++i) {
    const double m = i == config_.nodes ? 0.5 * mass : mass;
    sum += m * (0.5 * velocity(i).squaredNorm() + config_.gravity * (position(i).z() - config_.floor_z));
  }
  return sum;
}

}  // namespace omniflight::physics

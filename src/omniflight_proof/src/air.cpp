#include "air.hpp"

#include <cmath>

namespace omniflight::proof {

WindField::WindField(const std::optional<Wind>& wind, double floor_z, std::uint64_t seed)
    : wind_(wind), floor_z_(floor_z), rng_(seed, "proof wind") {}

void WindField::step(double t, double h) {
  if (!wind_) return;
  const double time = wind_->gust_length / std::max(0.5, wind_->velocity_W.norm());
  const double keep = std::exp(-h / time), drive = wind_->gust_rms * std::sqrt(1 - keep * keep);
  if (wind_->gust_rms > 0)
    shaped_ = keep * shaped_ + drive * Vec3(rng_.normal(), rng_.normal(), rng_.normal());
  gust_.setZero();
  for (const Gust& g : wind_->gusts)
    if (t >= g.start && t <= g.start + g.duration)
      gust_ += 0.5 * (1 - std::cos(2 * kPi * (t - g.start) / g.duration)) * g.velocity_W;
}

Vec3 WindField::at(const Vec3& p_W) const {
  if (!wind_) return Vec3::Zero();
  const double height = std::max(0.02, p_W.z() - floor_z_);
  return std::pow(height / wind_->reference_height, wind_->profile_exponent) * wind_->velocity_W + shaped_ +
         gust_;
}

Vec3 Jet::at(const Vec3& point) const {
  const Vec3 d = point - p;
  const double s = d.dot(along);
  if (s <= 0 || induced <= 0) return Vec3::Zero();
  // vortex cylinder on its axis: v_i (1 + s / sqrt(s^2 + R^2)), contracting to carry the same flow
  const double speedup = 1 + s / std::hypot(s, radius);
  const double core = radius / std::sqrt(speedup);
  const double wide = core + spread * s;
  const double speed = induced * speedup * (core * core) / (wide * wide) * (1 + spread * s / core);
  const double r = (d - s * along).norm() / wide;
  const double r4 = r * r * r * r;
  return speed / (1 + r4 * r4) * along;
}

Vec3 Jet::over_disc(const Vec3& center, const Vec3& normal, double disc_radius) const {
  const Vec3 e1 = (std::abs(normal.x()) < 0.7 ? Vec3::UnitX() : Vec3::UnitY()).cross(normal).normalized();
  const Vec3 e2 = normal.cross(e1);
  Vec3 sum = Vec3::Zero();
  constexpr int spokes = 6;
  // rings at the radii of two equal areas
  for (const double ring : {0.5, 0.866}) {
    for (int k = 0; k < spokes; ++k) {
      const double a = 2 * kPi * (k + (ring > 0.6 ? 0.5 : 0.0)) / spokes;
      sum += at(center + ring * disc_radius * (std::cos(a) * e1 + std::sin(a) * e2));
    }
  }
  return sum / (2 * spokes);
}

BladeModel::BladeModel(const Blades& blades, double air_density, double radius)
    : blades_(blades), density_(air_density), radius_(radius) {}

RotorLoad BladeModel::load(double speed, double still_thrust, double still_torque, const Vec3& axis,
                           const Vec3& v_air_rel, double image, double h) {
  RotorLoad out{still_thrust, still_torque, Vec3::Zero(), Vec3::Zero()};
  const double tip = std::abs(speed) * radius_, area = kPi * radius_ * radius_;
  const double scale = density_ * area * tip * tip;
  if (tip < 1.0 || std::abs(still_thrust) < 1e-9) return out;
  const double sign = still_thrust > 0 ? 1.0 : -1.0;
  const double ct0 = std::abs(still_thrust) / scale, cq0 = std::abs(still_torque) / (scale * radius_);
  const double inflow0 = std::sqrt(ct0 / 2);
  const double half_slope = 0.5 * blades_.solidity_slope;
  const double pitch = ct0 / half_slope + 0.5 * inflow0;  // a third of the blade pitch

  const double climb = sign * v_air_rel.dot(axis) / tip;
  const Vec3 edge = v_air_rel - v_air_rel.dot(axis) * axis;
  const double mu = blades_.edgewise ? std::min(1.0, edge.norm() / tip) : 0.0;
  const double slowest = 0.3 * inflow0;  // vortex ring: momentum theory ends here
  const auto thrust_at = [&](double inflow) {
    return half_slope * (pitch * (1 + 1.5 * mu * mu) - 0.5 * inflow);
  };
  // inflow = climb + induced, induced = CT / (2 |total|), by Newton's method
  double induced = inflow0;
  for (int k = 0; k < 30; ++k) {
    const double inflow = climb + induced, total = std::max(slowest, std::hypot(mu, inflow));
    const double ct = std::max(0.0, thrust_at(inflow));
    const double next = ct / (2 * total) * (1 - image);
    if (std::abs(next - induced) < 1e-12) break;
    const double bend = total > slowest ? ct * inflow / (2 * total * total * total) : 0.0;
    const double slope = (0.25 * half_slope / total + bend) * (1 - image);
    induced += (next - induced) / (1 + std::max(0.0, slope));
  }
  if (blades_.inflow_time > 0) {
    if (induced_ < 0) induced_ = induced;
    induced_ += (induced - induced_) * (1 - std::exp(-h / blades_.inflow_time));
    induced = induced_;
  }
  const double ct = thrust_at(climb + induced);
  const double profile = std::max(0.0, cq0 - ct0 * inflow0);
  const double cq = std::max(0.0, profile * (1 + 4.65 * mu * mu) + ct * (climb + induced));
  out.thrust = sign * scale * ct;
  out.torque = (still_torque > 0 ? 1.0 : -1.0) * scale * radius_ * cq;
  if (mu > 1e-9) {
    const Vec3 backward = -edge / edge.norm();
    const double tilt = 2 * mu * (4 * pitch - (climb + induced));  // first-harmonic flapping, rad
    out.in_plane = backward * scale * (2 * profile * mu + blades_.flapping * ct * tilt);
    // the disc tilts back: nose-up moment
    out.hub_moment = blades_.hub_stiffness * blades_.flapping * tilt * axis.cross(backward) * sign;
  }
  return out;
}

}  // namespace omniflight::proof

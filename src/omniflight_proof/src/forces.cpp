#include "forces.hpp"

#include <cmath>

#include "mjcf.hpp"

namespace omniflight::proof {

Forces::Forces(const vehicle::Vehicle& vehicle, const World& world, const Engine& engine, std::uint64_t seed)
    : vehicle_(vehicle),
      world_(world),
      wind_(world.wind, world.floor_z, seed),
      rng_(seed, "proof turbulence"),
      blades_on_(world.blades.has_value()) {
  if (world.blades || world.jets || world.planes || !world.neighbours.empty())
    for (const auto& rotor : vehicle.rotors)
      blades_.emplace_back(world.blades.value_or(Blades{}), world.air_density,
                           rotor.radius > 0 ? rotor.radius : 0.05);
  if (world.jets) {
    jets_.resize(vehicle.rotors.size());
    for (std::size_t i = 0; i < jets_.size(); ++i) {
      jets_[i].radius = vehicle.rotors[i].radius > 0 ? vehicle.rotors[i].radius : 0.05;
      jets_[i].spread = world.jets->spread;
    }
  }
  others_.resize(world.neighbours.size());
  if (world.flexible_arms)
    for (std::size_t i = 1; i <= vehicle.rotors.size(); ++i)
      pods_.push_back(engine.body("pod_" + std::to_string(i)));
  if (world.cable && world.cable->drag_coefficient > 0)
    for (int i = 1; i <= world.cable->links; ++i) cable_.push_back(engine.body("cable_" + std::to_string(i)));
}

void Forces::turbulence(double h) {
  const Turbulence& k = *world_.turbulence;
  const double time = k.correlation_time, keep = std::exp(-h / time), drive = std::sqrt(1 - keep * keep);
  const auto normal = [&] {
    Vec6 out;
    for (int c = 0; c < 6; ++c) out[c] = rng_.normal();
    return out;
  };
  turbulent_first_ = keep * turbulent_first_ + drive * normal();
  turbulent_ = turbulent_first_;
  if (k.kind == Turbulence::Kind::dryden) {
    // (1 + sqrt(3) T s) / (1 + T s)^2 on white noise: with x the first lag's output and y that of a second
    // one on x, sqrt(3) x + (1 - sqrt(3)) y. Its variance follows from E[x x] = 1, E[x y] = E[y y] = 1/2.
    turbulent_second_ = keep * turbulent_second_ + (1 - keep) * turbulent_first_;
    const double root = std::sqrt(3.0),
                 variance = 3 + 2 * root * (1 - root) * 0.5 + (1 - root) * (1 - root) * 0.5;
    turbulent_ = (root * turbulent_first_ + (1 - root) * turbulent_second_) / std::sqrt(variance);
  } else if (k.kind == Turbulence::Kind::heavy) {
    // strength exp(s z - s^2), z of unit variance and ten times as slow: E[strength^2] = 1, kurtosis 3 exp(4
    // s^2)
    constexpr double s = 0.5;
    const double slow = std::exp(-h / (10 * time));
    turbulent_second_ = slow * turbulent_second_ + std::sqrt(1 - slow * slow) * normal();
    turbulent_ = turbulent_first_.cwiseProduct((s * turbulent_second_.array() - s * s).exp().matrix());
  } else if (k.kind == Turbulence::Kind::bursts) {
    // a sixth of the time three times as strong; sojourns are exponential, calm 10 T and bursts 2 T long
    if (rng_.uniform() < h / (time * (burst_ ? 2 : 10))) burst_ = !burst_;
    turbulent_ *= (burst_ ? 3.0 : 1.0) / std::sqrt(5.0 / 6 + 9.0 / 6);
  }
  turbulent_wrench_ << k.force_rms * turbulent_.head<3>(), k.torque_rms * turbulent_.tail<3>();
}

void Forces::advance(double t, double h) {
  wind_.step(t, h);
  if (world_.turbulence) turbulence(h);
  for (std::size_t i = 0; i < others_.size(); ++i) {
    const Neighbour& n = world_.neighbours[i];
    others_[i].p = n.p_W + t * n.v_W;
    others_[i].radius = n.radius;
    others_[i].induced = t >= n.appears && t < n.leaves
                             ? std::sqrt(n.thrust / (2 * world_.air_density * kPi * n.radius * n.radius))
                             : 0.0;
  }
}

Vec3 Forces::jets_at(const Vec3& p_W) const {
  Vec3 sum = Vec3::Zero();
  for (const Jet& jet : jets_) sum += jet.at(p_W);
  for (const Jet& jet : others_) sum += jet.at(p_W);
  return sum;
}

Forces::Hub Forces::hub(const Engine& engine, const Motors& motors, std::size_t i, const Motion& m) const {
  const Vec3& p_B = motors.drive(i).p_B;
  if (pods_.empty())
    return {m.p_W + m.R_WB * p_B, m.R_WB * motors.axis_B(i), m.v_W + m.R_WB * m.w_B.cross(p_B), 0};
  const int id = pods_[i];
  const Quat q = engine.body_attitude(id);
  const Vec3 arm = q * (p_B - pod_hinge(vehicle_, *world_.flexible_arms, i));
  mjtNum velocity[6];  // rotational first, at the centre of the body's frame, world axes
  mj_objectVelocity(engine.model.get(), engine.data.get(), mjOBJ_XBODY, id, velocity, 0);
  const Vec3 w(velocity[0], velocity[1], velocity[2]), v(velocity[3], velocity[4], velocity[5]);
  return {engine.body_position(id) + arm, q * motors.axis_B(i), v + w.cross(arm), id};
}

double Forces::image_share(const Vec3& p_W, double radius) const {
  if (!world_.planes) return 0;
  const Planes& k = *world_.planes;
  const auto share = [&](double distance) {
    const double ratio = radius / (4 * std::max(0.5 * radius, distance));
    return ratio * ratio;
  };
  return std::min(0.6, k.floor * share(p_W.z() - world_.floor_z) + k.ceiling * share(k.ceiling_z - p_W.z()));
}

void Forces::rotors(Engine& engine, const Motors& motors, const Motion& m, double h, BodyWrench& out) {
  std::array<Hub, vehicle::kMaxRotors> hubs;
  const std::size_t n = motors.count();
  for (std::size_t i = 0; i < n; ++i) hubs[i] = hub(engine, motors, i, m);
  std::array<double, vehicle::kMaxRotors> thrust{};
  for (std::size_t i = 0; i < n; ++i) {
    const Drive& d = motors.drive(i);
    const double speed = motors.speed()[i], still = motors.thrust(i);
    RotorLoad load{still, d.drag_ratio_at(speed) * still, Vec3::Zero(), Vec3::Zero()};
    if (!blades_.empty()) {
      const double radius = vehicle_.rotors[i].radius > 0 ? vehicle_.rotors[i].radius : 0.05;
      Vec3 relative = Vec3::Zero();  // hub against the air
      if (blades_on_) relative = hubs[i].velocity_W - wind_.at(hubs[i].p_W);
      for (std::size_t j = 0; j < jets_.size(); ++j)
        if (j != i) relative -= jets_[j].over_disc(hubs[i].p_W, hubs[i].axis_W, radius);
      for (const Jet& jet : others_) relative -= jet.over_disc(hubs[i].p_W, hubs[i].axis_W, radius);
      load = blades_[i].load(speed, still, load.torque, hubs[i].axis_W, relative,
                             image_share(hubs[i].p_W, radius), h);
    }
    if (world_.rotor_air) rotor_air(hubs[i], speed, i, load);
    thrust[i] = load.thrust;
    const Vec3& n_W = hubs[i].axis_W;
    const Vec3 force_W = load.thrust * n_W + load.in_plane;
    Vec3 torque_W = d.spin * load.torque * n_W + load.hub_moment;
    if (d.inertia > 0) {  // it turns about -spin n
      const Vec3 w_W = m.R_WB * m.w_B;
      torque_W += d.spin * d.inertia * (motors.acceleration()[i] * n_W + speed * w_W.cross(n_W));
    }
    if (hubs[i].body > 0) {
      mj_applyFT(engine.model.get(), engine.data.get(), force_W.data(), torque_W.data(), hubs[i].p_W.data(),
                 hubs[i].body, engine.data->qfrc_applied);
    } else {
      out.add_at(m.R_WB.transpose() * force_W, d.p_B);
      out.torque_B += m.R_WB.transpose() * torque_W;
    }
  }
  for (std::size_t i = 0; i < jets_.size(); ++i) {
    const double area = kPi * jets_[i].radius * jets_[i].radius;
    jets_[i].p = hubs[i].p_W;
    jets_[i].along = thrust[i] >= 0 ? Vec3(-hubs[i].axis_W) : hubs[i].axis_W;
    jets_[i].induced =
        world_.jets->strength * std::sqrt(std::abs(thrust[i]) / (2 * world_.air_density * area));
  }
}

void Forces::rotor_air(const Hub& hub, double speed, std::size_t i, RotorLoad& load) const {
  const RotorAir& k = *world_.rotor_air;
  const Vec3 v = hub.velocity_W - wind_.at(hub.p_W);
  const double along = v.dot(hub.axis_W);
  load.in_plane -= k.drag * std::abs(speed) * (v - along * hub.axis_W);
  load.hub_moment += k.flapping * std::abs(speed) * v.cross(hub.axis_W);
  if (k.descent_loss <= 0) return;
  const double radius = vehicle_.rotors[i].radius > 0 ? vehicle_.rotors[i].radius : 0.05;
  const double inflow = std::sqrt(std::abs(load.thrust) / (2 * world_.air_density * kPi * radius * radius));
  const double off = (-along / std::max(0.1, inflow) - k.descent_center) / k.descent_width;
  load.thrust *= 1 - k.descent_loss * std::exp(-off * off);
}

void Forces::airframe(const Motion& m, BodyWrench& out) const {
  const double half_density = 0.5 * world_.air_density;
  if (world_.jets && world_.jets->body_drag > 0) {
    const Vec3 jet_B = m.R_WB.transpose() * jets_at(m.p_W);
    out.force_B += half_density * world_.jets->body_drag * jet_B.norm() * jet_B;
  }
  if (!world_.airframe) return;
  const Airframe& a = *world_.airframe;
  const Vec3 center_W = m.p_W + m.R_WB * a.center_B;
  Vec3 air = wind_.at(center_W);
  for (const Jet& jet : others_) air += jet.at(center_W);
  const Vec3 v = m.R_WB.transpose() * (m.v_W - air) + m.w_B.cross(a.center_B);
  const Vec3 force = -half_density *
                     (a.drag_area_B.cwiseProduct(v.cwiseAbs()).cwiseProduct(v) + a.round_area * v.norm() * v);
  out.add_at(force, a.center_B);
  out.torque_B -= a.rotation_damping * m.w_B.norm() * m.w_B;
}

void Forces::cable_drag(Engine& engine) const {
  if (cable_.empty()) return;
  const Cable& c = *world_.cable;
  const double length = c.length / c.links;
  for (const int id : cable_) {
    mjtNum velocity[6];
    mj_objectVelocity(engine.model.get(), engine.data.get(), mjOBJ_BODY, id, velocity, 0);
    const Vec3 p = Eigen::Map<const Vec3>(engine.data->xipos + 3 * id);
    const Vec3 along = engine.body_attitude(id) * Vec3::UnitZ();
    Vec3 v = Vec3(velocity[3], velocity[4], velocity[5]) - wind_.at(p) - jets_at(p);
    v -= v.dot(along) * along;
    Eigen::Map<Vec3>(engine.data->xfrc_applied + 6 * id) =
        -0.5 * world_.air_density * c.drag_coefficient * c.diameter * length * v.norm() * v;
  }
}

void Forces::apply(Engine& engine, const Motors& motors, double t, double h) {
  mjData* d = engine.data.get();
  mju_zero(d->qfrc_applied, engine.model->nv);
  Motion m;
  m.t = t;
  m.p_W = Eigen::Map<const Vec3>(d->qpos);
  m.R_WB = Quat(d->qpos[3], d->qpos[4], d->qpos[5], d->qpos[6]).normalized().toRotationMatrix();
  m.v_W = Eigen::Map<const Vec3>(d->qvel);
  m.w_B = Eigen::Map<const Vec3>(d->qvel + 3);
  m.rotor_circulation_B.setZero();
  for (std::size_t i = 0; i < motors.count(); ++i) {
    m.rotor_circulation_B += motors.speed()[i] * motors.axis_B(i);
    m.rotor_speed_sum += std::abs(motors.speed()[i]);
  }
  BodyWrench sum;
  rotors(engine, motors, m, h, sum);
  airframe(m, sum);
  cable_drag(engine);
  for (const Law& law : world_.laws) add_law(law, m, sum);
  for (const Spring& spring : world_.springs) add_spring(spring, m, sum);
  for (const Pull& pull : world_.pulls) add_pull(pull, m, sum);
  sum.force_B += m.R_WB.transpose() * turbulent_wrench_.head<3>();
  sum.torque_B += turbulent_wrench_.tail<3>();
  // a free joint: force in world axes, torque in body axes, both about the body origin
  Eigen::Map<Vec3>(d->qfrc_applied) += m.R_WB * sum.force_B;
  Eigen::Map<Vec3>(d->qfrc_applied + 3) += sum.torque_B;
}

}  // namespace omniflight::proof

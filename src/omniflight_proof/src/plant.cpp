#include "omniflight_proof/plant.hpp"

#include <cmath>

#include "chain.hpp"
#include "engine.hpp"
#include "forces.hpp"
#include "mjcf.hpp"
#include "motors.hpp"

namespace omniflight::proof {
namespace {

constexpr double kHeldArmature = 1e6;   // kg, kg m2: nothing that hangs from it moves a held body
constexpr double kSettleDamping = 10;   // joints are damped that much more while ropes come to rest
constexpr double kFarthestStart = 900;  // m

/// The state that left its range, with value, unit and range; empty when none did. Where numbers are no
/// longer finite, all of them go in one step, and the first is named.
std::string what_left(const RigidState& s) {
  if (const std::string what = what_is_not_finite(s); !what.empty()) return what + " (reasonable: finite)";
  const struct {
    const char *name, *unit;
    double size;
  } states[] = {{"position", "m", s.p_WB.norm()},
                {"velocity", "m/s", s.v_WB_W.norm()},
                {"angular velocity", "rad/s", s.w_WB_B.norm()}};
  for (const auto& [name, unit, size] : states)
    if (!(size <= 1e3))
      return "the size of the " + std::string(name) + " is " + std::to_string(size) + ' ' + unit +
             " (reasonable: at most 1000 " + unit + ')';
  return {};
}

}  // namespace

struct MujocoPlant::Impl {
  vehicle::Vehicle vehicle;
  World world;
  PlantOptions options;
  std::string xml;
  Engine engine;
  Motors motors;
  std::unique_ptr<Forces> forces = {};
  bool alone = true;  ///< nothing but the body moves
  int substeps = 1;
  std::uint64_t steps = 0;
  RigidState state = {}, hold = {};
  bool held = true;
  Vec6 rail_acceleration = Vec6::Zero();  ///< of a held body: world, then body axes
  std::vector<mjtNum> start_qpos = {};
  std::vector<int> cable = {};

  double time() const { return static_cast<double>(steps) * options.step; }
  mjModel* m() const { return engine.model.get(); }
  mjData* d() const { return engine.data.get(); }

  void set_armature(double value) const {
    for (int k = 0; k < 6; ++k) m()->dof_armature[k] = value;
  }
  void put(const RigidState& s) const {
    Eigen::Map<Vec3>(d()->qpos) = s.p_WB;
    const Quat q = s.q_WB.normalized();
    d()->qpos[3] = q.w();
    Eigen::Map<Vec3>(d()->qpos + 4) = q.vec();
    Eigen::Map<Vec3>(d()->qvel) = s.v_WB_W;
    Eigen::Map<Vec3>(d()->qvel + 3) = s.w_WB_B;
  }
  /// MuJoCo moves v by what the forces at t give and x by the new v: a leapfrog, of second order where v is
  /// taken for the velocity half a step before x. This is what is missing to the velocity at t.
  Vec6 half_step() const { return 0.5 * m()->opt.timestep * Eigen::Map<const Vec6>(d()->qacc); }
  void read_state() {
    Vec6 v = Eigen::Map<const Vec6>(d()->qvel);
    if (!held) v += half_step();
    state.p_WB = Eigen::Map<const Vec3>(d()->qpos);
    state.q_WB = Quat(d()->qpos[3], d()->qpos[4], d()->qpos[5], d()->qpos[6]);
    state.v_WB_W = v.head<3>();
    state.w_WB_B = v.tail<3>();
  }
  /// Accelerations for the present state and forces; a held body is pushed along its rail.
  void forward(double t, double h) const {
    mj_fwdPosition(m(), d());
    mj_fwdVelocity(m(), d());
    forces->apply(const_cast<Engine&>(engine), motors, t, h);
    if (held) Eigen::Map<Vec6>(d()->qfrc_applied) += kHeldArmature * rail_acceleration;
    mj_forwardSkip(m(), d(), mjSTAGE_VEL, 1);
  }
  /// One time step with the accelerations that forward() has found.
  void integrate() const {
    if (m()->opt.integrator == mjINT_IMPLICIT) return mj_step(m(), d());
    mj_Euler(m(), d());
  }
  /// What made mj_step put everything back to the beginning, which it does by itself; empty when nothing did.
  std::string what_restarted() const {
    const std::pair<int, const char*> kinds[] = {
        {mjWARN_BADQPOS, "position"}, {mjWARN_BADQVEL, "velocity"}, {mjWARN_BADQACC, "acceleration"}};
    for (const auto& [warning, name] : kinds)
      if (d()->warning[warning].number > 0)
        return std::string("the ") + name + " of joint coordinate " +
               std::to_string(d()->warning[warning].lastinfo + 1) +
               " is not finite or beyond 1e10 (m, rad and s)";
    return {};
  }
  Status bend_chains();
  void settle();
  void restart(std::uint64_t seed);
};

/// Ball joints of a chain take the attitudes in which its links have these directions.
static void bend(const Engine& engine, const std::string& name, const std::vector<Vec3>& directions,
                 const Quat& q_WB) {
  const auto attitudes = joint_attitudes(directions, q_WB);
  for (std::size_t i = 0; i < attitudes.size(); ++i) {
    const int body = engine.body(name + '_' + std::to_string(i + 1));
    mjtNum* q = engine.data->qpos + engine.model->jnt_qposadr[engine.model->body_jntadr[body]];
    q[0] = attitudes[i].w();
    Eigen::Map<Vec3>(q + 1) = attitudes[i].vec();
  }
}

Status MujocoPlant::Impl::bend_chains() {
  const RigidState& s = options.initial;
  if (world.cable) {
    auto shape = hanging(*world.cable, s.p_WB + s.q_WB * world.cable->attachment_B, world.floor_z);
    if (!shape) return Failure(shape.error());
    bend(engine, "cable", *shape, s.q_WB);
  }
  if (world.overhead_rope) {
    auto shape = bulging(*world.overhead_rope, s.p_WB + s.q_WB * world.overhead_rope->attachment_B);
    if (!shape) return Failure(shape.error());
    bend(engine, "rope", *shape, s.q_WB);
    // MuJoCo took the anchor from the straight rope of the model; it is a point of the world
    Eigen::Map<Vec3>(m()->eq_data + 3) = world.overhead_rope->anchor_W;
  }
  if (world.slung_ball) {
    const int adr = m()->jnt_qposadr[m()->body_jntadr[engine.body("ball")]];
    const Quat down = s.q_WB.conjugate() * Quat::Identity();
    d()->qpos[adr] = down.w();
    Eigen::Map<Vec3>(d()->qpos + adr + 1) = down.vec();
    const double lowest = (s.p_WB + s.q_WB * world.slung_ball->attachment_B).z() - world.slung_ball->length -
                          world.slung_ball->radius;
    if (lowest < world.floor_z)
      return bad_input("hangs " + std::to_string(world.floor_z - lowest) + " m below the floor at the start",
                       "slung_ball.length_m", "Start higher, or take a shorter rope");
  }
  return {};
}

void MujocoPlant::Impl::settle() {
  if (alone || world.settle <= 0) return;
  std::vector<mjtNum> damping(m()->dof_damping, m()->dof_damping + m()->nv);
  for (int k = 6; k < m()->nv; ++k) m()->dof_damping[k] *= kSettleDamping;
  set_armature(kHeldArmature);
  const auto count = static_cast<long>(std::ceil(world.settle / world.timestep));
  for (long k = 0; k < count; ++k) {
    if (k == count * 3 / 4) std::copy(damping.begin(), damping.end(), m()->dof_damping);
    mj_forward(m(), d());
    integrate();
    put(options.initial);
  }
  std::copy(damping.begin(), damping.end(), m()->dof_damping);
  set_armature(0);
}

void MujocoPlant::Impl::restart(std::uint64_t seed) {
  mj_resetData(m(), d());
  std::copy(start_qpos.begin(), start_qpos.end(), d()->qpos);
  forces = std::make_unique<Forces>(vehicle, world, engine, seed);
  motors.reset(options.initial_alpha);
  steps = 0;
  hold = options.initial;
  put(hold);
  held = true;
  set_armature(kHeldArmature);
  forces->advance(0, 0);
  forward(0, 0);
  read_state();
}

Result<MujocoPlant> MujocoPlant::create(const vehicle::Vehicle& vehicle, const World& world,
                                        const PlantOptions& options) {
  if (auto ok = vehicle::validate(vehicle); !ok) return Failure(ok.error());
  if (auto ok = validate(world); !ok) return Failure(ok.error());
  if (!is_finite(options.initial))
    return bad_input("is not finite: " + what_is_not_finite(options.initial), "initial",
                     "Give a finite start");
  if (!(options.initial.p_WB.norm() <= kFarthestStart))
    return bad_input("is " + std::to_string(options.initial.p_WB.norm()) + " m from the origin, at most " +
                         std::to_string(kFarthestStart) + " m are allowed",
                     "initial", "Start closer");
  if (!std::isfinite(options.initial_alpha))
    return bad_input("is " + std::to_string(options.initial_alpha) + " rad", "initial_alpha",
                     "Give a finite tilt");
  const double ratio = options.step / world.timestep;
  if (!(options.step > 0 && options.step <= 0.02) || std::abs(ratio - std::round(ratio)) > 1e-6 ||
      ratio < 0.999)
    return bad_input("of " + std::to_string(world.timestep) + " s does not divide the step of " +
                         std::to_string(options.step) + " s",
                     "timestep_s", "Take a divisor");
  for (const RotorChange& c : world.rotors)
    if (c.rotor > vehicle.rotor_count())
      return bad_input("is " + std::to_string(c.rotor) + ", and " + vehicle.name + " has " +
                           std::to_string(vehicle.rotor_count()) + " rotors",
                       "rotors.rotor", "Count from 1; 0 means all");
  auto xml = write_mjcf(vehicle, world, options.initial);
  if (!xml) return Failure(xml.error());
  auto engine = Engine::compile(*xml);
  if (!engine) return Failure(engine.error());
  auto impl = std::unique_ptr<Impl>(
      new Impl{.vehicle = vehicle,
               .world = world,
               .options = options,
               .xml = std::move(*xml),
               .engine = std::move(*engine),
               .motors = Motors(vehicle, world, world.timestep, options.initial_alpha)});
  impl->options.initial.q_WB.normalize();
  impl->alone = !world.articulated();
  impl->substeps = static_cast<int>(std::lround(ratio));
  if (world.cable)
    for (int i = 1; i <= world.cable->links; ++i)
      impl->cable.push_back(impl->engine.body("cable_" + std::to_string(i)));
  impl->put(impl->options.initial);
  if (auto ok = impl->bend_chains(); !ok) return Failure(ok.error());
  impl->settle();
  if (const std::string what = impl->what_restarted(); !what.empty())
    return bad_input("is " + std::to_string(world.timestep) +
                         " s, with which ropes and loads do not come to rest: " + what,
                     "timestep_s", "Take a smaller one");
  impl->start_qpos.assign(impl->d()->qpos, impl->d()->qpos + impl->m()->nq);
  for (const mjtNum q : impl->start_qpos)
    if (!std::isfinite(q))
      return bad_input(
          "is " + std::to_string(world.timestep) + " s, with which ropes and loads do not come to rest",
          "timestep_s", "Take a smaller one");
  impl->restart(options.seed);
  return MujocoPlant(std::move(impl));
}

MujocoPlant::MujocoPlant(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MujocoPlant::MujocoPlant(MujocoPlant&&) noexcept = default;
MujocoPlant& MujocoPlant::operator=(MujocoPlant&&) noexcept = default;
MujocoPlant::~MujocoPlant() = default;

bool MujocoPlant::set_command(std::span<const double> rotor_speed, double alpha) {
  return impl_->motors.command(rotor_speed, alpha);
}

void MujocoPlant::hold_at(const RigidState& state) {
  if (is_finite(state)) impl_->hold = state;
}

void MujocoPlant::reset(std::uint64_t seed) { impl_->restart(seed); }

Status MujocoPlant::step(bool held) {
  Impl& k = *impl_;
  if (held != k.held) {
    k.set_armature(held ? kHeldArmature : 0.0);
    if (held) k.hold = k.state;
    k.held = held;
    k.put(held ? k.hold : k.state);
    k.forward(k.time(), 0);
    if (!held) Eigen::Map<Vec6>(k.d()->qvel) -= k.half_step();
  }
  const double h = k.world.timestep, begin = k.time();
  const RigidState from = k.state;
  if (held && !k.alone) {
    // what hangs from it must feel that the rail speeds up or slows down
    Vec6 change;
    change << k.hold.v_WB_W - from.v_WB_W, k.hold.w_WB_B - from.w_WB_B;
    if (!change.isZero()) {
      k.rail_acceleration = change / h;
      k.forward(begin, 0);
      k.rail_acceleration.setZero();
    }
  }
  for (int i = 1; i <= k.substeps; ++i) {
    const double t = begin + i * h;
    if (!held || !k.alone) k.integrate();
    if (held) {  // along the rail, evenly
      const double part = static_cast<double>(i) / k.substeps;
      RigidState s = k.hold;
      s.p_WB = from.p_WB + part * (k.hold.p_WB - from.p_WB);
      s.q_WB = from.q_WB.slerp(part, k.hold.q_WB.normalized());
      k.put(s);
    }
    k.motors.step(t, h);
    k.forces->advance(t, h);
    // forces of the velocity see the one at t
    const Vec6 late = Eigen::Map<const Vec6>(k.d()->qvel);
    if (!held) Eigen::Map<Vec6>(k.d()->qvel) += k.half_step();
    k.forward(t, h);
    Eigen::Map<Vec6>(k.d()->qvel) = late;
  }
  ++k.steps;
  k.read_state();
  std::string left = k.what_restarted();
  if (left.empty()) left = what_left(k.state);
  if (!left.empty())
    return fail(
        ErrorCode::incomplete,
        "the integration left every reasonable range: " + left + " at t = " + std::to_string(k.time()) + " s",
        "mujoco_plant", "Check gains, world and timestep_s");
  return {};
}

double MujocoPlant::time() const { return impl_->time(); }
const RigidState& MujocoPlant::body() const { return impl_->state; }
std::span<const double> MujocoPlant::rotor_speed() const {
  return {impl_->motors.speed().data(), impl_->motors.count()};
}
double MujocoPlant::alpha() const { return impl_->motors.alpha_reported(); }
double MujocoPlant::true_alpha() const { return impl_->motors.alpha_true(); }

Vec3 MujocoPlant::acceleration() const {
  return impl_->held ? Vec3(Vec3::Zero()) : Vec3(Eigen::Map<const Vec3>(impl_->d()->qacc));
}
Vec3 MujocoPlant::angular_acceleration() const {
  return impl_->held ? Vec3(Vec3::Zero()) : Vec3(Eigen::Map<const Vec3>(impl_->d()->qacc + 3));
}
Vec3 MujocoPlant::specific_force() const {
  return impl_->state.q_WB.conjugate() * (acceleration() + kGravity * Vec3::UnitZ());
}

Vec6 MujocoPlant::unmodelled_wrench() const {
  const Impl& k = *impl_;
  Vec6 out = Vec6::Zero();
  if (k.held) return out;
  const vehicle::Vehicle& v = k.vehicle;
  const Vec3& w = k.state.w_WB_B;
  const Vec3& c = v.center_of_mass;
  const Vec3 dw = angular_acceleration();
  const Vec3 needed = v.mass * (specific_force() + dw.cross(c) + w.cross(w.cross(c)));
  out << needed, v.inertia * dw + w.cross(v.inertia * w) + c.cross(needed);
  for (std::size_t i = 0; i < v.rotors.size(); ++i) {
    const auto& r = v.rotors[i];
    const double thrust = r.thrust(k.motors.speed()[i]);
    const Vec3 n = v.rotor_axis(static_cast<int>(i), k.motors.alpha_reported());
    out.head<3>() -= thrust * n;
    out.tail<3>() -= r.p_BR.cross(thrust * n) + r.spin * r.drag_ratio * thrust * n;
  }
  return out;
}

double MujocoPlant::mechanical_power() const {
  double power = 0;
  for (std::size_t i = 0; i < impl_->vehicle.rotors.size(); ++i) {
    const auto& r = impl_->vehicle.rotors[i];
    const double speed = std::abs(impl_->motors.speed()[i]);
    power += r.drag_ratio * r.thrust_coefficient * speed * speed * speed;
  }
  return power;
}

std::pair<double, double> MujocoPlant::battery() const {
  return {impl_->motors.battery_voltage(), impl_->motors.battery_current()};
}
Vec3 MujocoPlant::wind_W() const { return impl_->forces->wind_at(impl_->state.p_WB); }

Vec3 MujocoPlant::cable_force_W() const {
  const Impl& k = *impl_;
  if (k.cable.empty()) return Vec3::Zero();
  mj_rnePostConstraint(k.m(), k.d());
  // what the parent exerts on the first link, from which the vehicle feels the opposite
  return -Eigen::Map<const Vec3>(k.d()->cfrc_int + 6 * k.cable.front() + 3);
}

std::vector<Vec3> MujocoPlant::cable_shape() const {
  std::vector<Vec3> out;
  for (const int id : impl_->cable) out.push_back(impl_->engine.body_position(id));
  if (!impl_->cable.empty()) {
    const double link = impl_->world.cable->length / impl_->world.cable->links;
    out.push_back(out.back() - link * (impl_->engine.body_attitude(impl_->cable.back()) * Vec3::UnitZ()));
  }
  return out;
}

const vehicle::Vehicle& MujocoPlant::vehicle() const { return impl_->vehicle; }
const World& MujocoPlant::world() const { return impl_->world; }
const PlantOptions& MujocoPlant::options() const { return impl_->options; }
const std::string& MujocoPlant::mjcf() const { return impl_->xml; }

}  // namespace omniflight::proof

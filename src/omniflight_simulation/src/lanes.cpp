// How a vehicle and its effects become numbers in a lane. The equations are those of omniflight_physics; a
// test flies every one of them beside a Plant.
#include "lanes.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <type_traits>

#include "omniflight_physics/effect_ids.hpp"
#include "omniflight_simulation/thrust_map.hpp"

namespace omniflight::simulation::lanes {
namespace {

namespace id = physics::effect_id;

enum class Kind {
  adds,            ///< adds to what another of the effect has put
  moves_the_mass,  ///< adds, and needs a block that is `coupled`
  once             ///< a lane holds one of it
};

/// An effect as numbers of a lane.
struct Entry {
  void (*put)(const double* theta, Common&, Block&, int lane) = nullptr;
  Kind kind = Kind::adds;
};

const std::map<std::string, Entry>& table() {
  static const std::map<std::string, Entry> t{
      {id::payload_mass, {[](const double* x, Common&, Block& b, int k) { b.payload[k] += x[0]; }}},
      {id::com_offset,
       {[](const double* x, Common&, Block& b, int k) {
          for (int i = 0; i < 3; ++i) b.com[i][k] += x[i];
        },
        Kind::moves_the_mass}},
      {id::inertia_error, {[](const double* x, Common&, Block& b, int k) {
         for (int i = 0; i < 3; ++i) b.inertia[i][k] += x[i];
       }}},
      {id::tilt_efficiency, {[](const double* x, Common&, Block& b, int k) {
         b.thrust_gain[k] -= x[0];
         b.thrust_gain_per_alpha[k] += x[1];
       }}},
      {id::rotor_inertia, {[](const double* x, Common& c, Block& b, int k) {
         b.rotor_inertia[k] += x[0];
         c.rotor_momentum = true;
       }}},
      {id::rotor_drag, {[](const double* x, Common& c, Block& b, int k) {
         b.drag_in_plane[k] += x[0];
         c.blades = true;
       }}},
      {id::axial_inflow, {[](const double* x, Common& c, Block& b, int k) {
         b.drag_axial[k] += x[0];
         c.blades = true;
       }}},
      {id::blade_flapping, {[](const double* x, Common& c, Block& b, int k) {
         b.flapping[k] += x[0];
         c.flapping = true;
       }}},
      {id::parasitic_drag, {[](const double* x, Common& c, Block& b, int k) {
         b.area[k] += x[0];
         c.drag = true;
       }}},
      {id::ground_effect, {[](const double* x, Common& c, Block& b, int k) {
         b.ground_strength[k] += x[0];
         c.ground = true;
       }}},
      {id::constant_pull, {[](const double* x, Common& c, Block& b, int k) {
         for (int i = 0; i < 3; ++i) b.pull[i][k] += x[i];
         c.world_force = true;
       }}},
      {id::wind,
       {[](const double* x, Common& c, Block& b, int k) {
          b.wind[0][k] = x[0];
          b.wind[1][k] = x[1];
          b.wind_area[k] = x[2];
          c.wind = true;
        },
        Kind::once}},
      {id::lateral_stiffness,
       {[](const double* x, Common& c, Block& b, int k) {
          b.stiffness[k] = x[0];
          b.anchor[0][k] = x[1];
          b.anchor[1][k] = x[2];
          c.world_force = true;
        },
        Kind::once}},
      {id::hung_cable,
       {[](const double* x, Common& c, Block& b, int k) {
          b.cable_density[k] = x[0];
          b.cable_start[k] = x[1];
          b.cable_length[k] = x[2];
          c.cable = true;
        },
        Kind::once}},
  };
  return t;
}

bool is_a(Kind kind, const physics::Effect& effect) {
  const auto found = table().find(effect.info().id);
  return found != table().end() && found->second.kind == kind;
}

/// Effects that go into the wrench map, by asking the effect itself.
bool maps(const physics::Effect& effect) {
  return effect.linear_in_thrust() && !table().contains(effect.info().id);
}

void put_map(const vehicle::Vehicle& vehicle, const physics::Model& model, Block& b, int k) {
  std::vector<physics::ActiveEffect> mapped;
  for (const auto& e : model.effects)
    if (maps(*e.effect)) mapped.push_back(e);
  const ThrustMap map(vehicle, mapped);
  for (int n = 0; n < 3; ++n)
    for (int i = 0; i < vehicle.rotor_count(); ++i)
      for (int row = 0; row < 6; ++row) b.map_by_tilt[n][i][row][k] = map.part(n)(row, i);
}

int packed(int row, int column) {
  static constexpr int index[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
  return index[row][column];
}

void put_nominal(const vehicle::Vehicle& vehicle, const PlantConfig& config, Common& common, Block& b,
                 int k) {
  common.rotors = vehicle.rotor_count();
  common.step = config.step;
  common.gravity = config.environment.gravity;
  common.air_density = config.environment.air_density;
  common.floor_z = config.environment.floor_z;
  common.tilt_rate = vehicle.tilt.rate;
  for (int i = 0; i < common.rotors; ++i) {
    const vehicle::Rotor& r = vehicle.rotors[static_cast<std::size_t>(i)];
    Common::Rotor& out = common.rotor[i];
    out.p = r.p_BR;
    const Mat3 square = r.p_BR.squaredNorm() * Mat3::Identity() - r.p_BR * r.p_BR.transpose();
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column <= row; ++column) out.square[packed(row, column)] = square(row, column);
    out.constant = r.axis_B;
    out.cosine = out.sine = Vec3::Zero();
    if (r.tilts) {  // Rodrigues
      out.constant = r.tilt_axis_B.dot(r.axis_B) * r.tilt_axis_B;
      out.cosine = r.axis_B - out.constant;
      out.sine = r.tilt_axis_B.cross(r.axis_B);
    }
    out.thrust_coefficient = r.thrust_coefficient;
    out.spin = r.spin;
    out.drag_ratio = r.drag_ratio;
    out.radius = r.radius;
    out.bidirectional = r.bidirectional;
  }
  const auto reverses = [](const vehicle::Rotor& r) { return r.bidirectional; };
  if (std::all_of(vehicle.rotors.begin(), vehicle.rotors.end(), reverses))
    common.reverse = Reverse::all;
  else if (std::any_of(vehicle.rotors.begin(), vehicle.rotors.end(), reverses))
    common.reverse = Reverse::some;
  const RigidState& s = config.initial;
  const Quat q = s.q_WB.normalized();
  for (int i = 0; i < 3; ++i) {
    b.p[i][k] = s.p_WB[i];
    b.v[i][k] = s.v_WB_W[i];
    b.w[i][k] = s.w_WB_B[i];
    b.com[i][k] = vehicle.center_of_mass[i];
  }
  for (int i = 0; i < 4; ++i) b.q[i][k] = q.coeffs()[i];
  b.alpha[k] = b.alpha_command[k] = config.initial_alpha;
  b.mapped_alpha[k] = std::nan("");
  b.mass[k] = vehicle.mass;
  // about the body origin: the centre of mass may lie elsewhere (m (|c|^2 I - c c^T))
  const Mat3 C = skew(vehicle.center_of_mass);
  const Mat3 inertia = vehicle.inertia - vehicle.mass * C * C;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column <= row; ++column) b.inertia[packed(row, column)][k] = inertia(row, column);
  if (!inertia.isDiagonal(0.0)) common.products = true;
}

void put_motors(const physics::Actuation& actuation, Common& common, Block& b, int k) {
  const double h = common.step;
  for (int i = 0; i < common.rotors; ++i) {
    const auto r = static_cast<std::size_t>(i);
    const double tau = actuation.time_constant[r];
    b.inverse_tau[i][k] = tau > 0 ? 1.0 / tau : 0.0;
    b.share_middle[i][k] = tau > 0 ? -std::expm1(-0.5 * h / tau) : 1.0;
    b.share_end[i][k] = tau > 0 ? -std::expm1(-h / tau) : 1.0;
    const double of_way = b.share_middle[i][k] / b.share_end[i][k];
    if (i == 0) b.share_of_way[k] = of_way;
    b.bend[i][k] = of_way - b.share_of_way[k];
    if (tau <= 0) b.ideal[i][k] = common.ideal_motors = true;
  }
}

void put_mass_matrix(const vehicle::Vehicle& vehicle, Block& b, int k) {
  b.weight_mass[k] = vehicle.mass + b.payload[k];
  b.inverse_mass[k] = 1.0 / b.weight_mass[k];
  Mat3 inertia;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) inertia(row, column) = b.inertia[packed(row, column)][k];
  for (int i = 0; i < 3; ++i)
    b.inertia_gap[i][k] = inertia((i + 2) % 3, (i + 2) % 3) - inertia((i + 1) % 3, (i + 1) % 3);
  const Mat3 inverse = inertia.inverse();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column <= row; ++column)
      b.inverse_inertia[packed(row, column)][k] = inverse(row, column);
  const Mat3 C = skew(Vec3(b.com[0][k], b.com[1][k], b.com[2][k]));
  Mat6 M = Mat6::Zero();
  M.topLeftCorner<3, 3>() = b.weight_mass[k] * Mat3::Identity();
  M.topRightCorner<3, 3>() = -vehicle.mass * C;
  M.bottomLeftCorner<3, 3>() = vehicle.mass * C;
  M.bottomRightCorner<3, 3>() = inertia;
  const Mat6 generalised = M.inverse();
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column)
      b.inverse_generalised[6 * row + column][k] = generalised(row, column);
}

/// Copies everything of one vehicle to another place.
void copy_lane(Block& block, int from, int to) {
  static_assert(std::is_standard_layout_v<Block>);
  static_assert(offsetof(Block, ideal) % sizeof(Lane) == 0);
  auto* const first = reinterpret_cast<Lane*>(&block);  // all that stands before `ideal` is lanes
  for (Lane* lane = first; lane != first + offsetof(Block, ideal) / sizeof(Lane); ++lane)
    (*lane)[to] = (*lane)[from];
  for (auto& rotor : block.ideal) rotor[to] = rotor[from];
}

}  // namespace

void close(const Common& common, Block& block) {
  for (int lane = block.used; lane < kLanes; ++lane) copy_lane(block, 0, lane);
  for (int i = 1; i < common.rotors; ++i)
    for (int k = 0; k < kLanes; ++k)
      block.lags_differ = block.lags_differ || block.share_end[i][k] != block.share_end[0][k];
}

bool knows(const physics::Effect& effect) {
  const auto& info = effect.info();
  if (info.stage == physics::Stage::sensing) return true;
  // what acts on commands alone is the business of physics::Actuators
  if (!effect.acts_on_wrench() && effect.memory_size().total() == 0) return true;
  return table().contains(info.id) || maps(effect);
}

bool adds_up(const physics::Effect& effect) { return !is_a(Kind::once, effect); }
bool moves_the_mass(const physics::Effect& effect) { return is_a(Kind::moves_the_mass, effect); }

void put_vehicle(const vehicle::Vehicle& vehicle, const physics::Model& model, const PlantConfig& config,
                 const physics::Actuation& actuation, Common& common, Block& b, int k) {
  put_nominal(vehicle, config, common, b, k);
  for (const auto& e : model.effects)
    if (const auto found = table().find(e.effect->info().id); found != table().end())
      found->second.put(e.theta.data(), common, b, k);
  put_map(vehicle, model, b, k);
  put_motors(actuation, common, b, k);
  put_mass_matrix(vehicle, b, k);
}

}  // namespace omniflight::simulation::lanes

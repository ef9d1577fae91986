#include "omniflight_simulation/batch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "lanes.hpp"

namespace omniflight::simulation {

struct Batch::Impl {
  struct Place {
    std::size_t block = 0;  ///< or the number of the Plant
    int lane = 0;
    bool plant = false;
  };
  vehicle::Vehicle vehicle;
  PlantConfig config;
  std::vector<Place> places;
  lanes::Common common;
  std::vector<lanes::Block> blocks;
  std::vector<lanes::Trains> trains;
  std::vector<Plant> plants;
  std::vector<char> plant_lost;
  std::uint64_t steps = 0;
  bool held = true;
  // as it was in the beginning
  std::vector<lanes::Block> first_blocks;
  std::vector<std::unique_ptr<physics::Actuators>> first_trains;  ///< kLanes a block
  std::vector<Plant> first_plants;
  std::size_t rotors = 0;
  std::array<double, vehicle::kMaxRotors> lowest{}, highest{};  ///< rad/s, commanded speed of a rotor
  double least_tilt = 0, most_tilt = 0;                         ///< rad, commanded

  /// Commands the N rotors of a vehicle in lanes within their limits; false when a number is not finite.
  template <int N>
  bool command(const double* speed, double alpha, lanes::Block& block, int lane) const {
    using Speeds = Eigen::Array<double, N, 1, 0, N == Eigen::Dynamic ? vehicle::kMaxRotors : N>;
    const auto count = static_cast<Eigen::Index>(rotors);
    const auto of = [&](const double* x) { return Eigen::Map<const Speeds>(x, count); };
    if (!((0.0 * of(speed)).sum() + 0.0 * alpha == 0.0)) return false;
    const Speeds kept = of(speed).max(of(lowest.data())).min(of(highest.data()));
    double* const target = &block.target[0][lane];
    for (Eigen::Index r = 0; r < kept.size(); ++r) target[r * lanes::kLanes] = kept[r];
    const double least = least_tilt, most = most_tilt;
    block.alpha_command[lane] = alpha < least ? least : alpha > most ? most : alpha;
    // places that nobody uses fly along with the first: they must not be lost
    for (int k = lane == 0 ? block.used : lanes::kLanes; k < lanes::kLanes; ++k) {
      for (Eigen::Index r = 0; r < kept.size(); ++r) block.target[r][k] = kept[r];
      block.alpha_command[k] = block.alpha_command[0];
    }
    return true;
  }

  void remember() {
    first_blocks = blocks;
    first_plants = plants;
    for (const lanes::Trains& t : trains)
      for (const auto& train : t.of)
        first_trains.push_back(train ? std::make_unique<physics::Actuators>(*train) : nullptr);
  }

  /// The block of a vehicle in lanes, with accelerations at the present state.
  const lanes::Block& answered(const Place& place) {
    lanes::Block& block = blocks[place.block];
    if (!block.answered) lanes::run(common, block, trains[place.block], 0, false);
    return block;
  }
};

namespace {

/// Empty when the model can fly in lanes, else why not.
std::string why_not(const physics::Model& model, const physics::Actuation& actuation,
                    const PlantConfig& config) {
  if (std::isfinite(actuation.slew_limit))
    return "a limit on the acceleration of rotors is not available in lanes";
  if (config.integrator != Integrator::rk4) return "lanes integrate by rk4 only";
  std::set<std::string> seen;
  for (const auto& e : model.effects) {
    const std::string& id = e.effect->info().id;
    if (!flies_in_lanes(*e.effect)) return "the effect " + id + " is not available in lanes";
    if (!seen.insert(id).second && !lanes::adds_up(*e.effect)) return "the effect " + id + " is listed twice";
  }
  return {};
}

physics::Actuation actuation_of(const vehicle::Vehicle& vehicle, const physics::Model& model) {
  physics::Actuation actuation = physics::nominal_actuation(vehicle);
  for (const auto& e : model.effects) e.effect->alter_actuation(vehicle, e.theta.data(), actuation);
  return actuation;
}

/// Nothing but lags between command and speed.
bool plain(const physics::Actuation& actuation) {
  physics::Actuation ideal;
  ideal.time_constant = actuation.time_constant;
  ideal.delay.assign(actuation.delay.size(), 0.0);
  return ideal == actuation;
}

/// What a drive must not have to fly in lanes: they know no battery and no limit on accelerations.
bool has_what_lanes_lack(const physics::Actuation& a) {
  return std::isfinite(a.slew_limit) || a.battery_resistance != 0 || a.battery_drop != 0;
}

/// The drive of a vehicle of one rotor on which an effect acts at its typical size.
physics::Actuation typical_actuation(const physics::Effect& effect) {
  vehicle::Vehicle vehicle;
  vehicle.rotors.resize(1);
  physics::ActiveEffect active{&effect, {}};
  for (const physics::Parameter& p : effect.info().parameters) active.theta.push_back(p.typical);
  physics::Model model;
  model.effects.push_back(std::move(active));
  return actuation_of(vehicle, model);
}

bool coupled(const vehicle::Vehicle& vehicle, const physics::Model& model) {
  if (!vehicle.center_of_mass.isZero()) return true;
  return std::any_of(model.effects.begin(), model.effects.end(),
                     [](const auto& e) { return lanes::moves_the_mass(*e.effect); });
}

}  // namespace

bool flies_in_lanes(const physics::Effect& effect) {
  return lanes::knows(effect) && !has_what_lanes_lack(typical_actuation(effect));
}

std::vector<std::string> lane_effects() {
  std::vector<std::string> ids;
  for (const physics::Effect* e : physics::builtin_effects())
    if (flies_in_lanes(*e)) ids.push_back(e->info().id);
  return ids;
}

std::string lane_instruction_set() { return lanes::instruction_set(); }

Result<Batch> Batch::create(const vehicle::Vehicle& vehicle, std::span<const physics::Model> models,
                            const BatchConfig& config) {
  auto impl = std::make_unique<Impl>();
  impl->vehicle = vehicle;
  impl->rotors = vehicle.rotors.size();
  impl->config = config.plant;
  if (!config.initial.empty() && config.initial.size() != models.size())
    return bad_input("there are " + std::to_string(config.initial.size()) + " initial states for " +
                         std::to_string(models.size()) + " vehicles",
                     "batch.initial", "Give one a vehicle, or none");
  if (!config.seeds.empty() && config.seeds.size() != models.size())
    return bad_input("there are " + std::to_string(config.seeds.size()) + " seeds for " +
                         std::to_string(models.size()) + " vehicles",
                     "batch.seeds", "Give one a vehicle, or none");
  PlantConfig at = config.plant;
  // the block that is being filled, for vehicles whose centre of mass is at the origin and for others
  std::size_t open[2] = {0, 0};
  bool is_open[2] = {false, false};
  for (std::size_t i = 0; i < models.size(); ++i) {
    const physics::Model& model = models[i];
    if (!config.initial.empty()) at.initial = config.initial[i];
    if (!config.seeds.empty()) at.seed = config.seeds[i];
    auto plant = Plant::create(vehicle, model, at);
    if (!plant) {
      Error error = plant.error();
      error.where = "vehicle " + std::to_string(i) + " of the batch: " + error.where;
      return Failure(error);
    }
    const physics::Actuation actuation = actuation_of(vehicle, model);
    if (const std::string why = why_not(model, actuation, config.plant); !why.empty()) {
      if (config.unsupported == BatchConfig::Unsupported::refuse)
        return bad_input(why, "vehicle " + std::to_string(i) + " of the batch",
                         "Let it fly as a Plant (unsupported = plant)");
      impl->places.push_back({impl->plants.size(), 0, true});
      impl->plants.push_back(std::move(*plant));
      continue;
    }
    const bool kind = coupled(vehicle, model);
    if (!is_open[kind] || impl->blocks[open[kind]].used == lanes::kLanes) {
      open[kind] = impl->blocks.size();
      is_open[kind] = true;
      impl->blocks.emplace_back();
      impl->trains.emplace_back();
      impl->blocks.back().coupled = kind;
    }
    lanes::Block& block = impl->blocks[open[kind]];
    const int lane = block.used++;
    lanes::put_vehicle(vehicle, model, at, actuation, impl->common, block, lane);
    if (!plain(actuation)) {
      auto train = physics::Actuators::create(vehicle, actuation, at.step, at.initial_alpha);
      if (!train) return Failure(train.error());
      lanes::Trains& trains = impl->trains[open[kind]];
      trains.of[lane] = std::make_unique<physics::Actuators>(std::move(*train));
      trains.any = true;
    }
    impl->places.push_back({open[kind], lane, false});
  }
  impl->plant_lost.assign(impl->plants.size(), 0);
  for (lanes::Block& block : impl->blocks) lanes::close(impl->common, block);
  for (std::size_t r = 0; r < vehicle.rotors.size(); ++r) {
    impl->highest[r] = vehicle.rotors[r].max_speed();
    impl->lowest[r] = vehicle.rotors[r].bidirectional ? -impl->highest[r] : 0.0;
  }
  if (vehicle.tilt.kind != vehicle::TiltKind::none) {
    impl->least_tilt = vehicle.tilt.min;
    impl->most_tilt = vehicle.tilt.max;
  }
  impl->remember();
  return Batch(std::move(impl));
}

Batch::Batch(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Batch::Batch(Batch&&) noexcept = default;
Batch& Batch::operator=(Batch&&) noexcept = default;
Batch::~Batch() = default;

std::size_t Batch::size() const { return impl_->places.size(); }
std::size_t Batch::in_lanes() const { return impl_->places.size() - impl_->plants.size(); }
double Batch::time() const { return static_cast<double>(impl_->steps) * impl_->config.step; }

bool Batch::set_command(std::size_t i, std::span<const double> rotor_speed, double alpha) {
  const Impl::Place& place = impl_->places[i];
  if (place.plant) return impl_->plants[place.block].set_command(rotor_speed, alpha);
  const std::size_t rotors = impl_->rotors;
  if (rotor_speed.size() != rotors) return false;
  lanes::Block& block = impl_->blocks[place.block];
  // eight rotors are common, and a number that the compiler knows makes two of them one operation
  return rotors == 8 ? impl_->command<8>(rotor_speed.data(), alpha, block, place.lane)
                     : impl_->command<Eigen::Dynamic>(rotor_speed.data(), alpha, block, place.lane);
}

std::size_t Batch::step(int steps, bool held) {
  Impl& m = *impl_;
  m.held = held;
  std::size_t lost = 0;
  if (steps > 0) {
    for (std::size_t k = 0; k < m.blocks.size(); ++k)
      lanes::run(m.common, m.blocks[k], m.trains[k], steps, held);
    for (std::size_t k = 0; k < m.plants.size(); ++k)
      for (int n = 0; n < steps && !m.plant_lost[k]; ++n)
        if (!m.plants[k].step(held)) m.plant_lost[k] = 1;
    m.steps += static_cast<std::uint64_t>(steps);
  }
  for (const lanes::Block& block : m.blocks)
    for (int k = 0; block.any_lost && k < block.used; ++k) lost += block.lost[k] != 0.0;
  for (const char plant : m.plant_lost) lost += plant != 0;
  return m.places.size() - lost;
}

void Batch::reset() {
  Impl& m = *impl_;
  m.blocks = m.first_blocks;
  m.plants = m.first_plants;
  std::fill(m.plant_lost.begin(), m.plant_lost.end(), 0);
  for (std::size_t k = 0; k < m.first_trains.size(); ++k)
    if (m.first_trains[k]) *m.trains[k / lanes::kLanes].of[k % lanes::kLanes] = *m.first_trains[k];
  m.steps = 0;
  m.held = true;
}

bool Batch::lost(std::size_t i) const {
  const Impl::Place& place = impl_->places[i];
  if (place.plant) return impl_->plant_lost[place.block] != 0;
  return impl_->blocks[place.block].lost[place.lane] != 0.0;
}

RigidState Batch::body(std::size_t i) const {
  const Impl::Place& place = impl_->places[i];
  if (place.plant) return impl_->plants[place.block].body();
  const lanes::Block& b = impl_->blocks[place.block];
  const int k = place.lane;
  return {{b.p[0][k], b.p[1][k], b.p[2][k]},
          Quat(b.q[3][k], b.q[0][k], b.q[1][k], b.q[2][k]),
          {b.v[0][k], b.v[1][k], b.v[2][k]},
          {b.w[0][k], b.w[1][k], b.w[2][k]}};
}

double Batch::rotor_speed(std::size_t i, std::size_t rotor) const {
  const Impl::Place& place = impl_->places[i];
  if (place.plant) return impl_->plants[place.block].rotor_speed()[rotor];
  return impl_->blocks[place.block].speed[rotor][place.lane];
}

double Batch::alpha(std::size_t i) const {
  const Impl::Place& place = impl_->places[i];
  return place.plant ? impl_->plants[place.block].alpha() : impl_->blocks[place.block].alpha[place.lane];
}

Vec3 Batch::specific_force(std::size_t i) const {
  const Impl::Place& place = impl_->places[i];
  if (place.plant) return impl_->plants[place.block].specific_force();
  if (impl_->held) return body(i).q_WB.conjugate() * Vec3(0, 0, impl_->config.environment.gravity);
  const lanes::Block& b = impl_->answered(place);
  return {b.specific_force[0][place.lane], b.specific_force[1][place.lane], b.specific_force[2][place.lane]};
}

Vec3 Batch::angular_acceleration(std::size_t i) const {
  const Impl::Place& place = impl_->places[i];
  if (place.plant) return impl_->plants[place.block].angular_acceleration();
  if (impl_->held) return Vec3::Zero();
  const lanes::Block& b = impl_->answered(place);
  return {b.angular_acceleration[0][place.lane], b.angular_acceleration[1][place.lane],
          b.angular_acceleration[2][place.lane]};
}

}  // namespace omniflight::simulation

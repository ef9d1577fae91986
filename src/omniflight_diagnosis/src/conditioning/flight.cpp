#include "omniflight_diagnosis/flight.hpp"

#include <algorithm>
#include <cmath>

#include "attitude_rows.hpp"
#include "fine_motion.hpp"
#include "ground.hpp"
#include "neighbours.hpp"
#include "omniflight_diagnosis/filter.hpp"
#include "omniflight_physics/effect_ids.hpp"
#include "reference_motion.hpp"
#include "segments.hpp"
#include "sensor_faults.hpp"
#include "sensor_noise.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kClippedMargin = 0.1;  ///< s: little is missing in there

using recording::Recording;
using recording::Signal;

/// A vehicle's own model of its thrust says what settled rotors give, and it lifts off later: what follows on
/// standing for three time constants of its slowest motor is standing.
void spins_up(const vehicle::Vehicle& vehicle, double rate_hz, std::vector<char>& standing) {
  double slowest = 0;
  for (const vehicle::Rotor& r : vehicle.rotors) slowest = std::max(slowest, r.time_constant);
  const auto most = static_cast<int>(3 * slowest * rate_hz);
  int left = 0;
  for (char& stands : standing) {
    left = stands ? most : left - 1;
    if (left > 0) stands = 1;
  }
}

/// Where an onboard estimator had no position to correct its velocity with: from max_gap_s after the last one
/// until as long after the next.
std::vector<char> unaided(const Signal& position, const Grid& grid, double max_gap_s) {
  std::vector<char> out(grid.t.size(), 0);
  for (std::size_t k = 1; k < position.t_s.size(); ++k) {
    if (position.t_s[k] - position.t_s[k - 1] <= max_gap_s) continue;
    for (std::size_t i = 0; i < out.size(); ++i)
      if (grid.t[i] > position.t_s[k - 1] + max_gap_s && grid.t[i] < position.t_s[k] + max_gap_s) out[i] = 1;
  }
  return out;
}

/// Cuts the samples at which the velocity was dead reckoning, or says why it cannot afford to.
void cut_unaided(const std::vector<char>& bad, const Grid& grid, UsedSamples& used, std::vector<char>& good,
                 Flight& f) {
  std::vector<char> left = good;
  int lost = 0;
  for (std::size_t k = 0; k < left.size(); ++k) {
    const bool unaided_here = bad[k * static_cast<std::size_t>(grid.step)];
    lost += unaided_here;
    if (unaided_here) left[k] = 0;
  }
  if (lost == 0) return;
  if (samples(long_runs(left, f.rate_hz)) < 2 * f.rate_hz) {
    f.notes.push_back(
        "For " + std::to_string(100 * lost / static_cast<int>(left.size())) +
        " % of the flight the vehicle's estimator had no position: its velocity is dead "
        "reckoning there, and what depends on it is not to be trusted. Too little would be left "
        "without these windows.");
    return;
  }
  used.list(bad, "estimated velocity without a position to correct it");
  good = std::move(left);
}

void add_faults(const Repaired& repaired, Flight& f) {
  f.faults = find_sensor_faults(repaired.recording);
  f.faults.insert(f.faults.end(), repaired.faults.begin(), repaired.faults.end());
  if (voltage_never_changes(repaired.recording) &&
      std::none_of(f.faults.begin(), f.faults.end(),
                   [](const SensorFault& x) { return x.effect == physics::effect_id::battery_sensor_fault; }))
    f.notes.push_back("The battery voltage never changes: a supply holds it, or its sensor is frozen.");
}

/// What the recording and its repair say of themselves.
void exclude_what_is_said(const Repaired& repaired, const Grid& grid, const Options& o, UsedSamples& used) {
  if (const Signal* phase = repaired.recording.find("phase"))
    used.exclude(negated(in_free_flight(*phase, grid.t)), o.margin_s, "not in free flight (phase)");
  for (const Window& w : repaired.frozen) used.exclude(in_windows({w}, grid), o.margin_s, w.why);
  for (const Window& w : repaired.clipped) used.exclude(in_windows({w}, grid), kClippedMargin, w.why);
}

/// Standing, crashed, or with too little thrust to fly. Also where the floor is.
void exclude_ground(const Recording& recording, const ChosenSignals& signals, const FineMotion& m,
                    const Grid& grid, const vehicle::Vehicle& vehicle, const Options& o, UsedSamples& used,
                    Flight& f) {
  Ground contact = find_ground(m.position, f.has_position, m.rotor_speed, m.specific_force, m.attitude,
                               grid.rate_hz, vehicle, o);
  if (recording.find("phase")) {  // it says itself when it flew; before, it may hang instead of stand
    contact.known = false;
    std::fill(contact.resting.begin(), contact.resting.end(), 0);
  }
  f.floor_z = o.environment.floor_z;
  if (!o.floor_told && contact.known) {
    f.stood_at = contact.height;
    f.floor_z = contact.height - kLeastHubHeight * mean_radius(vehicle);
  }
  if (signals.rotors.speed.name == "thrust_model") spins_up(vehicle, grid.rate_hz, contact.resting);
  used.exclude(contact.resting, 0.1, "standing on the ground");
  used.exclude(contact.crashed, 0.3, "crash");
  std::vector<char> slow(grid.t.size());
  for (Eigen::Index i = 0; i < grid.size(); ++i)
    slow[static_cast<std::size_t>(i)] =
        push_at(m.rotor_speed, i, vehicle) < 0.25 * vehicle.mass * o.environment.gravity;
  used.exclude(slow, contact.known ? 0.15 : 1.0, "rotors too slow to fly");
}

/// Rotors beyond their limit: a regression would see the limit, and not the physics.
void exclude_saturation(const FineMotion& m, const Grid& grid, const vehicle::Vehicle& vehicle,
                        UsedSamples& used) {
  std::vector<char> saturated(grid.t.size(), 0);
  for (Eigen::Index i = 0; i < grid.size(); ++i)
    for (Eigen::Index r = 0; r < m.rotor_speed.cols(); ++r)
      if (std::abs(m.rotor_speed(i, r)) > 1.1 * vehicle.rotors[static_cast<std::size_t>(r)].max_speed())
        saturated[static_cast<std::size_t>(i)] = 1;
  used.exclude(saturated, 0.05, "rotor speed beyond the vehicle's limit");
}

/// The fine grid, sample by sample of the flight; which of these are used.
std::vector<char> sample_flight(const Recording& recording, const FineMotion& m, const Grid& grid,
                                const UsedSamples& used, const vehicle::Vehicle& vehicle, const Options& o,
                                Flight& f) {
  const std::vector<physics::NeighbourTrack> neighbours = neighbours_of(recording, o);
  const Eigen::MatrixXd spin_up = differentiate(m.rotor_turning, grid.rate_hz);
  const Eigen::MatrixXd asked = reference_motion(recording, grid, vehicle, o);
  const Signal* reference = f.has_position ? recording.find("ref_position") : nullptr;
  const Eigen::MatrixXd place_asked = reference ? on_grid(*reference, grid, o).x : Eigen::MatrixXd();
  physics::Environment environment = o.environment;
  environment.floor_z = f.floor_z;
  const Eigen::Index n = grid.size() / grid.step;
  f.specific_force.resize(n, 3);
  f.rotor_speed.resize(n, m.rotor_speed.cols());
  f.reference.resize(n, asked.cols());
  if (reference) f.tracking_error.resize(n, 3);
  f.situation.resize(static_cast<std::size_t>(n));
  std::vector<char> good(static_cast<std::size_t>(n));
  std::vector<double> speed(static_cast<std::size_t>(m.rotor_speed.cols())), change(speed.size());
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index i = k * grid.step;
    f.t.push_back(grid.t[static_cast<std::size_t>(i)]);
    RigidState body;
    body.p_WB = m.position.row(i).transpose();
    body.q_WB = quaternion(m.attitude, i);
    body.v_WB_W = m.velocity.row(i).transpose();
    body.w_WB_B = m.rate.row(i).transpose();
    Eigen::Map<Eigen::RowVectorXd>(speed.data(), m.rotor_speed.cols()) = m.rotor_speed.row(i);
    Eigen::Map<Eigen::RowVectorXd>(change.data(), spin_up.cols()) = spin_up.row(i);
    physics::Situation& x = f.situation[static_cast<std::size_t>(k)];
    physics::prepare(vehicle, body, m.alpha(i, 0), speed, change, environment, x);
    x.t = f.t.back();
    physics::set_neighbours(neighbours, x.t, x);
    x.a_WB_B = Vec3(m.specific_force.row(i)) + x.g_B;
    x.dw_WB_B = m.angular_acceleration.row(i).transpose();
    f.specific_force.row(k) = m.specific_force.row(i);
    f.rotor_speed.row(k) = m.rotor_speed.row(i);
    f.reference.row(k) = asked.row(i);
    if (reference) f.tracking_error.row(k) = m.position.row(i) - place_asked.row(i);
    good[static_cast<std::size_t>(k)] =
        used.flags()[static_cast<std::size_t>(i)] && is_finite(body) && f.specific_force.row(k).allFinite();
  }
  return good;
}

CommandTrack commands_of(const Signal& speeds) {
  CommandTrack out;
  out.value.resize(speeds.width(), speeds.size());
  for (Eigen::Index i = 0; i < speeds.size(); ++i) {
    const double t = speeds.t_s[static_cast<std::size_t>(i)];
    if (!speeds.values.row(i).allFinite() || (!out.t.empty() && t <= out.t.back())) continue;
    out.value.col(static_cast<Eigen::Index>(out.t.size())) = speeds.values.row(i).transpose();
    out.t.push_back(t);
  }
  out.value.conservativeResize(Eigen::NoChange, static_cast<Eigen::Index>(out.t.size()));
  return out;
}

void add_voltage(const Recording& recording, Flight& f) {
  const int n = f.size();
  f.log_voltage = Eigen::VectorXd::Zero(n);
  const Signal* vbat = recording.find("vbat");
  const Eigen::MatrixXd volt = vbat ? recording::resample(*vbat, f.t) : Eigen::MatrixXd::Ones(n, 1);
  const double mean = vbat ? vbat->values.mean() : 1.0;
  for (int k = 0; k < n; ++k)
    if (std::isfinite(volt(k, 0))) f.log_voltage[k] = std::log(std::clamp(volt(k, 0) / mean, 0.3, 3.0));
}

/// Clocks as recorded, since that is what the reader of a report has.
void report_recorded_clocks(const Repaired& repaired, Flight& f) {
  if (!repaired.clock_moved) return;
  const auto late = std::find_if(f.alignment.begin(), f.alignment.end(),
                                 [](const Alignment& a) { return a.early == "rotor_speed (torque)"; });
  f.alignment.erase(f.alignment.begin(), late);
  f.alignment.insert(f.alignment.begin(), repaired.alignment.begin(), repaired.alignment.end());
}

Failure too_little_left(const Flight& f) {
  const auto most = std::max_element(
      f.excluded.begin(), f.excluded.end(),
      [](const Window& a, const Window& b) { return a.to_s - a.from_s < b.to_s - b.from_s; });
  return bad_input("less than 2 s of uninterrupted free flight is left after cutting " +
                       std::to_string(f.excluded.size()) + " windows" +
                       (most == f.excluded.end() ? "" : " (" + most->why + ", ...)"),
                   f.file, "Check the vehicle, or give a longer flight");
}

}  // namespace

int Flight::usable() const { return samples(segments); }

bool Flight::has(const std::string& signal) const {
  return std::find(signals.begin(), signals.end(), signal) != signals.end();
}

Result<Flight> prepare_flight(const Recording& recording, const vehicle::Vehicle& vehicle, const Options& o) {
  return prepare_repaired(repaired(recording), vehicle, o);
}

namespace {

Result<Flight> conditioned(const Repaired& repaired, const vehicle::Vehicle& vehicle, const Options& o) {
  const Recording& recording = repaired.recording;
  Flight f;
  f.notes = repaired.notes;
  f.file = recording.file;
  f.sha256 = recording.sha256;
  f.duration_s = recording.duration_s;
  for (const std::string& name : recording.signal_names())
    if (name.rfind("truth_", 0) != 0) f.signals.push_back(name);
  const auto signals = choose_signals(repaired, vehicle, o, f.notes);
  if (!signals) return tl::unexpected(signals.error());
  f.speed_from_command = signals->rotors.kind != SpeedSource::measured;
  f.thrust_modelled = signals->rotors.kind == SpeedSource::modelled;
  const auto grid = fine_grid(*signals, f.file, o);
  if (!grid) return tl::unexpected(grid.error());

  UsedSamples used(*grid);
  add_faults(repaired, f);
  exclude_what_is_said(repaired, *grid, o, used);
  FineMotion motion = fine_motion(*signals, repaired, *grid, vehicle, o, used, f);
  if (f.speed_from_command) f.commands = commands_of(signals->rotors.speed);
  if (f.thrust_modelled) {
    const double scale = lift_scale(motion.rotor_speed, motion.alpha, motion.specific_force, motion.position,
                                    f.has_position, vehicle);
    motion.rotor_speed *= std::sqrt(scale);
    motion.rotor_turning *= std::sqrt(scale);
    f.commands.value *= std::sqrt(scale);
  }
  exclude_ground(recording, *signals, motion, *grid, vehicle, o, used, f);
  for (const SensorFault& fault : f.faults)
    if (fault.effect == physics::effect_id::rotor_speed_sensor_fault && !f.speed_from_command)
      // listed only: the wrench of such a flight is not judged at all
      used.list(frozen_samples(signals->rotors.speed, fault.channel, grid->t), fault.channel + " is stuck");
  if (!f.thrust_modelled) exclude_saturation(motion, *grid, vehicle, used);
  used.exclude_ends(o.margin_s);

  f.rate_hz = o.grid_hz;
  for (const Signal* s : signals->all()) f.reach_s = std::max(f.reach_s, s->median_period_s());
  std::vector<char> good = sample_flight(recording, motion, *grid, used, vehicle, o, f);
  if (f.thrust_modelled) add_voltage(recording, f);
  if (const Signal* aid = recording.find("position");
      aid && signals->velocity && signals->velocity->name == "est_velocity")
    cut_unaided(unaided(*aid, *grid, o.max_gap_s), *grid, used, good, f);
  report_recorded_clocks(repaired, f);
  f.excluded = used.windows();
  f.segments = long_runs(good, f.rate_hz);
  if (f.usable() < 2 * f.rate_hz) return too_little_left(f);
  return f;
}

}  // namespace

Result<Flight> prepare_repaired(const Repaired& repaired, const vehicle::Vehicle& vehicle, const Options& o) {
  Result<Flight> flight = conditioned(repaired, vehicle, o);
  if (!flight || !noise_is_told(*flight, o.noise)) return flight;
  Repaired noisier = repaired;
  add_noise(o.noise, noisier.recording);
  if (const Result<Flight> again = conditioned(noisier, vehicle, o); again && again->size() == flight->size())
    flight->sensor_noise = residual_between(*flight, *again, vehicle.center_of_mass);
  return flight;
}

}  // namespace omniflight::diagnosis

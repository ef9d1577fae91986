#include "omniflight_diagnosis/flight.hpp"

#include <algorithm>
#include <cmath>

#include "attitude_rows.hpp"
#include "force_frame.hpp"
#include "ground.hpp"
#include "neighbours.hpp"
#include "omniflight_diagnosis/filter.hpp"
#include "omniflight_diagnosis/residual.hpp"
#include "omniflight_physics/effect_ids.hpp"
#include "outliers.hpp"
#include "repair.hpp"
#include "segments.hpp"
#include "sensor_faults.hpp"
#include "thrust_source.hpp"
#include "torque_alignment.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kClippedMargin = 0.1;      // s: little is missing in there
constexpr double kLeastTorqueLag = 0.0015;  // s: what a linear grid of some milliseconds can tell

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

/// Fine grid on which raw signals are laid before filtering.
struct Grid {
  double rate_hz = 0;
  int step = 1;  ///< fine samples per grid sample
  std::vector<double> t;
};

/// A filtered signal on the fine grid, and where it is trustworthy.
struct Channel {
  Eigen::MatrixXd x;  ///< NaN replaced by the last value
  std::vector<char> valid;
};

/// Variance [s^2] of the kernel under which a signal reaches the regression besides its block mean: the
/// triangle of interpolation between its samples, and the box of every central difference.
double kernel_variance(const Signal& signal, const Grid& grid, int derivatives) {
  const double period = signal.median_period_s(), step = 1 / grid.rate_hz;
  return period * period / 6 + derivatives * step * step / 3;
}

/// `more` [s^2]: variance to add to the signal's kernel.
Channel on_grid(const Signal& signal, const Grid& grid, const Options& o, double more = 0) {
  Channel c;
  const double gap = std::max(o.max_gap_s, 3.0 * signal.median_period_s());
  c.x = recording::resample(without_outliers(signal), grid.t, gap);
  c.valid.assign(grid.t.size(), 1);
  const Eigen::Index n = c.x.rows();
  Eigen::Index first = 0;
  while (first < n && !c.x.row(first).allFinite()) ++first;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (c.x.row(i).allFinite()) continue;
    c.valid[static_cast<std::size_t>(i)] = 0;
    if (first == n)
      c.x.row(i).setZero();
    else
      c.x.row(i) = c.x.row(i < first ? first : i - 1);
  }
  if (recording::is_attitude(signal.name)) make_continuous(c.x);
  c.x = blur(block_mean(c.x, grid.step), std::max(0.0, more) * grid.rate_hz * grid.rate_hz);
  return c;
}

/// See Flight::reference.
Eigen::MatrixXd reference_motion(const Recording& recording, const Grid& grid, const Options& o) {
  const auto fine = static_cast<Eigen::Index>(grid.t.size());
  const auto given = [&](const char* name, const char* integral) -> Eigen::MatrixXd {
    if (const Signal* s = recording.find(name)) return on_grid(*s, grid, o).x;
    const Signal* s = integral ? recording.find(integral) : nullptr;
    return s ? differentiate(on_grid(*s, grid, o).x, grid.rate_hz) : Eigen::MatrixXd::Zero(fine, 0);
  };
  Eigen::MatrixXd v = given("ref_velocity", "ref_position"), a = given("ref_acceleration", "ref_velocity"),
                  w = given("ref_angular_velocity", nullptr),
                  dw = given("ref_angular_acceleration", "ref_angular_velocity");
  if (a.cols() == 0 && v.cols() > 0) a = differentiate(v, grid.rate_hz);
  const Signal* attitude = recording.find("ref_attitude");
  if (attitude && w.cols() == 0) w = rate_from_attitude(on_grid(*attitude, grid, o).x, grid.rate_hz);
  if (w.cols() > 0 && dw.cols() == 0) dw = differentiate(w, grid.rate_hz);
  a.rowwise() += o.environment.gravity * Eigen::RowVector3d::UnitZ().leftCols(a.cols());
  if (attitude) {
    const Eigen::MatrixXd q = on_grid(*attitude, grid, o).x;
    for (Eigen::Index i = 0; i < fine; ++i)
      for (Eigen::MatrixXd* x : {&v, &a})
        if (x->cols() == 3) x->row(i) = (quaternion(q, i).conjugate() * Vec3(x->row(i))).transpose();
  }
  Eigen::MatrixXd out(fine, v.cols() + a.cols() + w.cols() + dw.cols());
  out << v, a, w, dw;
  return out;
}

/// Share of the signal's span that lies in gaps longer than max_gap_s.
double gap_share(const Signal& s, double max_gap_s) {
  double lost = 0;
  for (std::size_t i = 1; i < s.t_s.size(); ++i)
    if (const double step = s.t_s[i] - s.t_s[i - 1]; step > max_gap_s) lost += step;
  const double span = s.t_s.back() - s.t_s.front();
  return span > 0 ? lost / span : 1.0;
}

/// The measured signal, or the vehicle's own estimate where the measurement is missing or full of gaps.
const Signal* measured_or_estimated(const Recording& recording, const std::string& name, const Options& o,
                                    std::vector<std::string>& notes) {
  const Signal* measured = recording.find(name);
  const Signal* estimated = recording.find("est_" + name);
  if (!estimated) return measured;
  if (!measured || (gap_share(*measured, o.max_gap_s) > 0.05 &&
                    gap_share(*estimated, o.max_gap_s) < 0.5 * gap_share(*measured, o.max_gap_s))) {
    notes.push_back("The " + name + " is the vehicle's own estimate: " +
                    (measured ? "the measured one has many gaps." : "no measured one was recorded."));
    return estimated;
  }
  return measured;
}

/// Signed squares, and back. Filters work on squares: thrust follows them, so that the wrench is filtered as
/// the acceleration is, also where rotors reverse.
Eigen::MatrixXd squares(const Eigen::MatrixXd& x) { return x.cwiseProduct(x.cwiseAbs()); }
Eigen::MatrixXd roots(const Eigen::MatrixXd& x) { return x.array().abs().sqrt() * x.array().sign(); }

/// First-order lag of every rotor command with the vehicle's own time constants.
Eigen::MatrixXd modelled_speed(const Eigen::MatrixXd& command, double rate_hz, const vehicle::Vehicle& v) {
  Eigen::MatrixXd speed = command;
  for (Eigen::Index r = 0; r < command.cols(); ++r) {
    const double tau = v.rotors[static_cast<std::size_t>(r)].time_constant;
    for (Eigen::Index i = 1; i < command.rows(); ++i)
      speed(i, r) = lagged_speed(speed(i - 1, r), command(i - 1, r), tau, 1.0 / rate_hz);
  }
  return speed;
}

/// Adds the windows in which `bad` holds and clears them (with a margin) in `use`.
void exclude(const std::vector<char>& bad, const Grid& grid, double margin_s, const std::string& why,
             std::vector<char>& use, std::vector<Window>& windows) {
  const int n = static_cast<int>(bad.size()), margin = static_cast<int>(margin_s * grid.rate_hz);
  for (int i = 0; i < n;) {
    if (!bad[static_cast<std::size_t>(i)]) {
      ++i;
      continue;
    }
    int j = i;
    while (j < n && bad[static_cast<std::size_t>(j)]) ++j;
    for (int k = std::max(0, i - margin); k < std::min(n, j + margin); ++k)
      use[static_cast<std::size_t>(k)] = 0;
    windows.push_back({grid.t[static_cast<std::size_t>(i)], grid.t[static_cast<std::size_t>(j - 1)], why});
    i = j;
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

/// Where the grid lies in any of these windows.
std::vector<char> in_windows(const std::vector<Window>& windows, const Grid& grid) {
  std::vector<char> out(grid.t.size(), 0);
  const double half = 0.51 / grid.rate_hz;  // the shortest hold a sample
  for (const Window& w : windows)
    for (std::size_t i = 0; i < out.size(); ++i)
      if (grid.t[i] >= w.from_s - half && grid.t[i] <= w.to_s + half) out[i] = 1;
  return out;
}

std::vector<char> negated(const std::vector<char>& v) {
  std::vector<char> out(v.size());
  for (std::size_t i = 0; i < v.size(); ++i) out[i] = !v[i];
  return out;
}

/// Cuts the samples at which the velocity was dead reckoning, or says why it cannot afford to.
void cut_unaided(const std::vector<char>& bad, const Grid& grid, std::vector<char>& good, Flight& f) {
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
  std::vector<char> use(grid.t.size(), 1);
  exclude(bad, grid, 0.0, "estimated velocity without a position to correct it", use, f.excluded);
  good = std::move(left);
}

}  // namespace

int Flight::usable() const { return samples(segments); }

bool Flight::has(const std::string& signal) const {
  return std::find(signals.begin(), signals.end(), signal) != signals.end();
}

Result<Flight> prepare_flight(const Recording& recording, const vehicle::Vehicle& vehicle, const Options& o) {
  return prepare_repaired(repaired(recording), vehicle, o);
}

Result<Flight> prepare_repaired(const Repaired& repaired, const vehicle::Vehicle& vehicle, const Options& o) {
  const Recording& recording = repaired.recording;
  Flight f;
  f.notes = repaired.notes;
  f.file = recording.file;
  f.sha256 = recording.sha256;
  f.duration_s = recording.duration_s;
  for (const std::string& name : recording.signal_names())
    if (name.rfind("truth_", 0) != 0) f.signals.push_back(name);

  const auto need = [&](const Signal* signal, const char* name, const char* why) -> Result<const Signal*> {
    if (signal) return signal;
    return bad_input(std::string("no signal '") + name + "', " + why, recording.file,
                     "Record it, or name the column with --map");
  };
  auto attitude = need(measured_or_estimated(recording, "attitude", o, f.notes), "attitude",
                       "so forces cannot be told from gravity");
  if (!attitude) return tl::unexpected(attitude.error());
  const auto source = thrust_source(recording, vehicle);
  if (!source)
    return bad_input("no 'rotor_speed', 'rotor_command' or 'pwm': the wrench of the rotors is unknown",
                     recording.file, "Record one of them, or name the columns with --map");
  const Signal* rotor = &source->speed;
  f.speed_from_command = source->kind != SpeedSource::measured;
  f.thrust_modelled = source->kind == SpeedSource::modelled;
  if (!source->note.empty()) f.notes.push_back(source->note);
  const Signal* acc = recording.find("acc");
  const Signal* gyro = recording.find("gyro");
  const Signal* position = measured_or_estimated(recording, "position", o, f.notes);
  const Signal* velocity = measured_or_estimated(recording, "velocity", o, f.notes);
  if (!acc && !velocity && !position)
    return bad_input("neither accelerometer nor velocity nor position was recorded", recording.file,
                     "The force residual needs one of 'acc', 'velocity', 'position'");

  // the pose of a motion capture is put on the clock of the gyro
  f.alignment =
      repaired.alignment.empty() || repaired.clock_moved ? align_signals(recording) : repaired.alignment;
  Signal shifted_attitude = **attitude, shifted_position;
  for (const Alignment& a : f.alignment) {
    if (a.early != "gyro" || a.late != shifted_attitude.name || !(a.lag_se < 0.002)) continue;
    const auto shift = [&](Signal& s) {
      for (double& t : s.t_s) t -= a.lag_s;
    };
    shift(shifted_attitude);
    if (position && position->name == "position" && a.late == "attitude") {
      shifted_position = *position;
      shift(shifted_position);
      position = &shifted_position;
    }
  }
  const Signal* const attitude_used = &shifted_attitude;

  // what stands on both sides of the regression
  Signal rotor_squares = *rotor;
  rotor_squares.values = squares(rotor->values);

  // the fine grid covers the time all needed signals share
  double from = -1e18, to = 1e18, fastest = 1e18;
  for (const Signal* s : {attitude_used, rotor, acc, gyro, position, velocity}) {
    if (!s) continue;
    from = std::max(from, s->t_s.front());
    to = std::min(to, s->t_s.back());
    if (s->median_period_s() > 0) fastest = std::min(fastest, s->median_period_s());
  }
  if (!(to - from > 2.0) || !(fastest < 1.0))
    return bad_input("the needed signals overlap for less than 2 s", recording.file,
                     "Give a longer recording");
  if (to - from > 7200)
    return bad_input("longer than two hours", recording.file, "Give a part of the recording");
  Grid grid;
  grid.step = std::clamp(static_cast<int>(std::lround(1.0 / fastest / o.grid_hz)), 3, 15);
  grid.rate_hz = o.grid_hz * grid.step;
  const int fine = static_cast<int>((to - from) * grid.rate_hz);
  for (int i = 0; i < fine; ++i) grid.t.push_back(from + i / grid.rate_hz);

  // Both sides of the regression under the same kernel: a slower one takes amplitude from the motion and not
  // from the rotors, which looks like inertia.
  double widest = kernel_variance(*rotor, grid, 0);
  widest =
      std::max(widest, gyro ? kernel_variance(*gyro, grid, 1) : kernel_variance(*attitude_used, grid, 2));
  widest = std::max(widest, acc        ? kernel_variance(*acc, grid, 0)
                            : velocity ? kernel_variance(*velocity, grid, 1)
                                       : kernel_variance(*position, grid, 2));
  f.kernel_s = std::sqrt(widest + 1 / (12 * o.grid_hz * o.grid_hz));
  const auto missing = [&](const Signal& s, int derivatives) {
    return widest - kernel_variance(s, grid, derivatives);
  };

  // faults and free flight
  f.faults = find_sensor_faults(recording);
  f.faults.insert(f.faults.end(), repaired.faults.begin(), repaired.faults.end());
  if (voltage_never_changes(recording) &&
      std::none_of(f.faults.begin(), f.faults.end(),
                   [](const SensorFault& x) { return x.effect == physics::effect_id::battery_sensor_fault; }))
    f.notes.push_back("The battery voltage never changes: a supply holds it, or its sensor is frozen.");
  std::vector<char> use(grid.t.size(), 1);
  if (const Signal* phase = recording.find("phase"))
    exclude(negated(in_free_flight(*phase, grid.t)), grid, o.margin_s, "not in free flight (phase)", use,
            f.excluded);
  const std::vector<char> repeated = in_windows(repaired.frozen, grid),
                          limited = in_windows(repaired.clipped, grid);
  for (const Window& w : repaired.frozen)
    exclude(in_windows({w}, grid), grid, o.margin_s, w.why, use, f.excluded);
  for (const Window& w : repaired.clipped)
    exclude(in_windows({w}, grid), grid, kClippedMargin, w.why, use, f.excluded);
  const auto take = [&](const Signal& s, const std::string& label, double more = 0) {
    Channel c = on_grid(s, grid, o, more);
    std::vector<char> gap = negated(c.valid);
    for (std::size_t i = 0; i < gap.size(); ++i) gap[i] = gap[i] && !repeated[i] && !limited[i];
    exclude(gap, grid, o.margin_s, "gap in " + label, use, f.excluded);
    return c.x;
  };
  const Eigen::MatrixXd q = take(*attitude_used, "attitude");
  Eigen::MatrixXd speed = roots(take(rotor_squares, rotor->name, missing(*rotor, 0)));
  if (f.speed_from_command) speed = modelled_speed(speed, grid.rate_hz, vehicle);
  // momentum goes with the speed itself: the root of a filtered square starts at zero like a wall
  Signal rotor_itself = rotor_squares;
  rotor_itself.values = roots(rotor_itself.values);
  Eigen::MatrixXd turning = on_grid(rotor_itself, grid, o, missing(*rotor, 1)).x;
  if (f.speed_from_command) turning = modelled_speed(turning, grid.rate_hz, vehicle);
  const Eigen::MatrixXd p = position ? take(*position, "position") : Eigen::MatrixXd::Zero(fine, 3);
  Eigen::MatrixXd v;
  if (velocity)
    v = take(*velocity, "velocity");
  else if (position)
    v = differentiate(p, grid.rate_hz);
  else
    v = Eigen::MatrixXd::Zero(fine, 3);
  f.has_position = position != nullptr;
  if (!position) f.notes.push_back("No position: effects that depend on height or place are not offered.");
  if (!velocity && !position) f.notes.push_back("No velocity: drag is not offered.");
  Eigen::MatrixXd w =
      gyro ? take(*gyro, "gyro", missing(*gyro, 1))
           : rate_from_attitude(on_grid(*attitude_used, grid, o, missing(*attitude_used, 2)).x, grid.rate_hz);
  f.has_gyro = gyro != nullptr;
  const Eigen::MatrixXd dw = differentiate(w, grid.rate_hz);
  Eigen::MatrixXd force;
  f.has_accelerometer = acc != nullptr;
  if (acc) {
    force = take(*acc, "acc", missing(*acc, 0));
    if ((velocity || position) &&
        force_is_in_world(force, differentiate(v, grid.rate_hz), q, use, o.environment.gravity)) {
      for (Eigen::Index i = 0; i < fine; ++i)
        force.row(i) = (quaternion(q, i).conjugate() * Vec3(force.row(i))).transpose();
      f.notes.push_back("'acc' follows the world's axes, not the body's: it was turned into the body.");
    }
  } else {
    force = velocity ? differentiate(on_grid(*velocity, grid, o, missing(*velocity, 1)).x, grid.rate_hz)
                     : differentiate(
                           differentiate(on_grid(*position, grid, o, missing(*position, 2)).x, grid.rate_hz),
                           grid.rate_hz);
    for (Eigen::Index i = 0; i < fine; ++i)
      force.row(i) =
          (quaternion(q, i).conjugate() * (Vec3(force.row(i)) + o.environment.gravity * Vec3::UnitZ()))
              .transpose();
    f.notes.push_back("No accelerometer: acceleration is the derivative of the velocity.");
  }
  Eigen::MatrixXd alpha = Eigen::MatrixXd::Zero(fine, 1);
  if (const Signal* a = recording.find("alpha")) {
    alpha = take(*a, "alpha");
    f.has_alpha = true;
  } else if (vehicle.tilt.kind != vehicle::TiltKind::none) {
    f.notes.push_back("No tilt angle: it is taken as zero.");
  }
  if (gyro && !f.speed_from_command) {
    const auto lag = lag_behind_rotors(dw, speed, turning, alpha, grid.rate_hz, use, vehicle);
    if (lag)
      f.alignment.push_back(
          {"rotor_speed (torque)", "gyro", lag->lag_s, lag->se_s, 0, 0, std::sqrt(lag->explained)});
    if (lag && std::abs(lag->lag_s) > kLeastTorqueLag + 3 * lag->se_s)
      for (Eigen::MatrixXd* s : {&speed, &turning}) *s = delayed(*s, lag->lag_s, grid.rate_hz);
  }
  const Signal* reference = recording.find("ref_position");
  Eigen::MatrixXd ref;
  if (reference && position) ref = on_grid(*reference, grid, o).x;

  if (f.thrust_modelled) {
    const double scale = lift_scale(speed, alpha, force, p, position != nullptr, vehicle);
    speed *= std::sqrt(scale);
    turning *= std::sqrt(scale);
  }
  physics::Environment environment = o.environment;
  Ground contact = find_ground(p, position != nullptr, speed, force, q, grid.rate_hz, vehicle, o);
  if (recording.find("phase")) {  // it says itself when it flew; before, it may hang instead of stand
    contact.known = false;
    std::fill(contact.resting.begin(), contact.resting.end(), 0);
  }
  if (!o.floor_told && contact.known) {
    f.stood_at = contact.height;
    environment.floor_z = contact.height - kLeastHubHeight * mean_radius(vehicle);
  }
  f.floor_z = environment.floor_z;
  if (source->speed.name == "thrust_model") spins_up(vehicle, grid.rate_hz, contact.resting);
  exclude(contact.resting, grid, 0.1, "standing on the ground", use, f.excluded);
  exclude(contact.crashed, grid, 0.3, "crash", use, f.excluded);

  // too little thrust to fly: on the ground or falling
  std::vector<char> ground(grid.t.size());
  for (Eigen::Index i = 0; i < fine; ++i)
    ground[static_cast<std::size_t>(i)] =
        push_at(speed, i, vehicle) < 0.25 * vehicle.mass * o.environment.gravity;
  exclude(ground, grid, contact.known ? 0.15 : 1.0, "rotors too slow to fly", use, f.excluded);
  for (const SensorFault& fault : f.faults) {
    if (fault.effect != physics::effect_id::rotor_speed_sensor_fault || f.speed_from_command) continue;
    // listed only: the wrench of such a flight is not judged at all
    std::vector<char> untouched = use;
    exclude(frozen_samples(*rotor, fault.channel, grid.t), grid, o.margin_s, fault.channel + " is stuck",
            untouched, f.excluded);
  }
  // saturation: a regression would see the limit, not the physics
  std::vector<char> saturated(grid.t.size(), 0);
  for (Eigen::Index i = 0; i < fine && !f.thrust_modelled; ++i)
    for (Eigen::Index r = 0; r < speed.cols(); ++r)
      if (std::abs(speed(i, r)) > 1.1 * vehicle.rotors[static_cast<std::size_t>(r)].max_speed())
        saturated[static_cast<std::size_t>(i)] = 1;
  exclude(saturated, grid, 0.05, "rotor speed beyond the vehicle's limit", use, f.excluded);

  const int margin = static_cast<int>(o.margin_s * grid.rate_hz);
  for (int i = 0; i < std::min(margin, fine); ++i)
    use[static_cast<std::size_t>(i)] = use[static_cast<std::size_t>(fine - 1 - i)] = 0;

  const std::vector<physics::NeighbourTrack> neighbours = neighbours_of(recording, o);
  const Eigen::MatrixXd dspeed = differentiate(turning, grid.rate_hz);
  const Eigen::MatrixXd asked = reference_motion(recording, grid, o);

  // decimate to the grid
  f.rate_hz = o.grid_hz;
  for (const Signal* used : {attitude_used, rotor, acc, gyro, position, velocity})
    if (used) f.reach_s = std::max(f.reach_s, used->median_period_s());
  const int n = fine / grid.step;
  f.specific_force.resize(n, 3);
  f.rotor_speed.resize(n, speed.cols());
  f.reference.resize(n, asked.cols());
  if (ref.size() > 0) f.tracking_error.resize(n, 3);
  f.situation.resize(static_cast<std::size_t>(n));
  std::vector<char> good(static_cast<std::size_t>(n));
  std::vector<double> s(static_cast<std::size_t>(speed.cols())), ds(s.size());
  for (int k = 0; k < n; ++k) {
    const Eigen::Index i = static_cast<Eigen::Index>(k) * grid.step;
    f.t.push_back(grid.t[static_cast<std::size_t>(i)]);
    good[static_cast<std::size_t>(k)] = use[static_cast<std::size_t>(i)];
    RigidState body;
    body.p_WB = p.row(i).transpose();
    body.q_WB = quaternion(q, i);
    body.v_WB_W = v.row(i).transpose();
    body.w_WB_B = w.row(i).transpose();
    for (Eigen::Index r = 0; r < speed.cols(); ++r) {
      s[static_cast<std::size_t>(r)] = speed(i, r);
      ds[static_cast<std::size_t>(r)] = dspeed(i, r);
    }
    physics::Situation& x = f.situation[static_cast<std::size_t>(k)];
    physics::prepare(vehicle, body, alpha(i, 0), s, ds, environment, x);
    x.t = f.t.back();
    physics::set_neighbours(neighbours, x.t, x);
    x.a_WB_B = Vec3(force.row(i)) + x.g_B;
    x.dw_WB_B = dw.row(i).transpose();
    f.specific_force.row(k) = force.row(i);
    f.rotor_speed.row(k) = speed.row(i);
    f.reference.row(k) = asked.row(i);
    if (ref.size() > 0) f.tracking_error.row(k) = p.row(i) - ref.row(i);
    if (!is_finite(body) || !f.specific_force.row(k).allFinite()) good[static_cast<std::size_t>(k)] = 0;
  }
  if (f.thrust_modelled) {
    f.log_drive = f.log_voltage = Eigen::VectorXd::Zero(n);
    const Signal* vbat = recording.find("vbat");
    const Eigen::MatrixXd volt = vbat ? recording::resample(*vbat, f.t) : Eigen::MatrixXd::Ones(n, 1);
    const double mean = vbat ? vbat->values.mean() : 1.0, top = f.rotor_speed.cwiseAbs().mean();
    for (int k = 0; k < n; ++k) {
      f.log_drive[k] = std::log(std::clamp(f.rotor_speed.row(k).cwiseAbs().mean() / top, 0.2, 5.0));
      if (std::isfinite(volt(k, 0))) f.log_voltage[k] = std::log(std::clamp(volt(k, 0) / mean, 0.3, 3.0));
    }
  }
  if (const Signal* aid = recording.find("position"); aid && velocity && velocity->name == "est_velocity")
    cut_unaided(unaided(*aid, grid, o.max_gap_s), grid, good, f);
  if (repaired.clock_moved) {  // as recorded, since that is what the reader of a report has
    const auto late = std::find_if(f.alignment.begin(), f.alignment.end(),
                                   [](const Alignment& a) { return a.early == "rotor_speed (torque)"; });
    f.alignment.erase(f.alignment.begin(), late);
    f.alignment.insert(f.alignment.begin(), repaired.alignment.begin(), repaired.alignment.end());
  }
  f.segments = long_runs(good, f.rate_hz);
  const auto most = std::max_element(
      f.excluded.begin(), f.excluded.end(),
      [](const Window& a, const Window& b) { return a.to_s - a.from_s < b.to_s - b.from_s; });
  if (f.usable() < 2 * f.rate_hz)
    return bad_input("less than 2 s of uninterrupted free flight is left after cutting " +
                         std::to_string(f.excluded.size()) + " windows" +
                         (most == f.excluded.end() ? "" : " (" + most->why + ", ...)"),
                     recording.file, "Check the vehicle, or give a longer flight");
  return f;
}

}  // namespace omniflight::diagnosis

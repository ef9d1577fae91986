// What a diagnosis assumes and how strict it is.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "omniflight_physics/effect.hpp"
#include "omniflight_physics/neighbour_track.hpp"
#include "omniflight_physics/situation.hpp"
#include "omniflight_recording/recording.hpp"

namespace omniflight::diagnosis {

/// An exact number is told as 0; whitened columns of nothing have no direction.
inline constexpr double kLeastTolerance = 1e-6;

/// How well the numbers of the vehicle and the sensors are known: deviations below these are no finding.
/// One standard deviation each; they enter the fit as unnamed offsets with this prior.
struct Tolerance {
  /// Kinds of numbers of which the laboratory told how well they are known (names of
  /// RegressionProblem::calibration().kinds). Of others a flight may show that they were measured better or
  /// worse than is assumed below.
  std::set<std::string> told;
  double thrust_scale = 0.01;            ///< 1, thrust coefficient and mass together
  double accelerometer_lateral = 0.15;   ///< m/s^2, bias and mounting tilt
  double accelerometer_vertical = 0.05;  ///< m/s^2
  /// Scale [1] and alignment [rad] of the accelerometer's axes. They follow the force, a bias stays: a
  /// vehicle that turns over tells them apart. 0: perfect, as far as the bias does not cover them.
  double accelerometer_scale = 0, accelerometer_misalignment = 0;
  double gyro_bias = 0.008;     ///< rad/s, one standard deviation
  double world_force = 0.005;   ///< 1, constant force in the world over weight (level, alignment)
  double rotor_clock = 0.0015;  ///< s, rotor speeds against accelerometer and gyro
  double pose_clock = 0.005;    ///< s, stamps of the pose against those of accelerometer and gyro
  /// 1, of the day against the one at which thrust was measured: pressure and temperature by 2 % each;
  /// nothing where the density is told.
  double air_density = 0.025;
  /// Of the vehicle file: numbers of a vehicle that was measured with ordinary means.
  double inertia = 0.08;         ///< 1, each principal moment of inertia
  double center_of_mass = 0.02;  ///< 1, over the largest arm
  double rotor_scale = 0.02;     ///< 1, each rotor by itself
  double rotor_axis = 0.01;      ///< rad, each rotor by itself
  double rotor_place =
      0.01;  ///< 1, over the largest arm, each rotor by itself and along each axis of its plane
  double drag_torque = 0.1;    ///< 1, drag torque over thrust, all rotors together
  double motor_lag = 0.2;      ///< 1, time constants of motors whose speed is not measured
  double imu_position = 0.03;  ///< 1, over the largest arm
  double torque_trim = 0.03;   ///< 1, constant torque over weight times largest rotor arm
  /// How unevenly motors of one kind share a load: torque over weight times mean arm.
  double motor_lateral = 0.03, motor_yaw = 0.06;
  /// When thrust is only modelled from duty cycles: its scale, its exponent and its dependence on voltage.
  double modelled_scale = 0.3, modelled_exponent = 0.2, modelled_voltage = 0.6, modelled_trim = 0.3;

  /// Of a kind of numbers that may be told; throws std::out_of_range for any other.
  double& value(const std::string& kind);
  double value(const std::string& kind) const { return const_cast<Tolerance&>(*this).value(kind); }
};

/// What is told of disturbances that are no effect. 0: not told.
struct ToldNoise {
  double force = 0, torque = 0;  ///< N, Nm: RMS of turbulence along and about each axis of the body
  double correlation_time = 0;   ///< s, of turbulence
  double accelerometer = 0;      ///< m/s^2, RMS a sample and axis
  double gyro = 0;               ///< rad/s
  double position = 0;           ///< m
  double attitude = 0;           ///< rad, about each axis

  bool of_turbulence() const { return force > 0 && torque > 0 && correlation_time > 0; }
};

/// Gains that a controller is said to have; its command is then replayed on the recorded state.
struct ToldController {
  Vec3 kp = Vec3::Zero(), kv = Vec3::Zero(), ki = Vec3::Zero();  ///< 1/s^2, 1/s, 1/s^3: position, world
  Vec3 kR = Vec3::Zero(), kw = Vec3::Zero(), kI = Vec3::Zero();  ///< 1/s^2, 1/s, 1/s^3: attitude, body
};

/// What the method assumes or does and an ablation leaves out, to count what it is worth; what each of them
/// is stands in docs/explanation/diagnosis_method.md.
enum class Assumption {
  law_error,            ///< laws are right within a relative error; without: exact
  resolution,           ///< evidence resolves no better than laws do; without: every nat counts
  initial_states,       ///< memories begin anywhere; without: at rest
  load_starts,          ///< loads are fitted from some points of their grid; without: from the best
  instruments,          ///< regressors are predicted; without: as measured
  horizons,             ///< the prediction horizon is tested; without: the shortest
  tolerance_factors,    ///< the flight tells how well its vehicle was measured; without: as assumed
  told_totals,          ///< totals that are told bind their parts; without: they do not
  told_noise,           ///< noise is about what is told; without: of any size
  spectrum_correction,  ///< smooth corrections of noise spectra; without: none
  occurrence,           ///< effects are rare in their own ways; without: equally likely
  unknown_physics,      ///< smooth functions and pulsations beside the library; without: the library alone
  velocity_observer,    ///< velocity of poses by an observer; without: differentiated
  late_thrust,          ///< a response of thrust to speed is compensated; without: it is not
  heavy_tails  ///< errors of drives and lone samples of the wrench have heavy tails; without: Gaussian
};

struct Options {
  double law_error = 0.1;  ///< 1, RMS of the relative error of a law of the library
  /// Divides log-likelihoods, for what the model has wrong; the second where turbulence and the noise of the
  /// sensors are told.
  double temperature = 2.5, told_temperature = 1.5;
  physics::Environment environment;
  Vec3 imu_position = Vec3::Zero();  ///< m, body: where the accelerometer is
  Tolerance tolerance;
  ToldNoise noise;
  double grid_hz = 40.0;             ///< regression grid: signals are averaged over its periods
  double max_gap_s = 0.08;           ///< longer gaps in a needed signal are cut out
  double margin_s = 0.25;            ///< cut on both sides of every gap and of the ends
  int threads = 1;                   ///< the search runs on; the answer is the same
  std::set<Assumption> without;      ///< left out, in an ablation
  std::vector<std::string> only;     ///< candidate ids; empty: the whole library
  std::vector<std::string> exclude;  ///< ids that are not offered
  /// Prior probabilities that effects are left out, by id, where more is known of this vehicle than how often
  /// they occur (physics::occurrence).
  std::map<std::string, double> inclusion;
  /// Flights of the same vehicle in good order, where only the balance of the motors can be judged: it is
  /// held against theirs.
  std::vector<recording::Recording> baseline;
  bool rollouts = true;

  /// Other multirotors during the flight, on the recording's clock.
  std::vector<physics::NeighbourTrack> neighbours;
  bool has_controller = false;
  ToldController controller;
  bool floor_told = false;  ///< environment.floor_z is known; otherwise a resting height is taken for it
  /// Asked between steps of long work; true ends it and keeps what is known. May be empty.
  std::function<bool()> stop;
  bool stopped() const { return stop && stop(); }
  bool assumes(Assumption a) const { return !without.contains(a); }
  /// Of laws in evidences.
  double error_of_laws() const { return assumes(Assumption::law_error) ? law_error : 0.0; }
};

}  // namespace omniflight::diagnosis

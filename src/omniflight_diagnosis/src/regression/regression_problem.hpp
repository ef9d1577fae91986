// The wrench residual of all flights, and what each hypothesis contributes to it, in the order that inference
// needs: regressors at one sample depend on measurements up to the sample before (predetermined), so that the
// direct prediction-error method is consistent under feedback (Ljung, System Identification, ch. 13).
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "commanded_wrench.hpp"
#include "omniflight_diagnosis/flight.hpp"
#include "omniflight_physics/prior.hpp"
#include "predetermined.hpp"

namespace omniflight::diagnosis {

/// An uninterrupted stretch of samples [begin, end) of one flight.
struct Stretch {
  int begin = 0, end = 0;
  int flight = 0;
  int size() const { return end - begin; }
};

/// An effect at parameter values; `start` are the offsets of its memory at the start of each memory window,
/// start_spread().size() numbers a window, empty for an effect whose start is known.
struct EffectTerm {
  const physics::Effect* effect = nullptr;
  std::vector<double> theta;
  Eigen::VectorXd start;
};

/// Where regressors are evaluated: at states, rotors and accelerations as measured, or as the samples before
/// predict them. What is measured correlates with the noise under feedback; its prediction does not.
enum class States { predicted, measured };

/// What is known only within a tolerance: columns for one standard deviation each (prior N(0, 1)).
struct Calibration {
  std::vector<std::string> names;
  Eigen::MatrixXd columns;   ///< rows x names, at predicted states
  Eigen::MatrixXd measured;  ///< the same at measured ones
  /// Which columns are tolerances of one kind (rotor axes, centre of mass, ...), measured by the same means.
  std::vector<std::string> kinds;
  /// Share of each column's variance that is no matter of how well the vehicle was measured; one where the
  /// laboratory told its tolerance.
  Eigen::VectorXd settled;
  /// ln of the tolerances that the laboratory told over those that are assumed where nothing is told.
  std::vector<double> told;
  /// Totals of level hover: what one standard deviation of each column adds to the force in the world and the
  /// torque in the body, over the deviation that was told of that total. 6 x names; rows of totals of which
  /// nothing was told are zero, and so are columns that are a total themselves.
  Eigen::MatrixXd totals;

  /// Standard deviations over those of the columns where each tolerance is `scale` times what it is here.
  Eigen::VectorXd deviations(const Eigen::VectorXd& scale) const {
    return (settled.array() + scale.array().square() * (1 - settled.array())).sqrt();
  }
};

/// Rows are channel-major: row(channel, i) = channel * samples + i; channels Fx Fy Fz [N] Mx My Mz [Nm],
/// body.
class RegressionProblem {
 public:
  RegressionProblem(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                    const Options& options, Horizon horizon);

  int samples() const { return n_; }
  int rows() const { return 6 * n_; }
  int flights() const { return flight_count_; }
  double period() const { return period_; }
  bool forces_only() const { return forces_only_; }
  const std::vector<Stretch>& stretches() const { return stretches_; }
  /// Parts of stretches after which the memory of an effect begins anew with free initial states.
  const std::vector<Stretch>& memory_windows() const { return windows_; }
  const Eigen::VectorXd& residual() const { return y_; }
  const Calibration& calibration() const { return *calibration_; }
  /// Whether turbulence and the noise of the sensors are told, for all flights.
  bool noise_told() const { return sensor_noise_.size() > 0; }
  const ToldNoise& told_noise() const { return told_noise_; }
  /// Whether noise spectra have a smooth correction.
  bool spectra_corrected() const { return corrected_; }
  /// Whether lone samples may have more than noise of a spectrum.
  bool heavy_tails() const { return heavy_tails_; }
  /// Divides log-likelihoods of the residual.
  double temperature() const { return temperature_; }
  /// A draw of what the told noise of the sensors does to the residual; all rows.
  const Eigen::VectorXd& sensor_noise() const { return sensor_noise_; }
  /// Flight::kernel_s of a flight.
  double kernel(int flight) const { return kernel_s_[static_cast<std::size_t>(flight)]; }
  /// Multiplies the predicted calibration columns, by their first stages.
  void scale_calibration(const Eigen::VectorXd& factors) {
    auto scaled = std::make_shared<Calibration>(*calibration_);
    scaled->columns = calibration_->columns * factors.asDiagonal();
    calibration_ = std::move(scaled);
  }
  /// Predicted accelerations from now on are those that the rotors give together with this wrench (all rows,
  /// N and Nm): what has mass weighs by the acceleration that the vehicle has with it, and not by that of the
  /// nominal one, which a heavy load or a weak rotor would not have. The measured acceleration does not
  /// enter: a load and a weak thrust would differ by how well each is predicted, and by nothing else.
  void expect(const Eigen::VectorXd& wrench);
  /// The same with what these terms do at the accelerations that the vehicle has with them.
  void expect(std::span<const EffectTerm> terms);
  /// Whether accelerations are expected with this wrench as they are, to a thousandth of the weight (RMS).
  bool expects(const Eigen::VectorXd& wrench) const;
  /// State, rotors and accelerations as predicted from the samples before.
  std::span<const physics::Situation> situations() const { return situation_; }
  const physics::Situation& situation(int i) const { return situation_[static_cast<std::size_t>(i)]; }
  const physics::Situation& measured(int i) const { return (*measured_)[static_cast<std::size_t>(i)]; }
  const physics::VehicleSize& size() const { return size_; }
  /// Natural size of a channel: weight [N], or weight times the longest lever about this axis [Nm].
  double scale(int channel) const { return channel < 3 ? size_.weight : size_.weight * lever_[channel - 3]; }

  /// Prior of a parameter, with places relative to where these flights were.
  physics::ParameterPrior prior(const physics::Effect& effect, std::size_t parameter) const;

  /// Wrench of a term over all samples and, unless null, its derivatives by theta and by start.
  void wrench_of(const EffectTerm& term, Eigen::VectorXd& value, Eigen::MatrixXd* by_theta,
                 Eigen::MatrixXd* by_start, States states = States::predicted) const;
  /// What it does to the wrench of rotors whose speeds come from commands that these take effect `late_s` [s]
  /// later; zero where speeds are recorded. All rows.
  Eigen::VectorXd of_command_delay(double late_s, States states) const;
  /// Sum of the wrenches of terms over all samples.
  Eigen::VectorXd wrench_of(std::span<const EffectTerm> terms, States states = States::predicted) const;

 private:
  void between_command_and_speed(const EffectTerm& term, Eigen::VectorXd& value, Eigen::MatrixXd* by_theta,
                                 States states) const;
  void replay(const EffectTerm& term, Eigen::VectorXd& value, Eigen::MatrixXd* by_theta,
              Eigen::MatrixXd* by_start, States states) const;
  const std::vector<physics::Situation>& at(States states) const {
    return states == States::predicted ? situation_ : *measured_;
  }

  int n_ = 0, flight_count_ = 0;
  bool forces_only_ = false;
  double period_ = 0;  ///< s
  physics::VehicleSize size_;
  Mat6 inertia_;
  Vec3 lever_ = Vec3::Ones();
  Vec3 lowest_ = Vec3::Zero(), highest_ = Vec3::Zero(), mean_ = Vec3::Zero();  ///< m, where they flew
  std::vector<Stretch> stretches_, windows_;
  std::vector<physics::Situation> situation_;
  // what copies share, which differ by the accelerations that they expect
  std::shared_ptr<const std::vector<physics::Situation>> measured_;
  std::shared_ptr<const CommandedWrench> commanded_;
  std::shared_ptr<const Calibration> calibration_;
  Eigen::VectorXd expected_;  ///< wrench besides that of the rotors, in predicted accelerations
  Eigen::VectorXd y_;
  ToldNoise told_noise_;
  // unless an ablation takes regressors as measured, noise as Gaussian, spectra as fitted
  bool predicted_, heavy_tails_, corrected_;
  double temperature_ = 1;
  Eigen::VectorXd sensor_noise_;
  std::vector<double> kernel_s_;
};

}  // namespace omniflight::diagnosis

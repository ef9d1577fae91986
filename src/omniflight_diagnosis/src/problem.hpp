// The wrench residual of all flights stacked, and the columns that may explain it.
#pragma once

#include <array>
#include <list>
#include <map>
#include <memory>
#include <span>

#include "column_memory.hpp"
#include "omniflight_diagnosis/flight.hpp"
#include "omniflight_diagnosis/residual.hpp"
#include "omniflight_physics/effect.hpp"
#include "plausible.hpp"

namespace omniflight::diagnosis {

inline constexpr std::array<const char*, 6> kChannels{"Fx", "Fy", "Fz", "Mx", "My", "Mz"};
inline const char* channel_unit(int channel) { return channel < 3 ? "N" : "Nm"; }

/// The unit of a coefficient of what has this one: "N", "N/m", "Nm/(rad/s)", "N/(m/s)2".
inline std::string unit_per(int channel, const std::string& unit) {
  if (unit == "1") return channel_unit(channel);
  const bool simple = unit.front() == '(' || unit.find_first_of(" /") == std::string::npos;
  return std::string(channel_unit(channel)) + (simple ? "/" + unit : "/(" + unit + ")");
}

/// An uninterrupted stretch of stacked rows [begin, end).
struct Run {
  int begin = 0, end = 0;
  int flight = 0;
};

/// Rows are channel-major: row(channel, i) = channel * n + i.
class Whitening;

class Problem {
 public:
  Problem(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle, const Options& options);

  /// Every so many samples of what a fit has left, as if they were white: for a quick look at laws that act
  /// at once.
  Problem thinned(const Eigen::VectorXd& residual, int every) const;

  /// Noise of these flights, see noise_model(); under it all fits are done.
  const Whitening& noise() const { return *noise_; }

  int samples() const { return n_; }
  int rows() const { return 6 * n_; }
  const std::vector<Run>& runs() const { return runs_; }
  int flights() const { return flight_count_; }
  const Eigen::VectorXd& residual() const { return y_; }
  const physics::Situation& situation(int i) const { return situation_[static_cast<std::size_t>(i)]; }

  /// Offsets known only within a tolerance: columns per unit and prior standard deviations.
  const Eigen::MatrixXd& offsets() const { return offsets_; }
  const Eigen::VectorXd& offset_sigma() const { return offset_sigma_; }
  const std::vector<std::string>& offset_names() const { return offset_names_; }

  /// The derivative that predict() gives, under noise(). Columns that never change are whitened once.
  Eigen::MatrixXd whitened(const std::vector<physics::ActiveEffect>& effects,
                           const Eigen::MatrixXd& jacobian) const;
  /// X'X and X'r of the columns X that whitened() gives, without them side by side; what never changes in X'X
  /// is computed once.
  struct NormalEquations {
    Eigen::MatrixXd H;
    Eigen::VectorXd g;
  };
  NormalEquations normal_equations(const std::vector<physics::ActiveEffect>& effects,
                                   const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& r) const;
  /// Whitened columns of laws that bend.
  ColumnMemory& memory() const { return *memory_; }

  /// Natural size of a channel: weight [N], or weight times the longest lever of a rotor about this axis
  /// [Nm].
  double scale(int channel) const { return channel < 3 ? weight_ : weight_ * lever_[channel - 3]; }
  /// What makes sense for a vehicle of this size: mass and inertia stay positive, and a regression on noisy
  /// rotor torques does not make the body as heavy as it takes for nothing to move.
  Range range(const physics::Effect& effect, std::size_t parameter) const {
    return plausible_range(effect, parameter, vehicle_scale_);
  }
  const VehicleScale& vehicle_scale() const { return vehicle_scale_; }
  /// Effects are evaluated on the flight as its reference alone makes it, see Flight::instrument.
  bool instrumented() const { return instrumented_; }
  /// A flight among them left the floor, or came back to it.
  bool took_off() const { return took_off_; }
  /// Its columns never change: it is linear, remembers nothing, and what mass or inertia it has moves as the
  /// instruments say, or there is none.
  bool has_constant_columns(const physics::Effect& effect) const;
  /// Inertia among them that the measured acceleration does not move: it weakens what all others do.
  bool has_inertia(const std::vector<physics::ActiveEffect>& effects) const;
  /// Torques are not judged: thrusts are only modelled.
  bool forces_only() const { return forces_only_; }

  /// Columns of the parameters `free` of an effect without added inertia, from their neutral values, at which
  /// it does nothing, at these shapes: exact where it is linear in them. Cheaper than the derivatives by all
  /// parameters.
  void amplitude_columns(const physics::Effect& effect, std::vector<double> theta,
                         const std::vector<Eigen::Index>& free, Eigen::MatrixXd& columns) const;

  /// What remains of the residual with these effects and offsets, and its negative derivative by all effect
  /// parameters (in order) and the offsets.
  ///
  /// With added inertia I the measured acceleration stands on both sides of the equation of motion; the rest
  /// is therefore the error of the *predicted* acceleration times the nominal inertia, M0 (M0 + I)^-1 e, and
  /// the derivatives are taken at the predicted acceleration. Otherwise a mass of -m would explain
  /// everything. On instruments (Flight::instrument) it does not, and the rest is that of the wrench.
  void predict(const std::vector<physics::ActiveEffect>& effects, const Eigen::VectorXd& offset_values,
               Eigen::VectorXd& rest, Eigen::MatrixXd* jacobian) const;

 private:
  struct Constant {
    Eigen::MatrixXd columns, whitened;
  };
  const Constant& constant(const physics::Effect& effect) const;
  /// What a law that bends does at these values: the others beside it are asked one after another.
  struct Bent {
    physics::ActiveEffect at;
    Eigen::VectorXd value;
    Eigen::MatrixXd columns, whitened;  ///< whitened when first asked for
  };
  const Bent& bent(const physics::ActiveEffect& at) const;
  /// Null where that is not known.
  Bent* remembered(const physics::ActiveEffect& at) const;
  /// Whitened columns that are kept, of an effect at these values; null where they are not.
  const Eigen::MatrixXd* kept(const physics::ActiveEffect& at, bool beside_inertia) const;
  /// Of whitened columns that never change; null stands for the offsets.
  const Eigen::MatrixXd& product(const physics::Effect* left, const physics::Effect* right) const;
  /// Wrench of an effect over all samples and, unless null, its derivative by all parameters.
  void wrench_of(const physics::ActiveEffect& effect, Eigen::VectorXd& value,
                 Eigen::MatrixXd* jacobian) const;

  std::shared_ptr<const Whitening> noise_;
  int n_ = 0, flight_count_ = 0;
  bool forces_only_ = false, took_off_ = false, instrumented_ = false;
  double period_ = 0;  ///< s, of the grid
  double weight_ = 1;
  Vec3 lever_ = Vec3::Ones();  ///< m, of a rotor's thrust about the body axes
  VehicleScale vehicle_scale_;
  std::vector<Run> runs_;
  mutable std::vector<physics::Situation> situation_;
  std::vector<Vec6> acceleration_;  ///< measured, (a_WB_B, dw_WB_B)
  Mat6 inertia_;                    ///< nominal, about the body origin
  Eigen::VectorXd y_;               ///< nominal residual
  Eigen::VectorXd fast_;            ///< its part from thrusts above the effects' low pass
  Eigen::MatrixXd offsets_;
  Eigen::VectorXd offset_sigma_;
  std::vector<std::string> offset_names_;
  Eigen::MatrixXd whitened_offsets_;
  mutable std::map<const physics::Effect*, Constant> linear_;
  mutable std::map<std::pair<const physics::Effect*, const physics::Effect*>, Eigen::MatrixXd> products_;
  mutable std::list<Bent> bent_;  ///< the latest first
  std::shared_ptr<ColumnMemory> memory_ = std::make_shared<ColumnMemory>();
};

/// Neither memory nor inertia of its own.
bool acts_at_once(const physics::Effect& effect);
/// The vehicle gets heavier or larger in inertia with it.
bool adds_inertia(const physics::Effect& effect);
bool is_linear(const physics::Effect& effect);

}  // namespace omniflight::diagnosis

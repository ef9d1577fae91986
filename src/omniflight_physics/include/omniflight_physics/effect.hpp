// One left-out effect: the same object is flown by the simulator, offered as a hypothesis by the diagnosis
// and printed by the documentation.
#pragma once

#include <ceres/jet.h>

#include <memory>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"
#include "omniflight_physics/situation.hpp"

namespace omniflight::physics {

/// Where along the chain reference -> ... -> power a mismatch sits.
enum class Stage { reference, control, allocation, actuation, wrench, motion, sensing, power };
std::string to_string(Stage stage);

struct Parameter {
  std::string name;    ///< "linear_density"
  std::string symbol;  ///< "lambda"
  std::string unit;    ///< "kg/m"
  double lower = 0;    ///< smallest value that makes sense
  double upper = 0;
  double typical = 0;  ///< a value of ordinary size, where a search may start
  double neutral = 0;  ///< value at which the effect is exactly nothing (for a shape parameter: typical)
  bool linear = true;  ///< the wrench is linear in it while the shape parameters are fixed
};

struct EffectInfo {
  std::string id;        ///< contracts: "hung_cable"
  std::string term;      ///< the field's standard term
  std::string equation;  ///< plain text
  std::string latex;
  std::string source;  ///< paper, code or text the equation comes from
  std::vector<Parameter> parameters;
  std::vector<std::string> signals;   ///< canonical signals it needs in a recording
  std::vector<std::string> channels;  ///< "Fx" ... "Mz", "rotor_speed", "acc", ...
  Stage stage = Stage::wrench;
  std::vector<std::string> aliases;  ///< ids it cannot be told from on some flights
  std::string separated_by;          ///< the manoeuvre that separates it from its aliases
};

/// What stands between a rotor speed command and the speed; effects change it before a flight.
struct Actuation {
  std::vector<double> time_constant;  ///< s, a rotor
  std::vector<double> delay;          ///< s, a rotor
};

/// How the sensors differ from ideal ones; effects change it before a flight.
struct Sensing {
  Vec3 accelerometer_bias = Vec3::Zero();   ///< m/s^2
  Vec3 accelerometer_scale = Vec3::Zero();  ///< 1
  Vec3 gyro_bias = Vec3::Zero();            ///< rad/s
  Vec3 mocap_tilt = Vec3::Zero();           ///< rad, rotation vector measured <- true world
};

inline constexpr int kMaxParameters = 8;

class Effect {
 public:
  virtual ~Effect() = default;
  virtual const EffectInfo& info() const = 0;

  /// True when the effect answers with a wrench (and may be regressed on wrench residuals).
  virtual bool acts_on_wrench() const { return false; }
  /// Adds its wrench at parameter values theta (info().parameters order, SI).
  virtual void add_wrench(const Situation&, const double* /*theta*/, Wrench&) const {}
  /// Total wrench with known accelerations (6) and its exact derivative (6 x parameters, column-major).
  virtual void wrench_with_jacobian(const Situation&, const double* /*theta*/, double* /*wrench*/,
                                    double* /*jacobian*/) const {}

  virtual void alter_actuation(const vehicle::Vehicle&, const double* /*theta*/, Actuation&) const {}
  virtual void alter_sensing(const double* /*theta*/, Sensing&) const {}

  int parameter_count() const { return static_cast<int>(info().parameters.size()); }
};

/// Derive a wrench effect from this: write `template <class T> void wrench(const Situation&, const T* theta,
/// WrenchT<T>& out) const` once; value and exact derivative follow.
template <class Derived>
class WrenchEffect : public Effect {
 public:
  bool acts_on_wrench() const final { return true; }
  void add_wrench(const Situation& s, const double* theta, Wrench& out) const final {
    static_cast<const Derived*>(this)->wrench(s, theta, out);
  }
  void wrench_with_jacobian(const Situation& s, const double* theta, double* value,
                            double* jacobian) const final {
    using Jet = ceres::Jet<double, kMaxParameters>;
    const int n = parameter_count();
    Jet x[kMaxParameters];
    for (int k = 0; k < n; ++k) x[k] = Jet(theta[k], k);
    WrenchT<Jet> out;
    static_cast<const Derived*>(this)->wrench(s, x, out);
    const Eigen::Matrix<Jet, 6, 1> w = out.at(s);
    for (int row = 0; row < 6; ++row) {
      value[row] = w[row].a;
      for (int k = 0; k < n; ++k) jacobian[k * 6 + row] = w[row].v[k];
    }
  }
};

/// The whole library, in the order of the catalogue. Adding an effect is one file and one line in table.cpp.
const std::vector<const Effect*>& builtin_effects();
/// nullptr when there is none with that id.
const Effect* find_effect(const std::string& id);

/// An effect with values: what a model file lists and a simulator flies.
struct ActiveEffect {
  const Effect* effect = nullptr;
  std::vector<double> theta;
};

/// A model file (schema omniflight.model/1): effects with values, on top of a vehicle.
struct Model {
  std::vector<ActiveEffect> effects;
  std::string sha256;  ///< of the file it came from
};

/// Reads `effects: [{id, parameters: {name: value}}]`; a missing parameter takes its typical value. Unknown
/// ids, unknown parameters and values outside the bounds are refused with file, field, value, unit and bound.
Result<Model> load_model(const std::string& path);
/// The YAML text of a model, with units as comments; load_model reads it back to the same values.
std::string model_yaml(const std::vector<ActiveEffect>& effects, const std::string& comment);

}  // namespace omniflight::physics

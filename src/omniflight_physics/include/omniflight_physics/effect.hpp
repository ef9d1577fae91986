// One left-out effect: the same object is flown by the simulator, offered as a hypothesis by the diagnosis
// and printed by the documentation.
#pragma once

#include <ceres/jet.h>

#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "omniflight_core/random.hpp"
#include "omniflight_core/result.hpp"
#include "omniflight_physics/actuation.hpp"
#include "omniflight_physics/pilot_words.hpp"
#include "omniflight_physics/sensing.hpp"
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
  std::vector<std::string> channels;  ///< what it can move, out of known_channels()
  Stage stage = Stage::wrench;        ///< where it acts
  std::vector<std::string> aliases;   ///< ids it cannot be told from on some flights; one of two may say it
  std::string separated_by;           ///< the manoeuvre that separates it from its aliases
  std::vector<Stage> also = {};       ///< further stages at which it shows
  std::vector<std::string> comes_with = {};  ///< ids beside which it is the likeliest of its aliases

  // What engines treat effects by: they know no id. What is left out is the ordinary case.

  /// Why a flight without rotor speeds, whose thrust is only modelled, cannot show it: a clause, which the
  /// diagnosis gives as its reason not to ask for the effect. Empty: such a flight can.
  std::string hidden_by_modelled_thrust = {};
  /// Of a wrench that no recorded motion implies (can_replay() is false): what becomes of it in a diagnosis,
  /// a clause as above.
  std::string not_asked_for = {};
  /// Of an effect that has numbers for every rotor: how many a rotor. Those of rotor r begin at index
  /// r * this; the diagnosis asks for one rotor at a time. 0: its parameters belong to the whole vehicle.
  int parameters_per_rotor = 0;
  /// Its wrench near the floor tells how far below a standing vehicle the floor is, where no file says so.
  bool tells_floor_height = false;
  /// Names of parameters of which a vehicle has one value. A model may list an effect twice, and the two add
  /// up; these must then be the same in both.
  std::vector<std::string> one_value = {};
  /// How a pilot is told of it. Without: by its term and first known parameter.
  PilotWords words = {};
};

/// Fx Fy Fz [N] Mx My Mz [Nm] (wrench of the effects, body axes), rotor_speed, alpha, acc, gyro, position,
/// attitude, stamp (of a pose), voltage, current.
const std::vector<std::string>& known_channels();

inline constexpr int kMaxParameters = 24;  ///< three numbers for each of eight rotors
inline constexpr int kJetParameters = 8;   ///< of an effect whose derivative comes from dual numbers
inline constexpr int kFewParameters = 4;   ///< most effects have no more: half as wide, half the time
template <int N>
using Jet = ceres::Jet<double, N>;
// compiled once, in jets.cpp, and not again by every effect
extern template struct WrenchT<double>;
extern template struct WrenchT<Jet<kFewParameters>>;
extern template struct WrenchT<Jet<kJetParameters>>;

/// Parameters, at most N of them, as independent variables; N is kFewParameters or kJetParameters.
template <int N>
void make_jets(const double* theta, int count, Jet<N>* x);
/// Value (6) and derivative (6 x parameters; column k begins at k * stride) of a wrench with known
/// accelerations.
template <int N>
void split_jets(const WrenchT<Jet<N>>& wrench, const Situation& s, int count, double* value, double* jacobian,
                std::size_t stride = 6);

/// How many numbers an effect remembers: first the continuous states, which the integrator advances with the
/// body by state_rate(), then discrete ones, which advance() changes once a step and which rest in between.
struct MemorySize {
  int continuous = 0, discrete = 0;
  int total() const { return continuous + discrete; }
};

class Effect {
 public:
  virtual ~Effect() = default;
  virtual const EffectInfo& info() const = 0;

  /// True when the effect answers with a wrench (and may be regressed on wrench residuals).
  virtual bool acts_on_wrench() const { return false; }
  /// Adds its wrench at parameter values theta (info().parameters order, SI).
  virtual void add_wrench(const Situation&, const double* /*theta*/, Wrench&) const {}
  /// True when the wrench is a sum over the rotors of thrust times (b + c alpha), where b and c depend on
  /// nothing but the way the thrust axes point: a simulator then adds it to the nominal law, once a tilt.
  virtual bool linear_in_thrust() const { return false; }
  /// Total wrench with known accelerations (6) and its exact derivative (6 x parameters, column-major).
  virtual void wrench_with_jacobian(const Situation&, const double* /*theta*/, double* /*wrench*/,
                                    double* /*jacobian*/) const {}

  /// Of an effect with memory, `memory` points to memory_size().total() numbers that the caller owns; nothing
  /// below allocates. The situation of state_rate and advance has the accelerations.
  virtual MemorySize memory_size() const { return {}; }
  virtual void start_memory(const Situation&, const double* /*theta*/, double* /*memory*/) const {}
  virtual void add_memory_wrench(const Situation&, const double* /*theta*/, const double* /*memory*/,
                                 Wrench&) const {}
  virtual void state_rate(const Situation&, const double* /*theta*/, const double* /*memory*/,
                          double* /*rate*/) const {}
  /// After a step of `step` seconds that ended in this situation: noise, contact, constraints.
  virtual void advance(const Situation&, const double* /*theta*/, double /*step*/, Random&,
                       double* /*memory*/) const {}
  /// True when replay() gives the wrench that a recorded motion implies.
  virtual bool can_replay() const { return acts_on_wrench(); }
  /// Wrench over a recorded motion of uniform period [s] (6 x samples, column-major) and, unless null, its
  /// derivative (6 x samples x parameters); the memory starts as start_memory says.
  virtual void replay(std::span<const Situation> motion, double period, const double* theta, double* wrench,
                      double* jacobian) const;

  /// Values of all parameters, amplitudes neutral, at which the effect would show in this motion: where a
  /// search may begin that would otherwise miss it. Empty: anywhere in the prior.
  virtual std::vector<std::vector<double>> telling_shapes(std::span<const Situation> /*motion*/) const {
    return {};
  }

  /// Prior standard deviations of the continuous states at the start of a recording, which may begin while a
  /// load already swings; 0 for a state that is known. Empty: the memory starts as start_memory says.
  virtual std::vector<double> start_spread(const double* /*theta*/) const { return {}; }
  /// replay() without derivative from start_memory() plus `offset` (start_spread().size() numbers).
  virtual void replay_from(std::span<const Situation> motion, double period, const double* theta,
                           const double* /*offset*/, double* wrench) const {
    replay(motion, period, theta, wrench, nullptr);
  }

  /// Power [W] it takes from the motion of the body (positive: the body loses energy to it).
  double power_taken(const Situation& s, const double* theta, const double* memory = nullptr) const;
  /// Power [W] that the rotors draw because of it, beyond the nominal law.
  virtual double shaft_power(const Situation&, const double* /*theta*/) const { return 0.0; }

  virtual void alter_actuation(const vehicle::Vehicle&, const double* /*theta*/, Actuation&) const {}
  virtual void alter_sensing(const double* /*theta*/, Sensing&) const {}

  /// Of an effect that alters a signal: a form of it that acts on the wrench, for recordings in which the
  /// signal does not show it. Where a servo reports the tilt that it is ordered to, its lag is in no signal,
  /// but in the forces. The form has this effect's id. The diagnosis asks for it right behind the first of
  /// this effect's aliases, and only with it: without that rival it would be named in the rival's place. So
  /// the form needs no signals but those of that alias.
  /// nullptr: there is no such form.
  virtual const Effect* unrecorded_form() const { return nullptr; }
  /// Parameters of this effect that mean what `theta` means to its unrecorded form; others neutral.
  virtual std::vector<double> from_unrecorded_form(const std::vector<double>& theta) const { return theta; }

  /// An error where a vehicle that starts like this cannot have it, as a rope that is shorter than the way up
  /// to its anchor; `where` is parameter_field(). Bounds of parameters have been checked before.
  virtual Status check_feasible(const vehicle::Vehicle&, const RigidState& /*initial*/,
                                const double* /*theta*/) const {
    return {};
  }
  /// "effects.hung_cable.length": how errors name a parameter, by its index.
  std::string parameter_field(std::size_t index) const {
    return "effects." + info().id + "." + info().parameters[index].name;
  }

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
    if (parameter_count() <= kFewParameters)
      differentiate<kFewParameters>(s, theta, value, jacobian);
    else
      differentiate<kJetParameters>(s, theta, value, jacobian);
  }

 private:
  template <int N>
  void differentiate(const Situation& s, const double* theta, double* value, double* jacobian) const {
    Jet<N> x[kJetParameters];  // as many as any equation names
    make_jets<N>(theta, parameter_count(), x);
    WrenchT<Jet<N>> out;
    static_cast<const Derived*>(this)->wrench(s, x, out);
    split_jets<N>(out, s, parameter_count(), value, jacobian);
  }
};

/// Derive a wrench effect with continuous states from this. Write `template <class T> void start(const
/// Situation&, const T* theta, T* x) const`, `... wrench(const Situation&, const T* theta, const T* x,
/// WrenchT<T>& out) const` and `... rate(const Situation&, const T* theta, const T* x, T* dx) const` once;
/// value, replay and exact derivative follow. With Discrete states, which lie behind the continuous ones,
/// also `template <class T> void settle(const Situation&, const T* theta, T* x) const`: it may change them
/// once a step, in a situation with accelerations. Where the states obey a constraint, `template <class T>
/// void restore_constraint(T* x) const` puts them back on it after every step of a replay: at the rate of a
/// recording steps are long.
template <class Derived, int States, int Discrete = 0>
class MemoryEffect : public Effect {
 public:
  MemorySize memory_size() const final { return {States, Discrete}; }
  bool can_replay() const final { return true; }
  void start_memory(const Situation& s, const double* theta, double* x) const final {
    self().start(s, theta, x);
  }
  void add_memory_wrench(const Situation& s, const double* theta, const double* x, Wrench& out) const final {
    self().wrench(s, theta, x, out);
  }
  void state_rate(const Situation& s, const double* theta, const double* x, double* dx) const final {
    self().rate(s, theta, x, dx);
  }
  void advance(const Situation& s, const double* theta, double, Random&, double* x) const final {
    if constexpr (Discrete > 0) self().settle(s, theta, x);
  }
  void replay(std::span<const Situation> motion, double period, const double* theta, double* value,
              double* jacobian) const final {
    if (!jacobian)
      pass_through(motion, period, theta, value, jacobian);
    else if (parameter_count() <= kFewParameters)
      differentiate<kFewParameters>(motion, period, theta, value, jacobian);
    else
      differentiate<kJetParameters>(motion, period, theta, value, jacobian);
  }

  void replay_from(std::span<const Situation> motion, double period, const double* theta,
                   const double* offset, double* value) const final {
    pass_through(motion, period, theta, value, nullptr, offset);
  }

 private:
  template <int N>
  void differentiate(std::span<const Situation> motion, double period, const double* theta, double* value,
                     double* jacobian) const {
    Jet<N> parameters[kJetParameters];
    make_jets<N>(theta, parameter_count(), parameters);
    pass_through(motion, period, parameters, value, jacobian);
  }
  template <class T>
  void pass_through(std::span<const Situation> motion, double period, const T* parameters, double* value,
                    double* jacobian, const double* offset = nullptr) const {
    T x[States + Discrete], trial[States + Discrete], first[States], second[States];
    if (!motion.empty()) self().start(motion[0], parameters, x);
    if (offset && !motion.empty())
      for (int j = 0; j < States; ++j) x[j] += T(offset[j]);
    for (std::size_t i = 0; i < motion.size(); ++i) {
      if (i > 0) {  // Heun: the trapezoid between two samples
        const T h(period);
        self().rate(motion[i - 1], parameters, x, first);
        for (int j = 0; j < States; ++j) trial[j] = x[j] + h * first[j];
        for (int j = States; j < States + Discrete; ++j) trial[j] = x[j];
        self().rate(motion[i], parameters, trial, second);
        for (int j = 0; j < States; ++j) x[j] += T(0.5) * h * (first[j] + second[j]);
      }
      if constexpr (Discrete > 0) self().settle(motion[i], parameters, x);
      if constexpr (requires { self().restore_constraint(x); }) self().restore_constraint(x);
      WrenchT<T> out;
      self().wrench(motion[i], parameters, x, out);
      if constexpr (std::is_same_v<T, double>)
        Eigen::Map<Vec6>(value + 6 * i) = out.at(motion[i]);
      else
        split_jets(out, motion[i], parameter_count(), value + 6 * i, jacobian + 6 * i, 6 * motion.size());
    }
  }
  const Derived& self() const { return static_cast<const Derived&>(*this); }
};

/// The whole library, in the order of the catalogue. Adding an effect is one file and one line in table.cpp.
const std::vector<const Effect*>& builtin_effects();
/// nullptr when there is none with that id.
const Effect* find_effect(const std::string& id);
/// What it may look like: its aliases, then those that list it, in the order of the table.
std::vector<std::string> aliases_of(const EffectInfo& info);

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

/// Reads `effects: [{id, parameters: {name: value}}]`; a missing parameter takes its typical value. Then
/// `corrections`, physics that is in no library (correction.hpp). Unknown ids, unknown parameters and values
/// outside the bounds are refused with file, field, value, unit and bound.
Result<Model> load_model(const std::string& path);
/// The YAML text of a model, with units as comments; load_model reads it back to the same values.
std::string model_yaml(const std::vector<ActiveEffect>& effects, const std::string& comment);

}  // namespace omniflight::physics

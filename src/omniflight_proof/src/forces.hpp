// All forces of a World but gravity, joints and contacts, which are MuJoCo's: applied to its data each time
// step.
#pragma once

#include <vector>

#include "air.hpp"
#include "engine.hpp"
#include "laws.hpp"
#include "motors.hpp"

namespace omniflight::proof {

class Forces {
 public:
  Forces(const vehicle::Vehicle& vehicle, const World& world, const Engine& engine, std::uint64_t seed);
  /// Lets wind and turbulence go on by h to time t.
  void advance(double t, double h);
  /// Writes generalised forces for the state in the engine's data; h is the time since the last call [s].
  void apply(Engine& engine, const Motors& motors, double t, double h);
  Vec3 wind_at(const Vec3& p_W) const { return wind_.at(p_W); }

 private:
  struct Hub {
    Vec3 p_W, axis_W, velocity_W;
    int body;
  };
  Hub hub(const Engine& engine, const Motors& motors, std::size_t i, const Motion& motion) const;
  double image_share(const Vec3& p_W, double radius) const;
  void rotors(Engine& engine, const Motors& motors, const Motion& motion, double h, BodyWrench& out);
  void airframe(const Motion& motion, BodyWrench& out) const;
  void rotor_air(const Hub& hub, double speed, std::size_t i, RotorLoad& load) const;
  void cable_drag(Engine& engine) const;
  void turbulence(double h);
  Vec3 jets_at(const Vec3& p_W) const;

  const vehicle::Vehicle vehicle_;
  const World world_;
  WindField wind_;
  Random rng_;
  Vec6 turbulent_ = Vec6::Zero(), turbulent_first_ = Vec6::Zero(), turbulent_second_ = Vec6::Zero();
  Vec6 turbulent_wrench_ = Vec6::Zero();  ///< N world, N m body
  bool burst_ = false;
  bool blades_on_ = false;  ///< rotor motion matters, not only jets and planes
  std::vector<BladeModel> blades_;
  std::vector<Jet> jets_;  ///< of the rotors, from the last step
  std::vector<Jet> others_;
  std::vector<int> pods_, cable_;
};

}  // namespace omniflight::proof

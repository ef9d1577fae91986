// What can be hidden in a family: an effect of the catalogue in one of its realisations, with one amplitude
// that is turned until the effect has the wanted size. Amplitudes are in the vehicle's own measure (its mass,
// weight, arm, speeds), so that one list serves 37 g and 3 kg.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "case_shape.hpp"
#include "family_flight.hpp"

namespace omniflight::proof {

/// N, N m RMS that a sensor's error looks like; or, where it looks like no wrench, sigma of its own noise.
struct SensorSize {
  std::array<double, 6> wrench{};
  double sigma = 0;
};

struct Hidden {
  enum class Measure {
    wrench,   ///< of the plant: what the motion needs beyond the nominal vehicle
    command,  ///< of the thrusts that commands and the nominal lag do not give
    control,  ///< of the demands that the told controller does not give
    formula   ///< size() says: sensors do not move the vehicle
  };
  std::string id, stage, realisation;
  bool law = false;      ///< the catalogue's own equation; every id has a realisation that is not
  bool unseen = false;   ///< sealed runs only
  bool combines = true;  ///< may be one of two or three
  bool slow = false;     ///< joints to integrate: long to fly
  Measure measure = Measure::wrench;
  double smallest = 1e-4, typical = 0.05, largest = 0.5;                        ///< amplitude
  std::function<bool(const FamilyVehicle&, const Coordinates&)> possible = {};  ///< empty: always
  std::function<void(FamilyFlight&, double, const Shape&)> apply = {};
  /// Empty where the realisation has no such number.
  std::function<std::vector<TrueParameter>(const FamilyFlight&, double, const Shape&)> parameters = {};
  /// What a sensor's error pretends, in the flight that was measured; for Measure::formula.
  std::function<SensorSize(const FamilyFlight&, double, const Shape&, const FamilyFlown&)> size = {};
  std::vector<std::string> variables = {};  ///< of an unknown one
  std::vector<std::string> along = {};      ///< other effects that this realisation has as well
};

/// All of them; the order is fixed.
const std::vector<Hidden>& hidden_effects();
/// Ids of the contract's catalogue.
const std::vector<std::string>& catalogue();

// One list a file.
void hide_rigid_body(std::vector<Hidden>& out);
void hide_propellers(std::vector<Hidden>& out);
void hide_actuation(std::vector<Hidden>& out);
void hide_air(std::vector<Hidden>& out);
void hide_boundaries(std::vector<Hidden>& out);
void hide_cables(std::vector<Hidden>& out);
void hide_loads(std::vector<Hidden>& out);
void hide_springs(std::vector<Hidden>& out);
void hide_inertial(std::vector<Hidden>& out);
void hide_sensing(std::vector<Hidden>& out);
void hide_unknown(std::vector<Hidden>& out);

// Words for the lists.
using Parameters = std::vector<TrueParameter>;
inline TrueParameter scalar(const char* name, double value) { return {name, value, std::abs(value)}; }
inline Parameters three(std::array<const char*, 3> names, const Vec3& v) {
  return {{names[0], v.x(), v.norm()}, {names[1], v.y(), v.norm()}, {names[2], v.z(), v.norm()}};
}
inline double mass(const FamilyFlight& f) { return f.vehicle.nominal.mass; }
inline double weight(const FamilyFlight& f) { return f.vehicle.weight(); }
inline double arm(const FamilyFlight& f) { return f.vehicle.arm(); }
/// Speed of a rotor in hover [rad/s].
double hover_speed(const FamilyFlight& f);
/// One change for every rotor, or those of a board.
void each_rotor(FamilyFlight& f, const std::function<void(RotorChange&, int)>& change, int board = -1);
/// A change of one drawn rotor.
RotorChange some_rotor(const FamilyFlight& f, const Shape& s, int k);
inline bool tilts(const FamilyVehicle&, const Coordinates& c) { return c.tilt != "none"; }
inline bool tilt_moves(const FamilyVehicle&, const Coordinates& c) { return c.tilt == "moves"; }
inline bool has_imu(const FamilyVehicle&, const Coordinates& c) { return c.imu(); }
inline bool has_speed(const FamilyVehicle&, const Coordinates& c) { return c.speed(); }

/// Drag area [m^2] of a body as wide as the vehicle's arms.
inline double frontal(const FamilyFlight& f) { return 0.5 * arm(f) * arm(f); }
inline Airframe& airframe(FamilyFlight& f) {
  if (!f.world.airframe) f.world.airframe.emplace();
  return *f.world.airframe;
}
inline RotorAir& rotor_air(FamilyFlight& f) {
  if (!f.world.rotor_air) f.world.rotor_air.emplace();
  return *f.world.rotor_air;
}
inline double highest(const FamilyFlight& f) {
  double out = -1e300;
  for (double t = f.lead; t < f.path.duration; t += 0.2) out = std::max(out, f.path.position[2].at(t).value);
  return out;
}
inline bool climbs(const FamilyVehicle&, const Coordinates& c) { return c.manoeuvre != "T1"; }
inline bool moves(const FamilyVehicle&, const Coordinates& c) { return c.manoeuvre != "T1"; }
inline bool quick(const FamilyVehicle& v, const Coordinates& c) { return moves(v, c) && v.speed > 1.5; }

inline bool low(const FamilyVehicle& v, const Coordinates& c) { return c.low && climbs(v, c); }
inline bool turns_back(const FamilyVehicle&, const Coordinates& c) { return reverses(c); }
inline bool high(const FamilyVehicle&, const Coordinates& c) { return !c.low; }
inline double start_height(const FamilyFlight& f) { return f.path.position[2].start; }

}  // namespace omniflight::proof

// The families of worlds that a case is drawn from: in what ways laboratories differ. Every coordinate has
// values that tuning draws and values marked unseen, which only a sealed run draws.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "case_truth.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::proof {

enum class Box { tuning, sealed };

/// Random numbers of one box: the tuning box takes every other eighth of [0, 1), the sealed box the eighths
/// between, so that no number of a sealed case was ever drawn for tuning.
class BoxRandom {
 public:
  BoxRandom(Random random, Box box) : random_(random), box_(box) {}
  double unit();
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// Even in the logarithm; low > 0.
  double between_log(double low, double high);
  double sign() { return random_.uniform() < 0.5 ? -1.0 : 1.0; }
  /// With this probability true; not of the box.
  bool chance(double probability) { return random_.uniform() < probability; }
  double normal() { return random_.normal(); }
  std::uint64_t bits() { return random_.next(); }
  std::size_t index(std::size_t count) { return static_cast<std::size_t>(random_.next() % count); }
  Box box() const { return box_; }

 private:
  Random random_;
  Box box_;
};

/// Where a case stands in the space of families; all words are those of the truth file.
struct Coordinates {
  std::string vehicle;      ///< kFamilyVehicles
  std::string controller;   ///< "geometric", "cascade", "indi"; unseen: "sliding"
  std::string told_gains;   ///< "told", "wrong", "not told"
  std::string start;        ///< "rest", "in flight", "segments"
  std::string manoeuvre;    ///< "T1", "T2", "eight", "multisine", "designed", "pilot"; unseen: "helix"
  std::string signals;      ///< "imu+speed", "imu+command", "speed", "command", "imu+duty", "duty"
  bool reference = true;    ///< is recorded
  std::string turbulence;   ///< "ou", "dryden", "heavy"; unseen: "bursts"
  std::string noise;        ///< "white", "coloured", "outliers"
  std::string calibration;  ///< "exact", "told", "not told"
  double length = 60;       ///< s
  double imu_hz = 250, pose_hz = 125, speed_hz = 125;
  double alpha_deg = 0;  ///< of a tilting vehicle
  std::string tilt;      ///< "none", "fixed", "moves"
  bool low = false;      ///< down to the floor
  bool imu() const { return signals.rfind("imu", 0) == 0; }
  bool speed() const { return signals.find("speed") != std::string::npos; }
  bool duty() const { return signals.find("duty") != std::string::npos; }
};

/// Rotors of such a flight turn backwards at times: a vehicle with reversible rotors leans far over.
bool reverses(const Coordinates& where);

/// How large one hidden effect is.
struct EffectSize {
  std::array<double, 6> rms{};  ///< N, N m body: RMS of its wrench
  double sigma = 0;             ///< over the residual noise, in the strongest channel
  std::string channel;          ///< that channel, "Fx" ... "Mz", or "formula"
  bool law = false;             ///< realised by the catalogue's own law
};

/// What an oracle (generalised least squares, told noise, calibration and the truth) sees in the case's own
/// flight.
struct Separability {
  bool judged = false;
  double detect =
      0;  ///< sigma: noise-whitened size of the hidden wrench beyond what the calibration leaves open
  double rival = 0;        ///< sigma: the same beyond the nearest rival and the calibration
  std::string nearest;     ///< rival that comes closest
  bool separable = false;  ///< rival >= kSeparable
};
inline constexpr double kSeparable = 5.0;  ///< sigma

struct FamilyCase {
  Truth truth;  ///< truth.flight is the manoeuvre
  Coordinates where;
  std::vector<std::string> unseen;               ///< "controller", "manoeuvre", ...: what no tuning run draws
  std::vector<EffectSize> sizes;                 ///< one an effect
  std::array<double, 6> turbulence{}, sensor{};  ///< N, N m RMS: the two parts of truth.noise
  Separability oracle;
};

/// The sealed file of a families run, schema omniflight.proof_families/1.
struct FamilySeal {
  std::string salt, box, program;
  std::vector<FamilyCase> cases;
};
std::string to_json(const FamilySeal& seal);
/// Refuses what is not such a file, naming the case and field.
Result<FamilySeal> read_family_seal(std::string_view text, const std::string& name);

inline constexpr const char* kFamilyVehicles[] = {"quadrotor_37g", "quadrotor_1200g", "hexarotor",
                                                  "hexarotor_tilted", "omnimorph"};
inline constexpr const char* kUnseenVehicle = "octorotor";  ///< sealed runs only
inline constexpr const char* kChannels[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};

}  // namespace omniflight::proof

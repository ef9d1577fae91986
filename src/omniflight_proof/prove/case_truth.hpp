// What was hidden in a case: the content of the sealed file. Only the generator writes it, only the scorer
// reads it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::proof {

/// A hidden value in the words of docs and diagnosis.json. `scale` is what an error is held against: |value|,
/// or the length of the vector that it is a component of.
struct TrueParameter {
  std::string name;
  double value = 0, scale = 0;
};

/// One hidden effect.
struct TrueEffect {
  std::string id;                         ///< id of the contract; "unknown" when no library has it
  std::string stage;                      ///< where along reference ... power it acts
  std::string realisation;                ///< how the independent plant makes it, in words
  double sigma = 0;                       ///< RMS over the residual noise, in its strongest channel
  std::vector<TrueParameter> parameters;  ///< empty where the plant's mechanism has no such number
  std::vector<std::string> variables;     ///< of an unknown effect: what it depends on
};

enum class Kind { null, decoy, single, pair, triple, unknown };
std::string to_string(Kind kind);

struct Truth {
  std::string id;     ///< "case-0001", by a shuffled number
  std::string level;  ///< "L1" ... "L6"
  Kind kind = Kind::null;
  std::string flight;  ///< "designed", "T1" or "T2"
  std::string decoy;   ///< which, in words
  std::uint64_t seed = 0;
  double magnitude = 0;  ///< intended sigma of every effect
  std::vector<TrueEffect> effects;
  std::vector<std::string> present;         ///< nuisances that are really there and may be named
  std::array<double, 6> noise{};            ///< N and N m RMS, body: residual noise of the world
  std::array<double, 6> wrench{};           ///< N and N m RMS, body: hidden effects together, whole flight
  std::array<double, 6> wrench_variance{};  ///< N^2, (N m)^2: the same without its mean
};

/// The sealed file.
struct Seal {
  std::string salt;     ///< 64 hexadecimal digits
  std::string box;      ///< "sealed" or "tuning": which parameter boxes were drawn from
  std::string program;  ///< SHA-256 of the generator
  std::vector<Truth> cases;
};

std::string to_json(const Seal& seal);
/// Refuses what is not such a file, naming the case and field.
Result<Seal> read_seal(std::string_view text, const std::string& name);

}  // namespace omniflight::proof

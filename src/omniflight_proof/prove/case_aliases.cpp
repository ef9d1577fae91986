#include "case_aliases.hpp"

namespace omniflight::proof {
namespace {

struct Merge {
  const char *flight, *effect, *as;
};
constexpr Merge kMerges[] = {
    {"*", "thrust_scale", "payload_mass"},   {"*", "wind", "mocap_tilt"},
    {"T1", "hung_cable", "payload_mass"},    {"T1", "constant_pull", "payload_mass"},
    {"T1", "overhead_rope", "payload_mass"}, {"T1", "tilt_efficiency", "payload_mass"},
    {"T1", "ground_effect", "payload_mass"}, {"T1", "ceiling_effect", "payload_mass"},
};

}  // namespace

std::string merged(const std::string& effect, std::string_view flight) {
  for (const Merge& m : kMerges)
    if (effect == m.effect && (std::string_view(m.flight) == "*" || flight == m.flight)) return m.as;
  return effect;
}

std::string alias_table() {
  std::string out;
  for (const Merge& m : kMerges) out += std::string(m.flight) + " " + m.effect + " = " + m.as + "\n";
  return out;
}

}  // namespace omniflight::proof

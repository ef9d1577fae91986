// Commands reach the boards late, one delay a board.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class TransportDelay final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{.id = "transport_delay",
                                 .term = "transport delay per board",
                                 .equation = "Omega_c(t - d_b)",
                                 .latex = R"(\Omega_c(t-d_b))",
                                 .source = "definition; thesis section 8.1.1",
                                 .parameters = {{"board_0", "d_0", "s", 0, 0.1, 0.005, 0, true},
                                                {"board_1", "d_1", "s", 0, 0.1, 0.005, 0, true}},
                                 .signals = {"rotor_speed", "rotor_command"},
                                 .channels = {"rotor_speed"},
                                 .stage = Stage::actuation,
                                 .aliases = {"motor_lag", "clock_offset"},
                                 .separated_by = "pseudo-random command steps on both boards at once",
                                 .words = {{"board_0", "board_1"}, [](const KnownValues& v) {
                                             return "commands reach the rotors " +
                                                    two_digits(1e3 * std::max(v("board_0"), v("board_1"))) +
                                                    " ms late";
                                           }}};
    return info;
  }
  void alter_actuation(const vehicle::Vehicle& v, const double* theta, Actuation& a) const override {
    for (std::size_t i = 0; i < a.delay.size(); ++i) a.delay[i] += theta[v.rotors[i].board == 0 ? 0 : 1];
  }
};

}  // namespace

const Effect& transport_delay_effect() {
  static const TransportDelay effect;
  return effect;
}

}  // namespace omniflight::physics

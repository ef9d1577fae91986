#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "bus_access.hpp"
#include "operator_desk.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

constexpr double kArm = 12.0;  // s for motors to start and the first command to come

}  // namespace

Action add_arm(CLI::App& verb, Common& common) {
  auto domain = std::make_shared<int>(-1);
  auto keys = std::make_shared<std::string>();
  verb.add_option("--domain", *domain, "Domain of the run; default: the only run of this machine")
      ->check(CLI::Range(0, 231));
  add_secure(verb, *keys);
  return [=, &common]() -> Result<int> {
    const std::vector<int> runs = *domain >= 0 ? std::vector<int>{*domain} : domains_in_use();
    if (runs.size() != 1)  // rotors start: never those of a run that was not meant
      return fail(ErrorCode::incomplete,
                  runs.empty() ? "no run of this machine holds a domain" : "several runs hold a domain",
                  "arm", "Name the run with --domain");
    std::string with = *keys;
    if (auto ok = use_bus_of(runs.front(), with); !ok) return Failure(ok.error());
    auto desk = OperatorDesk::join(runs.front());
    if (!desk) return Failure(desk.error());
    if (auto ok = (*desk)->say("arm"); !ok) return Failure(ok.error());
    const bool heard = (*desk)->wait_for_listener(kMeet);
    const bool armed = heard && (*desk)->wait_for_arming(kArm);
    print_json(common,
               {{"domain", runs.front()}, {"heard", heard}, {"armed", armed}, {"gate", (*desk)->gate()}});
    say(common, armed ? fmt::format("domain {}: armed", runs.front())
                : heard
                    ? fmt::format("domain {}: NOT armed; the gate says: {}", runs.front(), (*desk)->gate())
                    : fmt::format("domain {}: nobody listens to an operator{}", runs.front(),
                                  unheard(runs.front(), with)));
    return armed ? 0 : static_cast<int>(ErrorCode::incomplete);
  };
}

}  // namespace omniflight::cli

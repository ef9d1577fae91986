#include <fmt/format.h>

#include "omniflight_bus/domain.hpp"
#include "omniflight_files/files.hpp"
#include "operator_desk.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

constexpr double kMeet = 2.0;  // s until the participants of a run are found
constexpr double kArm = 12.0;  // s for motors to start and the first command to come

}  // namespace

Action add_arm(CLI::App& verb, Common& common) {
  auto domain = std::make_shared<int>(-1);
  verb.add_option("--domain", *domain, "Domain of the run; default: the only run of this machine")
      ->check(CLI::Range(0, 231));
  return [=, &common]() -> Result<int> {
    auto configs = files::config_dir();
    if (!configs) return Failure(configs.error());
    if (auto ok = bus::use_loopback((*configs / "cyclonedds_loopback.xml").string()); !ok)
      return Failure(ok.error());
    const std::vector<int> runs = *domain >= 0 ? std::vector<int>{*domain} : domains_in_use();
    if (runs.size() != 1)  // rotors start: never those of a run that was not meant
      return fail(ErrorCode::incomplete,
                  runs.empty() ? "no run of this machine holds a domain" : "several runs hold a domain",
                  "arm", "Name the run with --domain");
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
                    : fmt::format("domain {}: nobody listens to an operator", runs.front()));
    return armed ? 0 : static_cast<int>(ErrorCode::incomplete);
  };
}

}  // namespace omniflight::cli

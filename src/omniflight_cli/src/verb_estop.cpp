#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>

#include "bus_access.hpp"
#include "operator_desk.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

constexpr double kAcknowledge = 1.0;  // s for the gate to answer, from when it is found

/// One run: says it, waits for the answer. True when the gate has acknowledged.
Result<bool> stop(int domain, std::string keys, const std::string& wish, const Common& common,
                  nlohmann::json& json) {
  if (auto ok = use_bus_of(domain, keys); !ok) return Failure(ok.error());
  auto desk = OperatorDesk::join(domain);
  if (!desk) return Failure(desk.error());
  if (auto ok = (*desk)->say(wish); !ok)
    return Failure(ok.error());  // latched: whoever is found later hears it
  const bool heard = (*desk)->wait_for_listener(kMeet);
  const auto begin = std::chrono::steady_clock::now();
  if (heard) (void)(*desk)->wait_for_gate(kMeet);
  const bool stopped = heard && (*desk)->wait_for_stop(kAcknowledge);
  const double after_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  json.push_back(
      {{"domain", domain}, {"heard", heard}, {"acknowledged", stopped}, {"gate", (*desk)->gate()}});
  say(common, !heard
                  ? fmt::format("domain {}: nobody listens to an operator{}", domain, unheard(domain, keys))
              : stopped ? fmt::format("domain {}: rotors {} ({:.0f} ms after the run was found)", domain,
                                      (*desk)->gate(), 1e3 * after_s)
                        : fmt::format("domain {}: NOT acknowledged within {} s (gate: {}). Cut the power",
                                      domain, kAcknowledge, (*desk)->gate()));
  return stopped;
}

}  // namespace

Action add_estop(CLI::App& verb, Common& common) {
  auto domain = std::make_shared<int>(-1);
  auto keys = std::make_shared<std::string>();
  auto ramp = std::make_shared<bool>(false);
  verb.add_option("--domain", *domain, "Domain of the run; default: every run of this machine")
      ->check(CLI::Range(0, 231));
  add_secure(verb, *keys);
  verb.add_flag("--ramp", *ramp, "Wind the rotors down over the gate's ramp instead of cutting them");
  return [=, &common]() -> Result<int> {
    const std::vector<int> domains = *domain >= 0 ? std::vector<int>{*domain} : domains_in_use();
    if (domains.empty())
      return fail(ErrorCode::incomplete, "no run of this machine holds a domain", "estop",
                  "Name it with --domain when it was started by hand");
    nlohmann::json answers = nlohmann::json::array();
    bool acknowledged = true;
    for (const int d : domains) {
      auto stopped = stop(d, *keys, *ramp ? "stop" : "cut", common, answers);
      if (!stopped) return Failure(stopped.error());
      acknowledged = acknowledged && *stopped;
    }
    print_json(common, answers);
    return acknowledged ? 0 : static_cast<int>(ErrorCode::incomplete);
  };
}

}  // namespace omniflight::cli

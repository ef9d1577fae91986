// `keys`: identities, permissions and governance for a secured bus, made by authorities that are then gone.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <filesystem>

#include "omniflight_bus/security.hpp"
#include "omniflight_components/rights.hpp"
#include "verbs.hpp"

namespace omniflight::cli {

Action add_keys(CLI::App& verb, Common& common) {
  auto days = std::make_shared<int>(365);
  verb.add_option("--days", *days, "Days until they end")->check(CLI::Range(1, 3650));
  return [=, &common]() -> Result<int> {
    if (common.out.empty())
      return bad_input("names the folder of the keys, which is never a default one", "--out",
                       "For instance: omniflight keys --out ~/omniflight_keys");
    const std::int64_t now =
        std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch())
            .count();
    // an hour back, for machines whose clocks differ a little
    const bus::Validity validity{now - 3600, now + 86400LL * *days};
    const auto& roles = components::rights_of_roles();
    if (auto ok = bus::write_keys(common.out, roles, validity); !ok) return Failure(ok.error());
    nlohmann::json j{{"folder", std::filesystem::absolute(common.out).string()}, {"days", *days}};
    for (const auto& [role, rights] : roles) j["roles"].push_back(role);
    for (const auto& [role, rights] : roles)
      if (auto ok = bus::check_keys(common.out, role); !ok) return Failure(ok.error());
    print_json(common, j);
    say(common, fmt::format("{}: keys of {} roles, for {} days", common.out, roles.size(), *days));
    say(common, "  fly with them: omniflight fly MISSION --secure " + common.out);
    say(common,
        "  the authorities that signed them are gone: new roles, longer times and revocation mean a new "
        "folder");
    return 0;
  };
}

}  // namespace omniflight::cli

// `doctor`: what this machine lacks, and what to do about it.
#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/participant.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_vehicle/vehicle.hpp"
#include "verbs.hpp"

namespace omniflight::cli {

Action add_doctor(CLI::App&, Common& common) {
  return [&common]() -> Result<int> {
    bool well = true;
    nlohmann::json all = nlohmann::json::array();
    const auto tell = [&](const std::string& what, bool ok, const std::string& detail) {
      well = well && ok;
      all.push_back({{"check", what}, {"ok", ok}, {"detail", detail}});
      say(common, fmt::format("  {} {:28} {}", ok ? "ok  " : "FAIL", what, detail));
    };
    const auto configs = files::config_dir();
    tell("configuration folder", configs.has_value(), configs ? configs->string() : configs.error().text());
    tell("vehicles", !vehicle::vehicle_names().empty(),
         fmt::format("{} known", vehicle::vehicle_names().size()));
    if (configs) (void)bus::use_loopback((*configs / "cyclonedds_loopback.xml").string());
    auto domain = bus::claim_free_domain();
    tell("free domain", domain.has_value(),
         domain ? std::to_string(domain->domain()) : domain.error().text());
    if (domain) {
      auto participant = bus::Participant::create(domain->domain());
      tell("bus on the loopback interface", participant.has_value(),
           participant ? "a participant can be made" : participant.error().text());
    }
    for (const char* name : {"omniflight_simulator", "omniflight_container", "omniflight_recorder"}) {
      const auto program = find_program(name);
      tell(name, program.has_value(), program ? *program : program.error().text());
    }
    struct statvfs disk {};
    const bool known = statvfs(".", &disk) == 0;
    const double free_GB =
        known ? 1e-9 * static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize) : 0;
    tell("space here", known && free_GB > 1.0,
         fmt::format("{:.1f} GB free (a flight takes about 0.02 GB)", free_GB));
    print_json(common, all);
    return well ? 0 : static_cast<int>(ErrorCode::bad_input);
  };
}

}  // namespace omniflight::cli

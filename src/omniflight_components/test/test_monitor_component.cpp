// The monitor on the bus, beside a whole flight in one process: quiet when nothing is wrong, and how soon it
// speaks when something is.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "lockstep_flight.hpp"
#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/run_components.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/components.hpp"
#include "omniflight_components/topics.hpp"

namespace {

using namespace omniflight;
namespace fs = std::filesystem;
using msgs::diagnostic_msgs::DiagnosticArray;

/// Listens to /diagnostics and keeps when each check left OK [s].
class Listener final : public bus::Component {
 public:
  struct Said {
    int arrays = 0;
    std::map<std::string, double> left_ok, error;
    std::map<std::string, std::string> values, message;  ///< of the last array, by key and by check
    double first_s = -1, last_s = -1, widest_gap_s = 0;
  };
  explicit Listener(Said& said) : Component("listener"), said_(said) {}

 private:
  Status on_configure(const YAML::Node&) override {
    auto made = bus::Subscription<DiagnosticArray>::create(
        participant(), components::topics::diagnostics, bus::Qos::standard(),
        [this](const DiagnosticArray& m, std::int64_t) { take(m); });
    if (!made) return Failure(made.error());
    subscription_.emplace(std::move(*made));
    return {};
  }
  void take(const DiagnosticArray& m) {
    const double t = 1e-9 * static_cast<double>(bus::nanoseconds(m.header.stamp));
    if (said_.arrays++ > 0) said_.widest_gap_s = std::max(said_.widest_gap_s, t - said_.last_s);
    if (said_.first_s < 0) said_.first_s = t;
    said_.last_s = t;
    for (const auto& s : bus::view(m.status)) {
      const std::string name(bus::text(s.name));
      said_.message[name] = bus::text(s.message);
      if (s.level > 0 && s.level < 3) said_.left_ok.emplace(name, t);
      if (s.level == 2) said_.error.emplace(name, t);
      for (const auto& v : bus::view(s.values))
        said_.values[std::string(bus::text(v.key))] = bus::text(v.value);
    }
  }
  Status on_cleanup() override {
    subscription_.reset();
    return {};
  }
  Said& said_;
  std::optional<bus::Subscription<DiagnosticArray>> subscription_;
};

class MonitorOnTheBus : public ::testing::Test {
 protected:
  static constexpr double kRelease = 1.0;  // s, hold_s below
  void SetUp() override {
    setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
    fs::create_directories(folder_);
    claim_.emplace(bus::claim_free_domain());
    ASSERT_TRUE(*claim_) << claim_->error().text();
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string write(const char* name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  /// Flies trajectory_1 for 12 s with laboratory sensors.
  Listener::Said fly(const std::vector<std::string>& more) {
    Listener::Said said;
    std::vector<std::unique_ptr<bus::Component>> parts;
    parts.push_back(std::make_unique<Listener>(said));
    for (const char* name : {"monitor", "planner", "allocator", "controller", "simulator"})
      parts.push_back(components::make_component(name));
    std::vector<std::string> overrides{"monitor:vehicle:=omnimorph",
                                       "simulator:sensors:=" OMNIFLIGHT_SOURCE_ROOT
                                       "/configs/sensors/laboratory.yaml",
                                       "monitor:summary_file:=" + (folder_ / "monitor.json").string()};
    overrides.insert(overrides.end(), more.begin(), more.end());
    const auto options = components::test::lockstep_flight((*claim_)->domain(), 12, overrides);
    EXPECT_EQ(bus::run_components(std::move(parts), options), 0);
    return said;
  }
  nlohmann::json summary() {
    std::ifstream file(folder_ / "monitor.json");
    return nlohmann::json::parse(file, nullptr, false);
  }
  fs::path folder_ = fs::temp_directory_path() / ("omniflight_monitor_" + std::to_string(::getpid()));
  std::optional<Result<bus::DomainClaim>> claim_;
};

TEST_F(MonitorOnTheBus, ANominalFlightStaysOk) {
  const auto said = fly({});
  EXPECT_GT(said.arrays, 100);
  EXPECT_LT(said.widest_gap_s, 0.15) << "one array in 0.1 s of flight";
  EXPECT_TRUE(said.left_ok.empty()) << said.left_ok.begin()->first << " at " << said.left_ok.begin()->second;
  ASSERT_TRUE(said.values.count("force_z [N]"));
  EXPECT_LT(std::stod(said.values.at("latency [s]")), 0.35);
  const auto j = summary();
  ASSERT_FALSE(j.is_discarded());
  EXPECT_EQ(j.value("worst", ""), "OK") << j.dump(1);
  EXPECT_EQ(j["checks"].size(), 4u);
}

TEST_F(MonitorOnTheBus, ALoadOf280GramsIsAnErrorWithinASecond) {
  const auto said =
      fly({"simulator:model:=" + write("load.yaml",
                                       "schema: omniflight.model/1\neffects:\n  - id: payload_mass\n"
                                       "    parameters: {mass: 0.28}\n")});
  const std::string name = "omniflight: wrench balance";
  ASSERT_TRUE(said.error.count(name)) << said.message.at(name);
  EXPECT_LT(said.error.at(name), kRelease + 1.0);
  EXPECT_NEAR(std::stod(said.values.at("force_z [N]")), -0.28 * 9.81, 0.4);
  EXPECT_FALSE(said.left_ok.count("omniflight: motors")) << "the motors follow their commands";
  EXPECT_EQ(summary().value("worst", ""), "ERROR");
}

TEST_F(MonitorOnTheBus, AStuckRotorIsNamedWithinASecond) {
  const auto said = fly(
      {"simulator:faults_file:=" +
           write(
               "stuck.yaml",
               "schema: omniflight.faults/1\nfaults:\n  - {at_s: 6, kind: rotor_loss, rotor: 3, for_s: 4}\n"),
       "allocator:drop_lost_rotors:=false"});
  const std::string name = "omniflight: motors";
  ASSERT_TRUE(said.error.count(name));
  EXPECT_GT(said.left_ok.at(name), 6.0);
  EXPECT_LT(said.error.at(name), 7.0);
  const auto j = summary();
  EXPECT_NE(j["checks"][1].value("message", "").find("rotor 3"), std::string::npos) << j.dump(1);
}

}  // namespace

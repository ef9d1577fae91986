// Components without a flight around them: what they refuse, and that they never wait for ever.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <thread>

#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/run_components.hpp"
#include "omniflight_components/components.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/formats.hpp"
#include "omniflight_recording/mcap_reader.hpp"

namespace {

using namespace omniflight;
namespace fs = std::filesystem;

class Components : public ::testing::Test {
 protected:
  void SetUp() override {
    setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
    fs::create_directories(folder_);
    claim_.emplace(bus::claim_free_domain());
    ASSERT_TRUE(*claim_) << claim_->error().text();
  }
  void TearDown() override { fs::remove_all(folder_); }

  struct Outcome {
    int code;
    std::string text;  ///< stderr
    double seconds;
  };
  Outcome run(const std::vector<std::string>& names, const std::vector<std::string>& parameters,
              std::vector<std::unique_ptr<bus::Component>> parts = {}) {
    for (const std::string& name : names) parts.push_back(components::make_component(name));
    bus::RunOptions options;
    options.domain = (*claim_)->domain();
    options.loopback_file = OMNIFLIGHT_SOURCE_ROOT "/configs/cyclonedds_loopback.xml";
    options.overrides = parameters;
    options.timeout = std::chrono::seconds(20);
    ::testing::internal::CaptureStderr();
    const auto begin = std::chrono::steady_clock::now();
    const int code = bus::run_components(std::move(parts), options);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return {code, ::testing::internal::GetCapturedStderr(), seconds};
  }
  static void expect_words(const Outcome& outcome, const std::vector<std::string>& words) {
    for (const std::string& word : words)
      EXPECT_NE(outcome.text.find(word), std::string::npos) << word << " is missing in: " << outcome.text;
  }

  fs::path folder_ = fs::temp_directory_path() / ("omniflight_components_" + std::to_string(::getpid()));
  std::optional<Result<bus::DomainClaim>> claim_;
};

constexpr int kIncomplete = static_cast<int>(ErrorCode::incomplete);
constexpr int kBadInput = static_cast<int>(ErrorCode::bad_input);

TEST_F(Components, EveryNameMakesAComponentOfThatName) {
  ASSERT_EQ(components::component_names().size(), 10u);
  for (const std::string& name : components::component_names()) {
    const auto component = components::make_component(name);
    ASSERT_TRUE(component) << name;
    EXPECT_EQ(component->name(), name);
  }
  EXPECT_EQ(components::make_component("controler"), nullptr);
}

TEST_F(Components, RefuseUnknownParameters) {
  const std::string file = (folder_ / "x.mcap").string(), folder = folder_.string();
  const std::map<std::string, std::vector<std::string>> needed{
      {"recorder", {"file:=" + file}},
      {"monitor", {"vehicle:=omnimorph"}},
      {"planner", {"plan:=" + folder}},
      {"allocator", {"vehicle:=omnimorph"}},
      {"controller", {}},
      {"simulator", {"vehicle:=omnimorph"}},
      {"emulator", {"vehicle:=omnimorph", "link_directory:=" + folder}},
      {"gateway", {"vehicle:=omnimorph", "devices:=" + folder + "/board0"}},
      {"natnet", {"config:=" OMNIFLIGHT_SOURCE_ROOT "/configs/natnet/optitrack.yaml"}},
      {"natnet_emulator", {"config:=" OMNIFLIGHT_SOURCE_ROOT "/configs/natnet/optitrack.yaml"}}};
  ASSERT_EQ(needed.size(), components::component_names().size());
  for (const std::string& name : components::component_names()) {
    std::vector<std::string> parameters = needed.at(name);
    parameters.push_back("alhpa:=3");
    const Outcome outcome = run({name}, parameters);
    EXPECT_EQ(outcome.code, kBadInput) << name;
    expect_words(outcome, {"[" + name + "] not configured", "unknown parameter 'alhpa'", "Known are"});
  }
  EXPECT_FALSE(fs::exists(folder_ / "x.mcap")) << "a refused recorder leaves no file";
}

TEST_F(Components, RefuseValuesThatAreNotPossible) {
  expect_words(run({"simulator"}, {"vehicle:=omnimorph", "step_s:=0.1"}), {"step_s", "0.1"});
  expect_words(run({"simulator"}, {"vehicle:=omnimorph", "control_period_s:=0.0025"}),
               {"control_period_s", "whole multiple of step_s"});
  expect_words(run({"simulator"}, {"vehicle:=omnimorf"}), {"omnimorf"});
  expect_words(run({"controller"}, {"kp:=[1, 2]"}), {"kp"});
  expect_words(run({"allocator"}, {"vehicle:=omnimorph", "vehicle_set:=mass=-3"}), {"mass", "-3 kg"});
  expect_words(run({"planner"}, {"plan:=" + (folder_ / "nowhere").string()}), {"nowhere"});
}

TEST_F(Components, ALoneSimulatorNamesWhoIsMissing) {
  const Outcome outcome = run({"simulator"}, {"vehicle:=omnimorph", "peers_timeout_s:=0.5"});
  EXPECT_EQ(outcome.code, kIncomplete) << outcome.text;
  expect_words(outcome, {"0.5", "an allocator that publishes commands", "Start the missing component"});
  EXPECT_LT(outcome.seconds, 10.0);
}

TEST_F(Components, ASimulatorWithoutControllerNamesIt) {
  const Outcome outcome =
      run({"allocator", "simulator"}, {"vehicle:=omnimorph", "simulator:peers_timeout_s:=0.5"});
  EXPECT_EQ(outcome.code, kIncomplete) << outcome.text;
  expect_words(outcome, {"[simulator] not finished", "0.5"});
  EXPECT_LT(outcome.seconds, 10.0);
}

TEST_F(Components, AGatewayWithoutBoardsNamesTheDevice) {
  const Outcome outcome =
      run({"gateway"}, {"vehicle:=omnimorph", "devices:=/dev/no_such_board", "connect_timeout_s:=1"});
  EXPECT_NE(outcome.code, 0);
  expect_words(outcome, {"[gateway] not", "/dev/no_such_board"});
  EXPECT_LT(outcome.seconds, 10.0);
}

/// Publishes poses: some while it is configured, some while it is active; then it is done.
class Talker final : public bus::Component {
 public:
  Talker(int early, int late) : Component("talker"), early_(early), late_(late) {}

 private:
  Status talk(int count) {
    for (int k = 0; k < count; ++k) {
      message_->header.stamp = bus::stamp(++stamp_ * 1'000'000);
      message_->pose.orientation.w = 1.0;
      if (auto ok = publisher_->publish(*message_, stamp_ * 1'000'000); !ok) return ok;
    }
    return {};
  }
  Status on_configure(const YAML::Node&) override {
    auto made = advertise<msgs::geometry_msgs::PoseStamped>(components::topics::mocap, bus::Qos::bulk(512));
    if (!made) return Failure(made.error());
    publisher_.emplace(std::move(*made));
    return talk(early_);
  }
  Status on_activate() override {
    const Status ok = talk(late_);
    finish(ok);
    return ok;
  }
  Status on_cleanup() override {
    publisher_.reset();
    return {};
  }
  int early_, late_;
  std::int64_t stamp_ = 0;
  bus::Message<msgs::geometry_msgs::PoseStamped> message_;
  std::optional<bus::Publisher<msgs::geometry_msgs::PoseStamped>> publisher_;
};

// What is sent before the recorder listens is lost, and only the sender knows.
TEST_F(Components, ARecorderCountsWhatItNeverReceived) {
  for (const int lost : {0, 7}) {
    const fs::path file = folder_ / ("lost" + std::to_string(lost) + ".mcap");
    std::vector<std::unique_ptr<bus::Component>> parts;
    parts.push_back(std::make_unique<Talker>(lost, 20));
    const Outcome outcome = run({"recorder"}, {"recorder:file:=" + file.string()}, std::move(parts));
    EXPECT_EQ(outcome.code, 0) << outcome.text;
    const auto recording = recording::load(file);
    ASSERT_TRUE(recording) << recording.error().text();
    ASSERT_NE(recording->find("position"), nullptr);
    EXPECT_EQ(recording->find("position")->size(), 20);
    EXPECT_EQ(recording->lost_anything(), lost > 0);
    std::uint64_t told = 0;
    for (const auto& note : recording->notes)
      if (note.kind == recording::Note::Kind::loss &&
          note.text.find("/omniflight/mocap") != std::string::npos)
        told += note.messages;
    EXPECT_EQ(told, static_cast<std::uint64_t>(lost));
  }
}

/// Publishes ticks as fast as it can, from its configuration on until the flight has run for a moment.
class Chatter final : public bus::Component {
 public:
  Chatter() : Component("chatter") {}
  ~Chatter() override { stop(); }

 private:
  Status on_configure(const YAML::Node&) override {
    auto made = advertise<msgs::omniflight_msgs::Tick>(components::topics::tick, bus::Qos::bulk(512));
    if (!made) return Failure(made.error());
    publisher_.emplace(std::move(*made));
    thread_ = std::thread([this] {
      for (; !stopped_.load(); ++message_->index)
        (void)publisher_->publish(*message_, static_cast<std::int64_t>(message_->index) * 1000);
    });
    return {};
  }
  Status on_activate() override {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    finish();
    return {};
  }
  Status on_deactivate() override {
    stop();
    return {};
  }
  Status on_cleanup() override {
    stop();
    publisher_.reset();
    return {};
  }
  void stop() {
    stopped_ = true;
    if (thread_.joinable()) thread_.join();
  }
  std::atomic<bool> stopped_{false};
  bus::Message<msgs::omniflight_msgs::Tick> message_;
  std::optional<bus::Publisher<msgs::omniflight_msgs::Tick>> publisher_;
  std::thread thread_;
};

// Messages come before it listens to the other topics. Its tables grew under them; sanitizers see that first.
TEST_F(Components, ARecorderIsConfiguredWhileOthersPublish) {
  for (int k = 0; k < 5; ++k) {
    const fs::path file = folder_ / ("amid" + std::to_string(k) + ".mcap");
    std::vector<std::unique_ptr<bus::Component>> parts;
    parts.push_back(std::make_unique<Chatter>());
    const Outcome outcome = run({"recorder"}, {"recorder:file:=" + file.string()}, std::move(parts));
    EXPECT_EQ(outcome.code, 0) << outcome.text;
    std::uint32_t next = 0;
    const std::string bytes = files::read_file(file, 256 * files::kMegabyte).value();
    const auto content = recording::scan_mcap(
        bytes, file, [&](const recording::McapChannel& channel, const recording::McapMessage& m) {
          if (channel.topic != components::topics::tick) return;
          EXPECT_EQ(m.sequence, next++);
        });
    EXPECT_TRUE(content) << content.error().text();
    EXPECT_GT(next, 100u) << outcome.text;
  }
}

TEST_F(Components, ARecorderNeverOverwritesUnasked) {
  const fs::path file = folder_ / "kept.mcap";
  std::ofstream(file) << "precious";
  const Outcome outcome = run({"recorder"}, {"file:=" + file.string()});
  EXPECT_EQ(outcome.code, kBadInput) << outcome.text;
  expect_words(outcome, {"kept.mcap"});
  std::string content;
  std::ifstream(file) >> content;
  EXPECT_EQ(content, "precious");
}

}  // namespace

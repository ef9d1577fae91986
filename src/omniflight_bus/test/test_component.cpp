#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "bus_fixture.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_bus/run_components.hpp"
#include "omniflight_bus/subscription.hpp"

namespace omniflight::bus {
namespace {

using msgs::omniflight_msgs::ComponentState;
using msgs::omniflight_msgs::Tick;
using Steps = std::vector<std::string>;

/// Publishes three ticks on a thread of its own, then ends.
class Probe : public Component {
 public:
  Probe(std::string name, Steps& steps, Status end = {})
      : Component(std::move(name)), steps_(steps), end_(end) {}

 protected:
  Status on_configure(const YAML::Node& parameters) override {
    steps_.push_back(name() + " configure");
    Parameters read(parameters, name());
    gain_ = read.number("gain", 1.0, 0.0, 10.0);
    if (Status status = read.finish(); !status) return status;
    auto publisher = advertise<Tick>("/" + name() + "/tick", Qos::control());
    if (!publisher) return Failure(publisher.error());
    ticks_.emplace(std::move(*publisher));
    return {};
  }
  Status on_activate() override {
    steps_.push_back(name() + " activate");
    thread_ = std::thread([this] {
      const Message<Tick> tick;
      for (int i = 0; i < 3; ++i) (void)ticks_->publish(*tick, i);
      finish(end_);
    });
    return {};
  }
  Status on_deactivate() override {
    steps_.push_back(name() + " deactivate");
    thread_.join();
    return {};
  }
  Status on_cleanup() override {
    steps_.push_back(name() + " cleanup");
    ticks_.reset();
    return {};
  }

 private:
  Steps& steps_;
  Status end_;
  double gain_ = 0.0;
  std::optional<Publisher<Tick>> ticks_;
  std::thread thread_;
};

class ComponentTest : public BusTest {
 protected:
  RunOptions options(std::vector<std::string> overrides = {}) {
    RunOptions out;
    out.domain = claim->domain();
    out.overrides = std::move(overrides);
    out.timeout = 20s;
    out.quiet = true;
    return out;
  }
  template <class... Probes>
  static std::vector<std::unique_ptr<Component>> list(Probes... probes) {
    std::vector<std::unique_ptr<Component>> out;
    (out.push_back(std::move(probes)), ...);
    return out;
  }
};

TEST_F(ComponentTest, LifecycleRunsForwardsThenBackwardsAndIsPublished) {
  Steps steps, states;
  std::uint64_t sent = 0;
  const Participant observer = join();
  auto subscription = Subscription<ComponentState>::create(
      observer, "/component_state", Qos::latched_last(16), [&](const ComponentState& state, std::int64_t) {
        states.push_back(std::string(text(state.name)) + " " + std::string(text(state.state)));
        if (!view(state.sent).empty()) sent = std::max(sent, view(state.sent)[0]);
      });
  const int code = run_components(
      list(std::make_unique<Probe>("a", steps), std::make_unique<Probe>("b", steps)), options({"gain:=2"}));
  EXPECT_EQ(code, 0);
  EXPECT_EQ(steps, (Steps{"a configure", "b configure", "a activate", "b activate", "b deactivate",
                          "a deactivate", "b cleanup", "a cleanup"}));
  EXPECT_EQ(states, (Steps{"a inactive", "b inactive", "a active", "b active", "b inactive", "a inactive",
                           "b unconfigured", "b finalized", "a unconfigured", "a finalized"}));
  EXPECT_EQ(sent, 3u);
}

TEST_F(ComponentTest, AFailureStopsEveryComponentAndIsTheExitCode) {
  Steps steps;
  const Status broken = fail(ErrorCode::incomplete, "no command for 0.5 s");
  EXPECT_EQ(run_components(list(std::make_unique<Probe>("a", steps, broken)), options()), 2);
  EXPECT_EQ(steps.back(), "a cleanup");

  steps.clear();
  const int code =
      run_components(list(std::make_unique<Probe>("a", steps), std::make_unique<Probe>("b", steps)),
                     options({"b:gain:=11"}));
  EXPECT_EQ(code, 4) << "gain beyond its bounds";
  EXPECT_EQ(steps, (Steps{"a configure", "b configure", "b cleanup", "a cleanup"}))
      << "nothing was activated";
}

/// Works until it is told to stop, and stops slowly, as one does that winds rotors down.
class Endless : public Component {
 public:
  using Component::Component;

 protected:
  Status on_configure(const YAML::Node&) override { return {}; }
  Status on_deactivate() override {
    std::this_thread::sleep_for(400ms);
    return {};
  }
};

struct Ending {
  const char* name;
  std::vector<int> signals;  ///< one after the other
  bool read = true;          ///< somebody reads what the program says
  bool under_nohup = false;  ///< SIGHUP is ignored when it starts
};
std::ostream& operator<<(std::ostream& out, const Ending& ending) { return out << ending.name; }
class Endings : public ComponentTest, public testing::WithParamInterface<Ending> {};

TEST_P(Endings, RunIsTakenApartInOrder) {
  const Participant observer = join();
  std::atomic<bool> active{false}, finalized{false};
  auto states = Subscription<ComponentState>::create(
      observer, "/component_state", Qos::latched_last(16), [&](const ComponentState& state, std::int64_t) {
        active = active || text(state.state) == "active";
        finalized = finalized || text(state.state) == "finalized";
      });
  const std::string self = std::filesystem::read_symlink("/proc/self/exe");
  const std::string domain = std::to_string(claim->domain());
  int said[2];
  ASSERT_EQ(pipe(said), 0);
  const pid_t child = fork();
  if (child == 0) {  // a fresh program: a forked copy of a running middleware is of no use
    signal(SIGHUP, GetParam().under_nohup ? SIG_IGN : SIG_DFL);
    dup2(said[1], STDERR_FILENO);
    dup2(said[1], STDOUT_FILENO);
    close(said[0]);
    close(said[1]);
    setenv("OMNIFLIGHT_TEST_ENDLESS_DOMAIN", domain.c_str(), 1);
    execl(self.c_str(), self.c_str(), "--gtest_filter=EndlessProgram.*", static_cast<char*>(nullptr));
    _exit(127);
  }
  close(said[1]);
  EXPECT_TRUE(eventually([&] { return active.load(); }, 15s));
  if (!GetParam().read) close(said[0]);
  const auto asked = std::chrono::steady_clock::now();
  for (std::size_t k = 0; k < GetParam().signals.size(); ++k) {
    if (k > 0) std::this_thread::sleep_for(GetParam().under_nohup ? 1000ms : 200ms);
    EXPECT_FALSE(finalized) << "ended by what it was to ignore";
    kill(child, GetParam().signals[k]);
  }
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_LT(std::chrono::steady_clock::now() - asked, 3s);
  EXPECT_TRUE(eventually([&] { return finalized.load(); }));
  if (GetParam().read) close(said[0]);
}
INSTANTIATE_TEST_SUITE_P(Signals, Endings,
                         testing::Values(Ending{"Terminated", {SIGTERM}}, Ending{"TerminalClosed", {SIGHUP}},
                                         Ending{"InterruptedTwice", {SIGINT, SIGINT}},
                                         Ending{"InterruptedWithItsReader", {SIGINT}, false},
                                         Ending{"TerminalClosedUnderNohup", {SIGHUP, SIGTERM}, true, true}),
                         [](const auto& which) { return which.param.name; });

/// Not a test of its own: the program that Endings start.
TEST(EndlessProgram, Runs) {
  const char* domain = std::getenv("OMNIFLIGHT_TEST_ENDLESS_DOMAIN");
  if (domain == nullptr) GTEST_SKIP() << "started by Endings";
  RunOptions options;
  options.domain = std::atoi(domain);
  options.loopback_file = OMNIFLIGHT_SOURCE_ROOT "/configs/cyclonedds_loopback.xml";
  options.timeout = 60s;
  std::vector<std::unique_ptr<Component>> components;
  components.push_back(std::make_unique<Endless>("endless"));
  EXPECT_EQ(run_components(std::move(components), options), 0);
}

/// Reads YAML without care.
class Careless : public Component {
 public:
  using Component::Component;

 protected:
  Status on_configure(const YAML::Node& parameters) override {
    (void)parameters["gain"].as<double>();
    return {};
  }
};

TEST_F(ComponentTest, AnExceptionBecomesAnError) {
  EXPECT_EQ(run_components(list(std::make_unique<Careless>("careless")), options({"gain:=much"})), 1);
}

TEST_F(ComponentTest, TransitionsOutOfOrderAreRefused) {
  Steps steps;
  Probe probe("a", steps);
  EXPECT_FALSE(probe.activate());
  EXPECT_FALSE(probe.deactivate());
  const Participant participant = join();
  ASSERT_TRUE(probe.configure(participant, YAML::Node()));
  const Status again = probe.configure(participant, YAML::Node());
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().text(), "a: configure needs state unconfigured, it is inactive");
  EXPECT_TRUE(probe.shutdown());
  EXPECT_EQ(probe.phase(), ComponentPhase::finalized);
}

class ParameterFile : public ::testing::Test {
 protected:
  std::string write(const std::string& text) {
    path_ =
        std::filesystem::path(::testing::TempDir()) / ("parameters_" + std::to_string(getpid()) + ".yaml");
    std::ofstream(path_) << text;
    return path_;
  }
  void TearDown() override { std::filesystem::remove(path_); }
  std::filesystem::path path_;
};

TEST_F(ParameterFile, OwnValuesWinOverSharedOnesAndOverridesOverBoth) {
  const std::string file = write(
      "/**:\n  ros__parameters: {rate: 100, vehicle: omnimorph, gains: {p: 1.0, d: 2.0}}\n"
      "controller:\n  ros__parameters: {rate: 250, gains: {p: 3.0}}\n"
      "allocator:\n  ros__parameters: {rate: 1}\n");
  auto node =
      load_parameters({file}, {"gains.d:=5", "allocator:rate:=7", "controller:extra:=[1, 2]"}, "controller");
  ASSERT_TRUE(node) << node.error().text();
  EXPECT_EQ((*node)["rate"].as<int>(), 250);
  EXPECT_EQ((*node)["vehicle"].as<std::string>(), "omnimorph");
  EXPECT_EQ((*node)["gains"]["p"].as<double>(), 3.0);
  EXPECT_EQ((*node)["gains"]["d"].as<double>(), 5.0);
  EXPECT_EQ((*node)["extra"].size(), 2u);
}

TEST_F(ParameterFile, ErrorsNameFileLineKeyAndNextStep) {
  const std::string file = write("controller:\n  ros__parameters:\n    rate: .nan\n    rat: 3\n");
  auto node = load_parameters({file}, {}, "controller");
  ASSERT_TRUE(node);
  Parameters wrong(*node, file);
  EXPECT_EQ(wrong.number("rate", 1.0, 0.0, 1000.0), 0.0);
  EXPECT_EQ(wrong.finish().error().text(),
            file + ":3: 'rate' = '.nan' is not usable. Give a finite number from 0 to 1000");
  Parameters unknown(*node, file);
  unknown.text("rate", "");
  EXPECT_EQ(unknown.finish().error().text(), file + ":4: unknown parameter 'rat'. Known are rate");
  Parameters missing(*node, file);
  missing.flag("armed", std::nullopt);
  EXPECT_EQ(missing.finish().error().text(), file + ": 'armed' is missing. Set armed");
}

TEST_F(ParameterFile, AnOverrideOfOneAliasLeavesTheOthersAlone) {
  const std::string file = write("a:\n  ros__parameters: {x: &g {p: 1, q: &n 2}, y: *g, z: *n}\n");
  auto node = load_parameters({file}, {"x.p:=5", "x.q:=6"}, "a");
  ASSERT_TRUE(node) << node.error().text();
  EXPECT_EQ((*node)["x"]["p"].as<int>(), 5);
  EXPECT_EQ((*node)["y"]["p"].as<int>(), 1);
  EXPECT_EQ((*node)["y"]["q"].as<int>(), 2);
  EXPECT_EQ((*node)["z"].as<int>(), 2);
}

TEST_F(ParameterFile, MalformedFilesAreRefused) {
  EXPECT_FALSE(load_parameters({"/nonexistent.yaml"}, {}, "a"));
  EXPECT_FALSE(load_parameters({write("a: [1, 2")}, {}, "a"));
  EXPECT_FALSE(load_parameters({write("a: {parameters: {}}")}, {}, "a"));
  EXPECT_FALSE(load_parameters({write("[1, 2]")}, {}, "a"));
  EXPECT_FALSE(load_parameters({write("? [x]\n: 1\na: {ros__parameters: {? [y] : 2}}")}, {}, "a"));
  const std::string endless = write("a:\n  ros__parameters: &m\n    b: *m\n");
  const auto refused = load_parameters({endless}, {}, "a");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("more than 32 levels"), std::string::npos) << refused.error().text();
  EXPECT_FALSE(load_parameters({}, {"gain"}, "a"));
  EXPECT_FALSE(load_parameters({}, {":=3"}, "a"));
}

}  // namespace
}  // namespace omniflight::bus

// Two processes on a secured bus: a gateway that takes commands, and somebody who wants to give one.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <functional>
#include <optional>
#include <sstream>
#include <thread>

#include "omniflight_bus/authority.hpp"
#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/security.hpp"
#include "omniflight_bus/subscription.hpp"

namespace omniflight::bus {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using msgs::geometry_msgs::PoseStamped;

inline std::string slurp(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}
inline void spit(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
}

/// What became of one who joined, or tried to.
struct Attempt {
  std::string said;  ///< "met", "not met", or why it came no further
  std::string log;   ///< stderr of its process, with the lines of the middleware
};

/// One test: keys in `keys`, which the gateway uses, and copies of them for others. No participant lives in
/// the process of the test itself; each has its own.
class SecuredPeers : public ::testing::Test {
 protected:
  static Validity days(double from, double until) {
    const std::int64_t now = std::time(nullptr);
    return {now + static_cast<std::int64_t>(86400 * from), now + static_cast<std::int64_t>(86400 * until)};
  }
  static inline const Rights kCommander{{"/cmd"}, {"/state"}};
  static inline const Rights kGateway{{"/state"}, {"/cmd"}};

  void SetUp() override {
    folder = fs::temp_directory_path() / ("omniflight_security_" + std::to_string(getpid()));
    fs::create_directories(folder);
    auto made = Authority::create(days(-1, 30));
    ASSERT_TRUE(made) << made.error().text();
    authority.emplace(std::move(*made));
    keys = folder / "keys";
    write(keys, *authority, "commander", kCommander);
    write(keys, *authority, "gateway", kGateway);
    auto claimed = claim_free_domain(1, 100);
    ASSERT_TRUE(claimed) << claimed.error().text();
    claim.emplace(std::move(*claimed));
  }
  void TearDown() override {
    if (gateway > 0) kill(gateway, SIGKILL), waitpid(gateway, nullptr, 0);
    fs::remove_all(folder);
  }

  static void write(const fs::path& where, const Authority& by, const std::string& role, const Rights& rights,
                    const Validity& validity = days(-1, 30)) {
    const KeyFiles files(where, role);
    const Credentials c = by.issue(role, rights, validity).value();
    spit(files.identity_ca, by.identity_ca());
    spit(files.permissions_ca, by.permissions_ca());
    spit(files.governance, by.sign(governance_xml()).value());
    spit(files.certificate, c.certificate);
    spit(files.private_key, c.private_key);
    spit(files.permissions, c.permissions);
  }
  /// A copy of the keys that a test then spoils.
  fs::path copy_of_the_keys(const std::string& name) const {
    fs::copy(keys, folder / name, fs::copy_options::recursive);
    return folder / name;
  }

  static Status use_loopback_here() {
    return use_loopback(OMNIFLIGHT_SOURCE_ROOT "/configs/cyclonedds_loopback.xml");
  }

  /// Starts a gateway that listens to /cmd and counts.
  void start_gateway(bool secured = true) {
    ASSERT_EQ(pipe(heard_pipe), 0);
    gateway = fork();
    ASSERT_GE(gateway, 0);
    if (gateway == 0) {
      log_to(folder / "gateway.log");
      (void)use_loopback_here();
      if (auto ok = secured ? use_security(keys, "gateway") : Status(); !ok) end(ok.error().text());
      auto participant = Participant::create(claim->domain());
      if (!participant) end(participant.error().text());
      const int out = heard_pipe[1];
      auto listener = Subscription<PoseStamped>::create(
          *participant, "/cmd", Qos::control(),
          [out](const PoseStamped&, std::int64_t) { (void)!::write(out, "!", 1); });
      if (!listener) end(listener.error().text());
      (void)!::write(out, "r", 1);
      for (;;) pause();
    }
    close(heard_pipe[1]);
    char ready = 0;
    ASSERT_TRUE(read_within(heard_pipe[0], &ready, 10s)) << slurp(folder / "gateway.log");
    ASSERT_EQ(ready, 'r') << slurp(folder / "gateway.log");
  }
  pid_t gateway_pid() const { return gateway; }
  /// Somebody who commands at 100 Hz until he is killed.
  pid_t start_commander(bool secured) {
    const pid_t child = fork();
    if (child != 0) return child;
    log_to(folder / "commander.log");
    (void)use_loopback_here();
    if (auto ok = secured ? use_security(keys, "commander") : Status(); !ok) end(ok.error().text());
    auto participant = Participant::create(claim->domain());
    if (!participant) end(participant.error().text());
    auto publisher = Publisher<PoseStamped>::create(*participant, "/cmd", Qos::control());
    if (!publisher) end(publisher.error().text());
    const Message<PoseStamped> pose;
    for (int i = 0;; ++i) {
      (void)publisher->publish(*pose, i);
      std::this_thread::sleep_for(10ms);
    }
  }
  /// Commands that the gateway has heard since this was asked last.
  int heard() {
    std::this_thread::sleep_for(100ms);  // for what is on its way
    int waiting = 0;
    if (ioctl(heard_pipe[0], FIONREAD, &waiting) != 0) return 0;
    std::string bytes(static_cast<std::size_t>(waiting), '\0');
    return static_cast<int>(std::max<ssize_t>(0, read(heard_pipe[0], bytes.data(), bytes.size())));
  }

  /// In a process of its own: prepares (keys), joins, and publishes commands for a second where it is let.
  Attempt attempt(const std::function<Status()>& prepare, const std::string& topic = "/cmd") {
    int result[2];
    if (pipe(result) != 0) return {"no pipe", ""};
    const fs::path log = folder / "attempt.log";
    const pid_t child = fork();
    if (child == 0) {
      log_to(log);
      const std::string said = join_and_command(prepare, topic);
      (void)!::write(result[1], said.data(), said.size());
      ::_exit(0);
    }
    close(result[1]);
    std::string said;
    for (char byte = 0; read_within(result[0], &byte, 20s);) said += byte;
    close(result[0]);
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    return {said, slurp(log)};
  }
  Attempt attempt_with(const fs::path& with, const std::string& role = "commander",
                       const std::string& topic = "/cmd") {
    return attempt(
        [&] {
          (void)use_loopback_here();
          return use_security(with, role);
        },
        topic);
  }

  std::chrono::milliseconds patience = 700ms;  ///< until an attempt has not met the gateway
  fs::path folder, keys;
  std::optional<Authority> authority;
  std::optional<DomainClaim> claim;

 private:
  std::string join_and_command(const std::function<Status()>& prepare, const std::string& topic) {
    if (auto ok = prepare(); !ok) return "refused: " + ok.error().text();
    auto participant = Participant::create(claim->domain());
    if (!participant) return "not joined: " + participant.error().text();
    auto publisher = Publisher<PoseStamped>::create(*participant, topic, Qos::control());
    if (!publisher) return "no publisher: " + publisher.error().text();
    const bool met = publisher->wait_for_peers(1, patience).has_value();
    const Message<PoseStamped> pose;
    for (int i = 0; i < 20; ++i) {
      if (!publisher->publish(*pose, i)) return "not sent";
      std::this_thread::sleep_for(5ms);
    }
    return met ? "met" : "not met";
  }
  static bool read_within(int file, char* byte, std::chrono::milliseconds timeout) {
    pollfd input{file, POLLIN, 0};
    return poll(&input, 1, static_cast<int>(timeout.count())) > 0 && read(file, byte, 1) == 1;
  }
  static void log_to(const fs::path& file) {
    const int log = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(log, STDERR_FILENO);
  }
  [[noreturn]] static void end(const std::string& why) {
    std::fprintf(stderr, "%s\n", why.c_str());
    ::_exit(1);
  }

  pid_t gateway = -1;
  int heard_pipe[2] = {-1, -1};
};

}  // namespace omniflight::bus

#include "operator_desk.hpp"

#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include "omniflight_bus/domain.hpp"
#include "omniflight_components/topics.hpp"
#include "wait_until.hpp"

namespace omniflight::cli {
namespace {

using msgs::diagnostic_msgs::DiagnosticArray;
using msgs::std_msgs::String;

}  // namespace

Result<std::unique_ptr<OperatorDesk>> OperatorDesk::join(int domain) {
  std::unique_ptr<OperatorDesk> desk(new OperatorDesk());
  auto participant = bus::Participant::create(domain);
  if (!participant) return Failure(participant.error());
  desk->participant_ = *participant;
  auto wish =
      bus::Publisher<String>::create(*participant, components::topics::wish, bus::Qos::latched_last());
  if (!wish) return Failure(wish.error());
  desk->wish_.emplace(std::move(*wish));
  OperatorDesk* self = desk.get();
  auto gate = bus::Subscription<DiagnosticArray>::create(*participant, components::topics::gate,
                                                         bus::Qos::latched_last(4),
                                                         [self](const DiagnosticArray& m, std::int64_t) {
                                                           const auto statuses = bus::view(m.status);
                                                           if (statuses.empty()) return;
                                                           const std::lock_guard lock(self->mutex_);
                                                           self->gate_ = bus::text(statuses[0].message);
                                                         });
  if (!gate) return Failure(gate.error());
  desk->subscription_.emplace(std::move(*gate));
  return desk;
}

Status OperatorDesk::say(const std::string& wish) {
  bus::set_text(message_->data, wish);
  return wish_->publish(*message_);
}

bool OperatorDesk::wait_for_listener(double timeout_s) const {
  return wait_until([&] { return wish_->peers() > 0; }, timeout_s);
}

bool OperatorDesk::wait_for_gate(double timeout_s) const {
  return wait_until([&] { return subscription_->peers() > 0 || !gate().empty(); }, timeout_s);
}

bool OperatorDesk::wait_for_stop(double timeout_s) const {
  return wait_until([&] { return gate().rfind("stopped", 0) == 0; }, timeout_s);
}

bool OperatorDesk::wait_for_arming(double timeout_s) const {
  return wait_until([&] { return gate().rfind("armed", 0) == 0; }, timeout_s);
}

std::vector<int> domains_in_use() {
  constexpr int kLastRunDomain = 100;  // of claim_free_domain
  std::vector<int> out;
  for (int domain = 1; domain <= kLastRunDomain; ++domain)
    if (!bus::claim_domain(domain)) out.push_back(domain);
  return out;
}

std::string OperatorDesk::gate() const {
  const std::lock_guard lock(mutex_);
  return gate_;
}

struct Keyboard::Saved {
  termios settings{};
};

Keyboard::Keyboard() : saved_(std::make_unique<Saved>()) {
  if (!isatty(STDIN_FILENO) || tcgetattr(STDIN_FILENO, &saved_->settings) != 0) return;
  termios raw = saved_->settings;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);  // Ctrl-C stays a signal
  raw_ = tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
}

Keyboard::~Keyboard() {
  if (raw_) tcsetattr(STDIN_FILENO, TCSANOW, &saved_->settings);
}

std::optional<char> Keyboard::key() {
  if (!raw_) return {};
  pollfd input{STDIN_FILENO, POLLIN, 0};
  char key = 0;
  if (poll(&input, 1, 0) <= 0 || (input.revents & POLLIN) == 0 || read(STDIN_FILENO, &key, 1) != 1) return {};
  return key;
}

std::string wish_of_key(char key) {
  switch (key) {
    case ' ':
    case 'e':
      return "cut";
    case 'a':
      return "arm";
    case 's':
      return "stop";
    case 'l':
      return "land";
    case 'h':
      return "hold";
    case 'r':
      return "none";
    default:
      return "";
  }
}

}  // namespace omniflight::cli

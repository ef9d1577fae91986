#include "omniflight_bus/component.hpp"

#include <exception>

namespace omniflight::bus {

const char* phase_name(ComponentPhase phase) {
  switch (phase) {
    case ComponentPhase::unconfigured:
      return "unconfigured";
    case ComponentPhase::inactive:
      return "inactive";
    case ComponentPhase::active:
      return "active";
    case ComponentPhase::finalized:
      return "finalized";
  }
  return "?";
}

namespace {

/// No exception of a component or of a library below it gets past the lifecycle.
template <class Step>
Status guarded(const std::string& name, const char* what, Step step) {
  try {
    return step();
  } catch (const std::exception& error) {
    return fail(ErrorCode::internal, std::string(what) + " threw: " + error.what(), name, "Report this");
  }
}

}  // namespace

Component::Component(std::string name) : name_(std::move(name)) {}
Component::~Component() = default;

Status Component::require(ComponentPhase wanted, const char* transition) const {
  if (phase_ == wanted) return {};
  return fail(
      ErrorCode::internal,
      std::string(transition) + " needs state " + phase_name(wanted) + ", it is " + phase_name(phase_),
      name_);
}

Status Component::configure(const Participant& participant, const YAML::Node& parameters) {
  if (Status allowed = require(ComponentPhase::unconfigured, "configure"); !allowed) return allowed;
  auto node = participant.as_node(name_);
  if (!node) return Failure(node.error());
  participant_ = std::move(*node);
  auto publisher = Publisher<msgs::omniflight_msgs::ComponentState>::create(*participant_, "/component_state",
                                                                            Qos::latched_last());
  if (!publisher) return Failure(std::move(publisher.error()));
  state_publisher_.emplace(std::move(*publisher));
  {
    const std::lock_guard lock(mutex_);
    outcome_.reset();
  }
  if (Status configured = guarded(name_, "configuring", [&] { return on_configure(parameters); });
      !configured) {
    (void)guarded(name_, "cleaning up", [&] { return on_cleanup(); });
    counts_.clear();
    publish_state(configured.error().text());
    return configured;
  }
  return enter(ComponentPhase::inactive);
}

Status Component::activate() {
  if (Status allowed = require(ComponentPhase::inactive, "activate"); !allowed) return allowed;
  if (Status activated = guarded(name_, "activating", [&] { return on_activate(); }); !activated) {
    publish_state(activated.error().text());
    return activated;
  }
  return enter(ComponentPhase::active);
}

Status Component::deactivate() {
  if (Status allowed = require(ComponentPhase::active, "deactivate"); !allowed) return allowed;
  const Status stopped = guarded(name_, "deactivating", [&] { return on_deactivate(); });
  const std::optional<Status> ended = outcome();
  const Status& shown = stopped && ended ? *ended : stopped;
  (void)enter(ComponentPhase::inactive, shown ? std::string() : shown.error().text());
  return stopped;
}

Status Component::cleanup() {
  if (Status allowed = require(ComponentPhase::inactive, "cleanup"); !allowed) return allowed;
  const Status cleaned = guarded(name_, "cleaning up", [&] { return on_cleanup(); });
  (void)enter(ComponentPhase::unconfigured, cleaned ? std::string() : cleaned.error().text());
  counts_.clear();
  return cleaned;
}

Status Component::shutdown() {
  Status first;
  if (phase_ == ComponentPhase::active) first = deactivate();
  if (phase_ == ComponentPhase::inactive) {
    if (Status cleaned = cleanup(); first && !cleaned) first = std::move(cleaned);
  }
  if (phase_ != ComponentPhase::finalized) (void)enter(ComponentPhase::finalized);
  state_publisher_.reset();
  participant_.reset();
  return first;
}

void Component::report() { publish_state({}); }

Status Component::enter(ComponentPhase phase, const std::string& detail) {
  phase_ = phase;
  publish_state(detail);
  return {};
}

void Component::publish_state(const std::string& detail) {
  if (!state_publisher_) return;
  Message<msgs::omniflight_msgs::ComponentState> message;
  const std::int64_t now = clock_.now_ns();
  message->header.stamp = stamp(now);
  set_text(message->name, name_);
  set_text(message->state, phase_name(phase_));
  set_text(message->detail, detail);
  resize(message->topics, counts_.size());
  resize(message->sent, counts_.size());
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    set_text(view(message->topics)[i], counts_[i]->topic);
    view(message->sent)[i] = counts_[i]->sent.load(std::memory_order_relaxed);
  }
  (void)state_publisher_->publish(*message,
                                  now);  // nobody may be there to read it, and the work goes on without
}

std::optional<Status> Component::outcome() const {
  const std::lock_guard lock(mutex_);
  return outcome_;
}

void Component::finish(Status status) {
  {
    const std::lock_guard lock(mutex_);
    if (outcome_) return;
    outcome_ = std::move(status);
  }
  if (notify_) notify_();
}

}  // namespace omniflight::bus

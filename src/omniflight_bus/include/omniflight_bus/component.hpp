// A part of the system with a lifecycle, as ROS 2 managed nodes have it: unconfigured -> inactive -> active.
#pragma once

#include <yaml-cpp/yaml.h>

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "omniflight_bus/clock.hpp"
#include "omniflight_bus/participant.hpp"
#include "omniflight_bus/publisher.hpp"

namespace omniflight::bus {

enum class ComponentPhase { unconfigured, inactive, active, finalized };
const char* phase_name(ComponentPhase phase);

/// Transitions are called by one thread, the runner. Each is published, latched, on /component_state with the
/// number of messages sent by topic, so that a recorder can tell what it has missed.
class Component {
 public:
  explicit Component(std::string name);
  virtual ~Component();
  Component(const Component&) = delete;
  Component& operator=(const Component&) = delete;

  const std::string& name() const { return name_; }
  ComponentPhase phase() const { return phase_; }

  /// unconfigured -> inactive. On an error it is cleaned up and stays unconfigured.
  Status configure(const Participant& participant, const YAML::Node& parameters);
  /// inactive -> active. On an error it stays inactive.
  Status activate();
  /// active -> inactive.
  Status deactivate();
  /// inactive -> unconfigured.
  Status cleanup();
  /// From anywhere to finalized, through deactivate and cleanup where they are due. The first error, if any.
  Status shutdown();

  /// Publishes the state again with the counts of now, so that losses show while it runs.
  void report();

  /// How it ended, once it has ended by itself. Safe from any thread.
  std::optional<Status> outcome() const;
  /// Called (from any thread) when the component ends by itself. Set before activate().
  void on_outcome(std::function<void()> notify) { notify_ = std::move(notify); }

 protected:
  /// Read parameters, create publishers and subscriptions. See Parameters for checked reading.
  virtual Status on_configure(const YAML::Node& parameters) = 0;
  virtual Status on_activate() { return {}; }
  /// Stop threads and timers; after it nothing is published.
  virtual Status on_deactivate() { return {}; }
  /// Destroy publishers and subscriptions; also called after a failed on_configure.
  virtual Status on_cleanup() { return {}; }

  /// Valid from on_configure to on_cleanup.
  const Participant& participant() const { return *participant_; }
  Clock& clock() { return clock_; }

  /// A publisher whose count appears in the component's state.
  template <class T>
  Result<Publisher<T>> advertise(std::string_view topic, const Qos& qos = {}, EventCallback on_event = {}) {
    auto publisher = Publisher<T>::create(participant(), topic, qos, std::move(on_event));
    if (publisher) counts_.push_back(publisher->sent_count());
    return publisher;
  }

  /// The component's work is done, or cannot go on. The first call counts. Safe from any thread and callback;
  /// the runner then stops every component.
  void finish(Status status = {});

 private:
  Status require(ComponentPhase wanted, const char* transition) const;
  Status enter(ComponentPhase phase, const std::string& detail = {});
  void publish_state(const std::string& detail);

  std::string name_;
  ComponentPhase phase_ = ComponentPhase::unconfigured;
  std::optional<Participant> participant_;
  Clock clock_;
  std::optional<Publisher<msgs::omniflight_msgs::ComponentState>> state_publisher_;
  std::vector<std::shared_ptr<const SentCount>> counts_;
  mutable std::mutex mutex_;
  std::optional<Status> outcome_;
  std::function<void()> notify_;
};

}  // namespace omniflight::bus

// A component whose work runs on a thread of its own from activation to deactivation: the clock masters.
#pragma once

#include <atomic>
#include <optional>
#include <thread>

#include "omniflight_bus/component.hpp"
#include "plant_publisher.hpp"

namespace omniflight::components {

class ThreadedComponent : public bus::Component {
 protected:
  using Component::Component;
  /// The work; returns when it is done or running() turns false. Its status is the component's outcome.
  virtual Status run() = 0;
  bool running() const { return running_.load(); }
  /// Ends the thread; call it in the destructor of the derived class, while run() still exists.
  void stop() {
    running_ = false;
    if (thread_.joinable()) thread_.join();
  }
  /// Creates the publishers of this side of the plant; their counts appear in the component's state.
  Status create_publishers(PlantPublisher& publisher, int rotors, PlantPublisher::Part part) {
    return publisher.create([this](auto& slot, const char* topic,
                                   const bus::Qos& qos) -> Status { return put_publisher(slot, topic, qos); },
                            rotors, part);
  }

  Status on_activate() final {
    running_ = true;
    thread_ = std::thread([this] { finish(run()); });
    return {};
  }
  Status on_deactivate() final {
    stop();
    return {};
  }

 private:
  template <class T>
  Status put_publisher(std::optional<bus::Publisher<T>>& slot, const char* topic, const bus::Qos& qos) {
    auto made = advertise<T>(topic, qos);
    if (!made) return Failure(made.error());
    slot.emplace(std::move(*made));
    return {};
  }
  std::atomic<bool> running_{false};
  std::thread thread_;
};

}  // namespace omniflight::components

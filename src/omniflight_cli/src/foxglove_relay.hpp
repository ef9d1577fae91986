// Every topic of a run to whoever subscribes to it with Foxglove.
#pragma once

#include <memory>
#include <vector>

#include "omniflight_bus/subscription.hpp"
#include "omniflight_view/foxglove_scene.hpp"

namespace omniflight::cli {

/// One for each recorded topic of a run, in the order of topics::recorded, then those of foxglove_scene.hpp.
std::shared_ptr<view::FoxgloveEndpoint> foxglove_endpoint();

/// Passes on the messages of a domain, as the bus has them, while it lives.
class FoxgloveRelay {
 public:
  /// server and endpoint must live longer.
  static Result<std::unique_ptr<FoxgloveRelay>> join(int domain, view::WebServer& server,
                                                     view::FoxgloveEndpoint& endpoint);

 private:
  FoxgloveRelay() = default;
  std::vector<bus::RawSubscription> subscriptions_;
};

/// What Foxglove's 3D panel shows, beside the topics.
void show_world(view::FoxgloveEndpoint& endpoint, view::WebServer& server,
                const std::vector<planning::Primitive>& solids);
void show_plan(view::FoxgloveEndpoint& endpoint, view::WebServer& server, const std::vector<Vec3>& path);
void show_frame(view::FoxgloveEndpoint& endpoint, view::WebServer& server, const vehicle::Vehicle& vehicle,
                const view::Frame& frame);

}  // namespace omniflight::cli

// The websocket protocol of Foxglove (github.com/foxglove/ws-protocol, version 1), the part that shows:
// channels are advertised, clients subscribe, messages go out. Nothing that a client says changes anything
// but its subscriptions.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "omniflight_view/web_server.hpp"

namespace omniflight::view {

/// As MCAP has it: encoding "cdr" with schema_encoding "ros2msg", or "json" with "jsonschema".
struct FoxgloveChannel {
  std::string topic, encoding, schema_name, schema, schema_encoding;
  bool latched = false;  ///< who subscribes later gets the last message
};

/// Subprotocol foxglove.websocket.v1. Channels are numbered by their place in the list.
class FoxgloveEndpoint final : public Endpoint {
 public:
  FoxgloveEndpoint(std::string name, std::vector<FoxgloveChannel> channels);

  /// To every subscriber of a channel, from any thread. ns: time of the message [ns]. Costs nothing when
  /// nobody has subscribed and the channel is not latched.
  void publish(WebServer& server, std::size_t channel, std::int64_t ns, std::string_view bytes);
  bool wanted(std::size_t channel) const;  ///< somebody subscribes to it, or it is latched

  const char* protocol() const override { return "foxglove.websocket.v1"; }
  bool for_other_pages() const override { return true; }
  void opened(WebServer& server, ClientId client) override;
  void received(WebServer& server, ClientId client, std::string_view message, bool binary) override;
  void closed(ClientId client) override;

 private:
  void subscribe(WebServer& server, ClientId client, std::uint32_t id, std::uint64_t channel);
  void refuse(WebServer& server, ClientId client, const std::string& why) const;

  std::string greeting_, advertised_;
  std::vector<FoxgloveChannel> channels_;
  mutable std::mutex mutex_;                                                // guards what follows
  std::map<ClientId, std::map<std::uint32_t, std::size_t>> subscriptions_;  // client: subscription: channel
  std::vector<std::size_t> subscribers_;                                    // of each channel
  std::vector<std::pair<std::int64_t, std::string>> last_;                  // of latched channels
};

}  // namespace omniflight::view

#include "omniflight_view/foxglove.hpp"

#include <nlohmann/json.hpp>

namespace omniflight::view {
namespace {

using nlohmann::json;

constexpr unsigned char kMessageData = 1;  // opcode of the protocol

/// A word of a client that was cut in the middle of a character is mended, not thrown at.
Bytes text(const json& value) {
  return std::make_shared<const std::string>(value.dump(-1, ' ', false, json::error_handler_t::replace));
}

template <class Integer>
void little_endian(std::string& out, Integer value) {
  for (std::size_t k = 0; k < sizeof value; ++k) out += static_cast<char>((value >> (8 * k)) & 0xff);
}

Bytes message_data(std::uint32_t subscription, std::int64_t ns, std::string_view bytes) {
  std::string out(1, static_cast<char>(kMessageData));
  little_endian(out, subscription);
  little_endian(out, static_cast<std::uint64_t>(ns));
  out += bytes;
  return std::make_shared<const std::string>(std::move(out));
}

bool is_id(const json& j, const char* key) {
  return j.is_object() && j.contains(key) && j[key].is_number_unsigned() &&
         j[key].get<std::uint64_t>() <= 0xffffffff;
}

}  // namespace

FoxgloveEndpoint::FoxgloveEndpoint(std::string name, std::vector<FoxgloveChannel> channels)
    : channels_(std::move(channels)), subscribers_(channels_.size()), last_(channels_.size()) {
  greeting_ = json{{"op", "serverInfo"},
                   {"name", std::move(name)},
                   {"capabilities", json::array()},
                   {"supportedEncodings", json::array()},
                   {"metadata", json::object()}}
                  .dump();
  json list = json::array();
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    const FoxgloveChannel& c = channels_[k];
    list.push_back({{"id", k},
                    {"topic", c.topic},
                    {"encoding", c.encoding},
                    {"schemaName", c.schema_name},
                    {"schema", c.schema},
                    {"schemaEncoding", c.schema_encoding}});
  }
  advertised_ = json{{"op", "advertise"}, {"channels", list}}.dump();
}

void FoxgloveEndpoint::opened(WebServer& server, ClientId client) {
  {
    const std::lock_guard lock(mutex_);
    subscriptions_[client] = {};
  }
  server.send(client, std::make_shared<const std::string>(greeting_));
  server.send(client, std::make_shared<const std::string>(advertised_));
}

void FoxgloveEndpoint::closed(ClientId client) {
  const std::lock_guard lock(mutex_);
  for (const auto& [id, channel] : subscriptions_[client]) --subscribers_[channel];
  subscriptions_.erase(client);
}

void FoxgloveEndpoint::refuse(WebServer& server, ClientId client, const std::string& why) const {
  server.send(client, text({{"op", "status"}, {"level", 2}, {"message", why}}));
}

void FoxgloveEndpoint::subscribe(WebServer& server, ClientId client, std::uint32_t id,
                                 std::uint64_t channel) {
  if (channel >= channels_.size())
    return refuse(server, client, "there is no channel " + std::to_string(channel));
  Bytes latched;
  {
    const std::lock_guard lock(mutex_);
    auto& own = subscriptions_[client];
    for (const auto& [other, taken] : own)
      if (other == id || taken == channel)
        return refuse(server, client,
                      "channel " + std::to_string(channel) + " or subscription " + std::to_string(id) +
                          " is taken already");
    own[id] = channel;
    ++subscribers_[channel];
    if (channels_[channel].latched && !last_[channel].second.empty())
      latched = message_data(id, last_[channel].first, last_[channel].second);
  }
  if (latched) server.send(client, latched, true);
}

void FoxgloveEndpoint::received(WebServer& server, ClientId client, std::string_view message, bool binary) {
  const json j = binary ? json() : json::parse(message, nullptr, false);
  if (!j.is_object() || !j.contains("op") || !j["op"].is_string())
    return refuse(server, client, "this server hears subscribe and unsubscribe, in JSON");
  if (j["op"] == "subscribe" && j.contains("subscriptions") && j["subscriptions"].is_array()) {
    for (const json& s : j["subscriptions"]) {
      if (!is_id(s, "id") || !is_id(s, "channelId"))
        return refuse(server, client, "a subscription needs id and channelId, whole numbers");
      subscribe(server, client, s["id"].get<std::uint32_t>(), s["channelId"].get<std::uint64_t>());
    }
    return;
  }
  if (j["op"] == "unsubscribe" && j.contains("subscriptionIds") && j["subscriptionIds"].is_array()) {
    const std::lock_guard lock(mutex_);
    auto& own = subscriptions_[client];
    for (const json& id : j["subscriptionIds"]) {
      if (!id.is_number_unsigned() || id.get<std::uint64_t>() > 0xffffffff) continue;
      const auto found = own.find(id.get<std::uint32_t>());
      if (found == own.end()) continue;
      --subscribers_[found->second];
      own.erase(found);
    }
    return;
  }
  refuse(server, client,
         "this server does not know the operation " + j["op"].get<std::string>().substr(0, 60));
}

bool FoxgloveEndpoint::wanted(std::size_t channel) const {
  const std::lock_guard lock(mutex_);
  return channels_[channel].latched || subscribers_[channel] > 0;
}

void FoxgloveEndpoint::publish(WebServer& server, std::size_t channel, std::int64_t ns,
                               std::string_view bytes) {
  std::vector<std::pair<ClientId, Bytes>> out;
  {
    const std::lock_guard lock(mutex_);
    if (channels_[channel].latched) last_[channel] = {ns, std::string(bytes)};
    if (subscribers_[channel] == 0) return;
    for (const auto& [client, own] : subscriptions_)
      for (const auto& [id, subscribed] : own)
        if (subscribed == channel) out.emplace_back(client, message_data(id, ns, bytes));
  }
  for (const auto& [client, message] : out) server.send(client, message, true);
}

}  // namespace omniflight::view

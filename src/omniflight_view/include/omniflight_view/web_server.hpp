// HTTP and websockets on the loopback interface, for pages of our own (libwebsockets).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::view {

using ClientId = std::uint64_t;
using Bytes = std::shared_ptr<const std::string>;

/// What a path answers with.
struct Resource {
  const char* type = "text/plain";  ///< media type
  Bytes body;
};

class WebServer;

/// A subprotocol of websockets. Called on the server's thread, one call at a time; must not wait.
class Endpoint {
 public:
  virtual ~Endpoint() = default;
  virtual const char* protocol() const = 0;  ///< name of the subprotocol, lives as long as the endpoint
  /// Whether pages of ServerOptions::allowed_origins may open it; only the server's own pages otherwise.
  virtual bool for_other_pages() const { return false; }
  virtual void opened(WebServer& server, ClientId client) = 0;
  /// A whole message, at most kLargestMessage bytes; of unknown origin.
  virtual void received(WebServer& server, ClientId client, std::string_view message, bool binary) = 0;
  virtual void closed(ClientId client) = 0;
};

inline constexpr std::size_t kLargestMessage = 64 * 1024;          ///< bytes; longer ones end the connection
inline constexpr std::size_t kMostWaitingMessages = 256;           ///< a client, then the oldest are dropped
inline constexpr std::size_t kMostWaitingBytes = 8 * 1024 * 1024;  ///< a client, likewise

struct ServerOptions {
  int port = 0;                                   ///< 0: any free one
  std::vector<std::string> allowed_origins = {};  ///< of pages beside its own, "https://app.foxglove.dev"
  unsigned patience_s = 5;                        ///< s for a request to be complete
  std::size_t most_clients = 16;                  ///< websockets at once; further ones are refused
};

/// Listens on 127.0.0.1 alone. Refuses requests whose Host is not this address (a name that was bent to it),
/// and websockets whose Origin is another page's. Half requests end after twice patience_s at the latest,
/// silent clients after 20 s.
class WebServer {
 public:
  /// What a path shows; nothing: 404. Called on the server's thread.
  using Get = std::function<std::optional<Resource>(std::string_view path)>;

  /// Errors: bad_input when the port is taken.
  static Result<std::unique_ptr<WebServer>> start(const ServerOptions& options, Get get,
                                                  std::vector<std::shared_ptr<Endpoint>> endpoints);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  int port() const;
  /// Puts a message into a client's queue, from any thread; a client that does not read loses the oldest.
  void send(ClientId client, Bytes message, bool binary = false);
  /// To every client of a subprotocol.
  void broadcast(std::string_view protocol, const Bytes& message, bool binary = false);
  std::size_t clients(std::string_view protocol) const;
  std::uint64_t dropped() const;  ///< messages that slow clients lost

 private:
  struct Impl;
  explicit WebServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace omniflight::view

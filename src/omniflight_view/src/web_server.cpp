#include "omniflight_view/web_server.hpp"

#include <libwebsockets.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

namespace omniflight::view {
namespace {

constexpr std::size_t kChunk = 16 * 1024;          // bytes of a body at once
constexpr std::uint16_t kPing = 8, kSilence = 20;  // s

/// A request that is being answered.
struct Answer {
  Bytes body;
  std::size_t at = 0;
};

struct Client {
  struct Message {
    Bytes bytes;
    bool binary;
  };
  lws* wsi = nullptr;
  Endpoint* endpoint = nullptr;
  std::deque<Message> waiting;
  std::size_t waiting_bytes = 0;
  std::string arriving;
};

/// What libwebsockets keeps for each connection.
struct Session {
  Answer* answer;
  ClientId client;
};

std::string header(lws* wsi, lws_token_indexes token) {
  std::array<char, 512> text{};
  const int length = lws_hdr_copy(wsi, text.data(), static_cast<int>(text.size()), token);
  return length > 0 ? std::string(text.data(), static_cast<std::size_t>(length)) : std::string();
}

const lws_retry_bo_t kRetry = {nullptr, 0, 0, kPing, kSilence, 0};

}  // namespace

struct WebServer::Impl {
  ServerOptions options;
  Get get;
  std::vector<std::shared_ptr<Endpoint>> endpoints;
  std::vector<lws_protocols> protocols;
  lws_context* context = nullptr;
  int port = 0;
  WebServer* server = nullptr;
  std::atomic<bool> ending{false};
  std::thread thread;

  mutable std::mutex mutex;  // guards what follows
  std::map<ClientId, Client> clients;
  ClientId last_client = 0;
  std::uint64_t dropped = 0;

  static Impl& of(lws* wsi) { return *static_cast<Impl*>(lws_context_user(lws_get_context(wsi))); }
  static int on_http(lws* wsi, lws_callback_reasons reason, void* user, void* in, std::size_t length);
  static int on_websocket(lws* wsi, lws_callback_reasons reason, void* user, void* in, std::size_t length);

  bool own_host(lws* wsi) const {
    const std::string host = header(wsi, WSI_TOKEN_HOST), ending_ = ":" + std::to_string(port);
    return host == "127.0.0.1" + ending_ || host == "localhost" + ending_;
  }
  bool allowed_origin(lws* wsi, std::string_view protocol) const {
    if (lws_hdr_total_length(wsi, WSI_TOKEN_ORIGIN) <= 0) return true;  // no page of a browser
    const std::string origin = header(wsi, WSI_TOKEN_ORIGIN), ending_ = ":" + std::to_string(port);
    if (origin == "http://127.0.0.1" + ending_ || origin == "http://localhost" + ending_) return true;
    const bool open = std::any_of(endpoints.begin(), endpoints.end(), [&](const auto& e) {
      return e->protocol() == protocol && e->for_other_pages();
    });
    return open && std::find(options.allowed_origins.begin(), options.allowed_origins.end(), origin) !=
                       options.allowed_origins.end();
  }

  int answer(lws* wsi, Session& session, std::string_view path);
  int write_body(lws* wsi, Session& session);
  int write_message(lws* wsi, const Session& session);
  int receive(lws* wsi, const Session& session, std::string_view part);
  void wake_writers();
  void serve() {
    while (!ending && lws_service(context, 0) >= 0) {
    }
  }
};

int WebServer::Impl::answer(lws* wsi, Session& session, std::string_view path) {
  delete std::exchange(session.answer, nullptr);
  const auto refuse = [wsi](unsigned status) {
    return lws_return_http_status(wsi, status, nullptr) != 0 || lws_http_transaction_completed(wsi) != 0 ? -1
                                                                                                         : 0;
  };
  if (!own_host(wsi)) return refuse(HTTP_STATUS_FORBIDDEN);
  if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) <= 0) return refuse(HTTP_STATUS_METHOD_NOT_ALLOWED);
  const auto resource = get(path);
  if (!resource) return refuse(HTTP_STATUS_NOT_FOUND);
  std::array<unsigned char, LWS_PRE + 2048> buffer{};
  unsigned char *begin = buffer.data() + LWS_PRE, *at = begin, *end = buffer.data() + buffer.size() - 1;
  const auto add = [&](const char* name, std::string_view value) {
    return lws_add_http_header_by_name(wsi, reinterpret_cast<const unsigned char*>(name),
                                       reinterpret_cast<const unsigned char*>(value.data()),
                                       static_cast<int>(value.size()), &at, end) == 0;
  };
  if (lws_add_http_common_headers(wsi, HTTP_STATUS_OK, resource->type, resource->body->size(), &at, end) ||
      !add("content-security-policy:",
           "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
           "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'") ||
      !add("x-content-type-options:", "nosniff") || !add("cache-control:", "no-store") ||
      !add("referrer-policy:", "no-referrer") || lws_finalize_write_http_header(wsi, begin, &at, end))
    return -1;
  session.answer = new Answer{resource->body, 0};
  lws_callback_on_writable(wsi);
  return 0;
}

int WebServer::Impl::write_body(lws* wsi, Session& session) {
  if (!session.answer) return 0;
  Answer& a = *session.answer;
  std::array<unsigned char, LWS_PRE + kChunk> buffer;
  const std::size_t n = std::min(kChunk, a.body->size() - a.at);
  std::copy_n(a.body->data() + a.at, n, buffer.data() + LWS_PRE);
  a.at += n;
  const bool last = a.at == a.body->size();
  if (lws_write(wsi, buffer.data() + LWS_PRE, n, last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) <
      static_cast<int>(n))
    return -1;
  if (!last) {
    lws_callback_on_writable(wsi);
    return 0;
  }
  delete std::exchange(session.answer, nullptr);
  return lws_http_transaction_completed(wsi) ? -1 : 0;
}

int WebServer::Impl::on_http(lws* wsi, lws_callback_reasons reason, void* user, void* in,
                             std::size_t length) {
  auto* session = static_cast<Session*>(user);
  switch (reason) {
    case LWS_CALLBACK_HTTP:
      return of(wsi).answer(wsi, *session, {static_cast<const char*>(in), length});
    case LWS_CALLBACK_HTTP_WRITEABLE:
      return of(wsi).write_body(wsi, *session);
    case LWS_CALLBACK_CLOSED_HTTP:
    case LWS_CALLBACK_HTTP_DROP_PROTOCOL:
      if (session) delete std::exchange(session->answer, nullptr);
      return 0;
    case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
      if (auto* impl = static_cast<Impl*>(lws_context_user(lws_get_context(wsi)))) impl->wake_writers();
      return 0;
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:  // a websocket without one of our subprotocols
      return -1;
    default:
      return 0;
  }
}

void WebServer::Impl::wake_writers() {
  const std::lock_guard lock(mutex);
  for (auto& [id, client] : clients)
    if (!client.waiting.empty()) lws_callback_on_writable(client.wsi);
}

int WebServer::Impl::write_message(lws* wsi, const Session& session) {
  Client::Message message;
  bool more = false;
  {
    const std::lock_guard lock(mutex);
    const auto found = clients.find(session.client);
    if (found == clients.end() || found->second.waiting.empty()) return 0;
    message = std::move(found->second.waiting.front());
    found->second.waiting.pop_front();
    found->second.waiting_bytes -= message.bytes->size();
    more = !found->second.waiting.empty();
  }
  std::string buffer(LWS_PRE + message.bytes->size(), '\0');
  std::copy(message.bytes->begin(), message.bytes->end(), buffer.begin() + LWS_PRE);
  if (lws_write(wsi, reinterpret_cast<unsigned char*>(buffer.data()) + LWS_PRE, message.bytes->size(),
                message.binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT) < static_cast<int>(message.bytes->size()))
    return -1;
  if (more) lws_callback_on_writable(wsi);
  return 0;
}

int WebServer::Impl::receive(lws* wsi, const Session& session, std::string_view part) {
  std::string whole;
  Endpoint* endpoint = nullptr;
  {
    const std::lock_guard lock(mutex);
    const auto found = clients.find(session.client);
    if (found == clients.end()) return -1;
    std::string& arriving = found->second.arriving;
    if (lws_is_first_fragment(wsi)) arriving.clear();
    if (arriving.size() + part.size() > kLargestMessage) {
      lws_close_reason(wsi, LWS_CLOSE_STATUS_MESSAGE_TOO_LARGE, nullptr, 0);
      return -1;
    }
    arriving += part;
    if (!lws_is_final_fragment(wsi) || lws_remaining_packet_payload(wsi) > 0) return 0;
    whole.swap(arriving);
    endpoint = found->second.endpoint;
  }
  endpoint->received(*server, session.client, whole, lws_frame_is_binary(wsi) != 0);
  return 0;
}

int WebServer::Impl::on_websocket(lws* wsi, lws_callback_reasons reason, void* user, void* in,
                                  std::size_t length) {
  auto* session = static_cast<Session*>(user);
  switch (reason) {
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION: {
      Impl& impl = of(wsi);
      const std::lock_guard lock(impl.mutex);
      return impl.own_host(wsi) && impl.allowed_origin(wsi, in ? static_cast<const char*>(in) : "") &&
                     impl.clients.size() < impl.options.most_clients
                 ? 0
                 : -1;
    }
    case LWS_CALLBACK_ESTABLISHED: {
      Impl& impl = of(wsi);
      Endpoint* endpoint = nullptr;
      for (const auto& e : impl.endpoints)
        if (std::string_view(lws_get_protocol(wsi)->name) == e->protocol()) endpoint = e.get();
      {
        const std::lock_guard lock(impl.mutex);
        session->client = ++impl.last_client;
        Client& client = impl.clients[session->client];
        client.wsi = wsi;
        client.endpoint = endpoint;
      }
      endpoint->opened(*impl.server, session->client);
      return 0;
    }
    case LWS_CALLBACK_RECEIVE:
      return of(wsi).receive(wsi, *session, {static_cast<const char*>(in), length});
    case LWS_CALLBACK_SERVER_WRITEABLE:
      return of(wsi).write_message(wsi, *session);
    case LWS_CALLBACK_CLOSED: {
      Impl& impl = of(wsi);
      Endpoint* endpoint = nullptr;
      {
        const std::lock_guard lock(impl.mutex);
        const auto found = impl.clients.find(session->client);
        if (found == impl.clients.end()) return 0;
        endpoint = found->second.endpoint;
        impl.clients.erase(found);
      }
      endpoint->closed(session->client);
      return 0;
    }
    default:
      return 0;
  }
}

Result<std::unique_ptr<WebServer>> WebServer::start(const ServerOptions& options, Get get,
                                                    std::vector<std::shared_ptr<Endpoint>> endpoints) {
  lws_set_log_level(0, nullptr);
  auto impl = std::make_unique<Impl>();
  impl->options = options;
  impl->get = std::move(get);
  impl->endpoints = std::move(endpoints);
  const auto protocol = [&](const char* name, lws_callback_function* callback) {
    lws_protocols p{};
    p.name = name;
    p.callback = callback;
    p.per_session_data_size = sizeof(Session);
    p.rx_buffer_size = 4096;
    impl->protocols.push_back(p);
  };
  protocol("http-only", &Impl::on_http);
  for (const auto& e : impl->endpoints) protocol(e->protocol(), &Impl::on_websocket);
  impl->protocols.push_back({});
  lws_context_creation_info info{};
  info.port = options.port;
  info.iface = "127.0.0.1";
  info.protocols = impl->protocols.data();
  info.user = impl.get();
  info.gid = info.uid = static_cast<decltype(info.gid)>(-1);
  info.timeout_secs = options.patience_s;
  info.timeout_secs_ah_idle = options.patience_s;
  info.keepalive_timeout = static_cast<int>(options.patience_s);
  info.retry_and_idle_policy = &kRetry;
  info.options = LWS_SERVER_OPTION_DISABLE_IPV6 | LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND |
                 LWS_SERVER_OPTION_EXPLICIT_VHOSTS;
  impl->context = lws_create_context(&info);
  if (!impl->context) return fail(ErrorCode::internal, "the server cannot be made", "view");
  lws_vhost* host = lws_create_vhost(impl->context, &info);
  impl->port = host ? lws_get_vhost_listen_port(host) : -1;
  if (impl->port <= 0) {
    lws_context_destroy(impl->context);
    return bad_input("port " + std::to_string(options.port) + " of 127.0.0.1 cannot be had", "view: port",
                     "Another program listens there; choose another --port, or 0 for any");
  }
  Impl* raw = impl.get();
  std::unique_ptr<WebServer> server(new WebServer(std::move(impl)));
  raw->server = server.get();
  raw->thread = std::thread([raw] { raw->serve(); });
  return server;
}

WebServer::WebServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

WebServer::~WebServer() {
  impl_->ending = true;
  lws_cancel_service(impl_->context);
  impl_->thread.join();
  lws_context_destroy(impl_->context);
}

int WebServer::port() const { return impl_->port; }

void WebServer::send(ClientId id, Bytes message, bool binary) {
  {
    const std::lock_guard lock(impl_->mutex);
    const auto found = impl_->clients.find(id);
    if (found == impl_->clients.end()) return;
    Client& client = found->second;
    client.waiting_bytes += message->size();
    client.waiting.push_back({std::move(message), binary});
    while (client.waiting.size() > 1 &&
           (client.waiting.size() > kMostWaitingMessages || client.waiting_bytes > kMostWaitingBytes)) {
      client.waiting_bytes -= client.waiting.front().bytes->size();
      client.waiting.pop_front();
      ++impl_->dropped;
    }
  }
  lws_cancel_service(impl_->context);
}

void WebServer::broadcast(std::string_view protocol, const Bytes& message, bool binary) {
  std::vector<ClientId> ids;
  {
    const std::lock_guard lock(impl_->mutex);
    for (const auto& [id, client] : impl_->clients)
      if (client.endpoint && protocol == client.endpoint->protocol()) ids.push_back(id);
  }
  for (const ClientId id : ids) send(id, message, binary);
}

std::size_t WebServer::clients(std::string_view protocol) const {
  const std::lock_guard lock(impl_->mutex);
  return static_cast<std::size_t>(std::count_if(
      impl_->clients.begin(), impl_->clients.end(),
      [&](const auto& c) { return c.second.endpoint && protocol == c.second.endpoint->protocol(); }));
}

std::uint64_t WebServer::dropped() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->dropped;
}

}  // namespace omniflight::view

// The server as a hostile or broken client meets it, and as a page does: over real sockets.
#include "omniflight_view/web_server.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <thread>

namespace omniflight::view {
namespace {

using namespace std::chrono_literals;

class Echo final : public Endpoint {
 public:
  const char* protocol() const override { return "echo.v1"; }
  void opened(WebServer& server, ClientId client) override {
    server.send(client, std::make_shared<const std::string>("hello"));
  }
  void received(WebServer& server, ClientId client, std::string_view message, bool binary) override {
    server.send(client, std::make_shared<const std::string>(message), binary);
  }
  void closed(ClientId) override { ++closed_; }
  bool for_other_pages() const override { return open_; }
  std::atomic<int> closed_{0};
  std::atomic<bool> open_{true};
};

std::optional<Resource> page(std::string_view path) {
  if (path == "/") return Resource{"text/html", std::make_shared<const std::string>("<p>here</p>")};
  if (path == "/large") return Resource{"text/plain", std::make_shared<const std::string>(3'000'000, 'x')};
  return {};
}

bool within(std::chrono::milliseconds limit, const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(2ms);
  }
  return true;
}

/// A plain TCP connection to 127.0.0.1.
class Wire {
 public:
  explicit Wire(int port) : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = connect(fd_, reinterpret_cast<sockaddr*>(&to), sizeof to) == 0;
  }
  ~Wire() { close(fd_); }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;
  bool connected() const { return connected_; }
  void say(std::string_view text) const { (void)::send(fd_, text.data(), text.size(), MSG_NOSIGNAL); }
  /// Reads until `enough`, the end of the connection or the limit.
  std::string hear(const std::function<bool(const std::string&)>& enough,
                   std::chrono::milliseconds limit = 3s) {
    std::string out;
    const auto end = std::chrono::steady_clock::now() + limit;
    while (!enough(out)) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
      pollfd p{fd_, POLLIN, 0};
      if (left.count() <= 0 || poll(&p, 1, static_cast<int>(left.count())) <= 0) break;
      char buffer[16384];
      const ssize_t n = recv(fd_, buffer, sizeof buffer, 0);
      if (n <= 0) {
        ended_ = true;
        break;
      }
      out.append(buffer, static_cast<std::size_t>(n));
    }
    return out;
  }
  bool ended() const { return ended_; }

 private:
  int fd_;
  bool connected_ = false, ended_ = false;
};

struct Served {
  std::shared_ptr<Echo> echo = std::make_shared<Echo>();
  std::unique_ptr<WebServer> server;
  explicit Served(ServerOptions options = {}) {
    auto made = WebServer::start(options, page, {echo});
    EXPECT_TRUE(made) << (made ? "" : made.error().text());
    if (made) server = std::move(*made);
  }
  std::string host() const { return "127.0.0.1:" + std::to_string(server->port()); }
};

std::string request(const Served& s, const std::string& line, const std::string& host) {
  Wire wire(s.server->port());
  wire.say(line + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n");
  return wire.hear([](const std::string&) { return false; });
}

std::string upgrade(const std::string& host, const std::string& more,
                    const std::string& protocol = "echo.v1") {
  return "GET / HTTP/1.1\r\nHost: " + host + "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n" +
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n" +
         (protocol.empty() ? "" : "Sec-WebSocket-Protocol: " + protocol + "\r\n") + more + "\r\n";
}

/// A masked frame of a client (RFC 6455, section 5.2), mask zero.
std::string frame(char opcode, const std::string& payload) {
  std::string out{static_cast<char>(0x80 | opcode)};
  const std::size_t n = payload.size();
  if (n < 126) {
    out += static_cast<char>(0x80 | n);
  } else if (n < 65536) {
    out += static_cast<char>(0x80 | 126);
    out += static_cast<char>(n >> 8);
    out += static_cast<char>(n & 255);
  } else {
    out += static_cast<char>(0x80 | 127);
    for (int k = 7; k >= 0; --k) out += static_cast<char>((static_cast<std::uint64_t>(n) >> (8 * k)) & 255);
  }
  return out + std::string(4, '\0') + payload;
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(WebServer, AnswersItsPathsAndNoOthers) {
  const Served s;
  const std::string here = request(s, "GET /", s.host());
  EXPECT_TRUE(has(here, "200 OK")) << here;
  EXPECT_TRUE(has(here, "<p>here</p>"));
  EXPECT_TRUE(has(here, "default-src 'none'"));
  EXPECT_TRUE(has(request(s, "GET /../etc/passwd", s.host()), "404"));
  EXPECT_FALSE(has(request(s, "POST /", s.host()), "<p>here"));
}

TEST(WebServer, ALargeBodyComesWhole) {
  const Served s;
  const std::string all = request(s, "GET /large", s.host());
  EXPECT_EQ(all.size() - all.find("\r\n\r\n") - 4, 3'000'000U);
}

TEST(WebServer, ANameThatIsBentToTheLoopbackIsRefused) {
  const Served s;
  EXPECT_FALSE(has(request(s, "GET /", "evil.example:" + std::to_string(s.server->port())), "<p>here"));
  EXPECT_TRUE(has(request(s, "GET /", "localhost:" + std::to_string(s.server->port())), "<p>here"));
}

TEST(WebServer, WebsocketsOfOtherPagesAreRefused) {
  const Served s({.allowed_origins = {"https://viewer.example"}});
  const auto opens = [&](const std::string& more, const std::string& protocol = "echo.v1") {
    Wire wire(s.server->port());
    wire.say(upgrade(s.host(), more, protocol));
    return has(wire.hear([](const std::string& t) { return has(t, "hello"); }, 1s), " 101 ");
  };
  EXPECT_TRUE(opens(""));
  EXPECT_TRUE(opens("Origin: http://" + s.host() + "\r\n"));
  EXPECT_TRUE(opens("Origin: https://viewer.example\r\n"));
  EXPECT_FALSE(opens("Origin: https://evil.example\r\n"));
  EXPECT_FALSE(opens("Origin: null\r\n"));
  s.echo->open_ = false;
  EXPECT_FALSE(opens("Origin: https://viewer.example\r\n"));
  EXPECT_TRUE(opens("Origin: http://" + s.host() + "\r\n"));
  EXPECT_FALSE(opens("", "another.v1"));
  EXPECT_FALSE(opens("", ""));
}

TEST(WebServer, MessagesGoThereAndBackAndTooLongOnesEndTheConnection) {
  const Served s;
  Wire wire(s.server->port());
  wire.say(upgrade(s.host(), ""));
  ASSERT_TRUE(has(wire.hear([](const std::string& t) { return has(t, "hello"); }), "hello"));
  wire.say(frame(1, "ping pong"));
  EXPECT_TRUE(has(wire.hear([](const std::string& t) { return has(t, "ping pong"); }), "ping pong"));
  const std::string large(kLargestMessage, 'y');
  wire.say(frame(2, large));
  EXPECT_TRUE(has(wire.hear([&](const std::string& t) { return t.size() > large.size(); }), large));
  EXPECT_FALSE(wire.ended());
  wire.say(frame(1, large + "y"));
  const std::string too_large("\x03\xf1", 2);  // status 1009 of RFC 6455
  EXPECT_TRUE(has(wire.hear([&](const std::string& t) { return has(t, too_large); }), too_large));
  wire.say(frame(8, too_large));
  (void)wire.hear([](const std::string&) { return false; });
  EXPECT_TRUE(wire.ended());
  EXPECT_TRUE(within(2s, [&] { return s.echo->closed_ == 1; }));
}

TEST(WebServer, HalfRequestsEndAndOthersAreServedMeanwhile) {
  const Served s({.patience_s = 1});
  Wire half(s.server->port());
  half.say("GET / HTTP/1.1\r\nHost: 127");
  EXPECT_TRUE(has(request(s, "GET /", s.host()), "<p>here"));
  (void)half.hear([](const std::string&) { return false; }, 12s);
  EXPECT_TRUE(half.ended());
}

TEST(WebServer, RubbishIsNoCrash) {
  const Served s;
  std::uint32_t seed = 1;
  for (int k = 0; k < 60; ++k) {
    std::string noise = k % 2 ? upgrade(s.host(), "") : "";
    for (int i = 0; i < 400; ++i) noise += static_cast<char>((seed = seed * 1664525U + 1013904223U) >> 24);
    const Wire wire(s.server->port());
    wire.say(noise);
  }
  EXPECT_TRUE(has(request(s, "GET /", s.host()), "<p>here"));
}

TEST(WebServer, AClientThatDoesNotReadLosesTheOldestAndHoldsNobodyUp) {
  const Served s;
  Wire sleeping(s.server->port());
  sleeping.say(upgrade(s.host(), ""));
  ASSERT_TRUE(within(2s, [&] { return s.server->clients("echo.v1") == 1; }));
  const auto message = std::make_shared<const std::string>(100'000, 'z');
  const auto begin = std::chrono::steady_clock::now();
  for (int k = 0; k < 1000; ++k) s.server->broadcast("echo.v1", message);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 3s);
  EXPECT_GT(s.server->dropped(), 500U);
  EXPECT_TRUE(has(request(s, "GET /", s.host()), "<p>here"));
}

TEST(WebServer, OnlySoManyClientsAndAPortOnlyOnce) {
  const Served s({.most_clients = 2});
  Wire a(s.server->port()), b(s.server->port()), c(s.server->port());
  for (Wire* w : {&a, &b}) {
    w->say(upgrade(s.host(), ""));
    ASSERT_TRUE(has(w->hear([](const std::string& t) { return has(t, "hello"); }), "hello"));
  }
  c.say(upgrade(s.host(), ""));
  EXPECT_FALSE(has(c.hear([](const std::string& t) { return has(t, "hello"); }, 1s), "hello"));
  const auto again = WebServer::start({.port = s.server->port()}, page, {s.echo});
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::bad_input);
}

}  // namespace
}  // namespace omniflight::view

// The page of a flight: its files, and the websocket that moves it.
#pragma once

#include <functional>
#include <mutex>
#include <string>

#include "omniflight_view/scene.hpp"
#include "omniflight_view/web_server.hpp"

namespace omniflight::view {

/// Subprotocol omniflight.view.v1. To the page: frames (frame_json), {"path": [...]}, {"answer": "..."}. From
/// the page: {"wish": "cut"} and nothing else; what is not that is ignored and counted.
class ViewPage final : public Endpoint {
 public:
  /// What an operator's stop leads to; the answer is shown. Called on the server's thread, must not wait.
  using OnStop = std::function<std::string()>;

  /// replay: of replay_json, or empty for a live flight. Scene::may_stop needs on_stop.
  ViewPage(const Scene& scene, std::string replay, OnStop on_stop);

  std::optional<Resource> get(std::string_view path) const;
  /// From any thread. Who comes later gets the last one of each at once.
  void show(WebServer& server, const std::string& frame);
  void show_path(WebServer& server, const std::vector<Vec3>& path);
  std::uint64_t refused() const;  ///< messages of pages that were no wish

  const char* protocol() const override { return "omniflight.view.v1"; }
  void opened(WebServer& server, ClientId client) override;
  void received(WebServer& server, ClientId client, std::string_view message, bool binary) override;
  void closed(ClientId) override {}

 private:
  Bytes scene_, replay_;
  OnStop on_stop_;
  mutable std::mutex mutex_;  // guards what follows
  Bytes last_frame_, path_;
  std::uint64_t refused_ = 0;
};

}  // namespace omniflight::view

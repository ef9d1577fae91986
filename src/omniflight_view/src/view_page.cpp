#include "omniflight_view/view_page.hpp"

#include <nlohmann/json.hpp>

extern "C" {
#define OMNIFLIGHT_ASSET(name) extern const char omniflight_view_##name[], omniflight_view_##name##_end[]
OMNIFLIGHT_ASSET(view_html);
OMNIFLIGHT_ASSET(view_css);
OMNIFLIGHT_ASSET(view_js);
OMNIFLIGHT_ASSET(world_js);
OMNIFLIGHT_ASSET(three_js);
OMNIFLIGHT_ASSET(dygraph_js);
OMNIFLIGHT_ASSET(dygraph_css);
#undef OMNIFLIGHT_ASSET
}

namespace omniflight::view {
namespace {

constexpr const char *kScript = "text/javascript; charset=utf-8", *kStyle = "text/css; charset=utf-8",
                     *kJson = "application/json", *kPage = "text/html; charset=utf-8";

struct Asset {
  std::string_view path;
  const char* type;
  const char *begin, *end;
};
const Asset kAssets[] = {
    {"/", kPage, omniflight_view_view_html, omniflight_view_view_html_end},
    {"/view.css", kStyle, omniflight_view_view_css, omniflight_view_view_css_end},
    {"/view.js", kScript, omniflight_view_view_js, omniflight_view_view_js_end},
    {"/world.js", kScript, omniflight_view_world_js, omniflight_view_world_js_end},
    {"/three.js", kScript, omniflight_view_three_js, omniflight_view_three_js_end},
    {"/dygraph.js", kScript, omniflight_view_dygraph_js, omniflight_view_dygraph_js_end},
    {"/dygraph.css", kStyle, omniflight_view_dygraph_css, omniflight_view_dygraph_css_end},
};

Bytes bytes(std::string text) { return std::make_shared<const std::string>(std::move(text)); }

/// Whether a message is the one wish that a page may have.
bool is_stop(std::string_view message) {
  const auto j = nlohmann::json::parse(message, nullptr, false);
  return j.is_object() && j.size() == 1 && j.contains("wish") && j["wish"].is_string() && j["wish"] == "cut";
}

}  // namespace

ViewPage::ViewPage(const Scene& scene, std::string replay, OnStop on_stop)
    : scene_(bytes(scene_json(scene))),
      replay_(replay.empty() ? nullptr : bytes(std::move(replay))),
      on_stop_(scene.may_stop ? std::move(on_stop) : nullptr) {}

std::optional<Resource> ViewPage::get(std::string_view path) const {
  if (path == "/scene.json") return Resource{kJson, scene_};
  if (path == "/replay.json" && replay_) return Resource{kJson, replay_};
  for (const Asset& a : kAssets)
    if (path == a.path) return Resource{a.type, bytes(std::string(a.begin, a.end))};
  return std::nullopt;
}

void ViewPage::show(WebServer& server, const std::string& frame) {
  const Bytes message = bytes(frame);
  {
    const std::lock_guard lock(mutex_);
    last_frame_ = message;
  }
  server.broadcast(protocol(), message);
}

void ViewPage::show_path(WebServer& server, const std::vector<Vec3>& path) {
  const Bytes message = bytes("{\"path\":" + path_json(path) + "}");
  {
    const std::lock_guard lock(mutex_);
    path_ = message;
  }
  server.broadcast(protocol(), message);
}

void ViewPage::opened(WebServer& server, ClientId client) {
  Bytes path, frame;
  {
    const std::lock_guard lock(mutex_);
    path = path_;
    frame = last_frame_;
  }
  if (path) server.send(client, path);
  if (frame) server.send(client, frame);
}

void ViewPage::received(WebServer& server, ClientId client, std::string_view message, bool binary) {
  if (binary || !on_stop_ || !is_stop(message)) {
    const std::lock_guard lock(mutex_);
    ++refused_;
    return;
  }
  server.send(client, bytes(nlohmann::json{{"answer", on_stop_()}}.dump()));
}

std::uint64_t ViewPage::refused() const {
  const std::lock_guard lock(mutex_);
  return refused_;
}

}  // namespace omniflight::view

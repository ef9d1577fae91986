// What the page is told: numbers that JSON can hold, in the order of the vehicle's rotors, and few enough.
#include "omniflight_view/scene.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "omniflight_view/view_page.hpp"

namespace omniflight::view {
namespace {

using nlohmann::json;

vehicle::Vehicle two_rotors() {
  vehicle::Vehicle v;
  v.name = "pair <of> \"rotors\"";
  v.mass = 1;
  v.rotors.resize(2);
  for (auto& r : v.rotors) r.thrust_coefficient = 1e-5, r.max_thrust = 10, r.drag_ratio = 0.01;
  v.rotors[1].bidirectional = true;
  return v;
}

recording::Recording flight(std::size_t n) {
  recording::Recording r;
  recording::Signal p{"position", "m", {}, Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n), 3), "test"};
  for (std::size_t i = 0; i < n; ++i) {
    p.t_s.push_back(1000 + 0.001 * static_cast<double>(i));
    p.values(static_cast<Eigen::Index>(i), 2) = 0.001 * static_cast<double>(i);
  }
  recording::Signal w{"rotor_speed", "rad/s", {1000.5, 1001}, Eigen::MatrixXd::Constant(2, 2, 500), "test"};
  r.signals = {{"position", p}, {"rotor_speed", w}};
  r.duration_s = 0.001 * static_cast<double>(n);
  return r;
}

TEST(Scene, LoadsAreThrustOverTheLimitAndUnknownIsNull) {
  Frame f;
  f.t = 123456.789;
  f.rotor_speed = {1000, -500};
  f.gate = "armed \xff";
  const json j = json::parse(frame_json(f, two_rotors()));
  EXPECT_DOUBLE_EQ(j["t"], 123456.789);
  EXPECT_DOUBLE_EQ(j["load"][0], 1.0);
  EXPECT_DOUBLE_EQ(j["load"][1], 0.25);
  EXPECT_NEAR(j["power"], 0.01 * 1e-5 * (1e9 + 1.25e8), 0.01);
  EXPECT_TRUE(j["p"][0].is_null());
  EXPECT_TRUE(j["alpha"].is_null());
}

TEST(Scene, AReplayIsBoundedAndKeepsTheEnds) {
  const auto text = replay_json(flight(20'001), two_rotors(), 50, 300);
  ASSERT_TRUE(text);
  const json j = json::parse(*text);
  ASSERT_EQ(j["t"].size(), 300U);
  EXPECT_DOUBLE_EQ(j["t"].front(), 1000);
  EXPECT_DOUBLE_EQ(j["t"].back(), 1020);
  EXPECT_NEAR(j["p"][2].back(), 20.0, 1e-3);
  EXPECT_TRUE(j["load"][0].front().is_null());  // the rotors were recorded later
  EXPECT_DOUBLE_EQ(j["load"][0][12], 0.25);
  EXPECT_EQ(j["alpha"].size(), 0U);
}

TEST(Scene, ARecordingWithoutAPoseIsRefused) {
  recording::Recording r = flight(10);
  r.signals.erase("position");
  const auto text = replay_json(r, two_rotors());
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().code, ErrorCode::bad_input);
}

TEST(Scene, NamesAreEscaped) {
  Scene s;
  s.title = "</script> \"x\"";
  s.vehicle = two_rotors();
  const json j = json::parse(scene_json(s));
  EXPECT_EQ(j["title"], s.title);
  EXPECT_EQ(j["vehicle"]["rotors"].size(), 2U);
}

/// A page hears and answers; here nobody is connected, and what arrives is judged all the same.
TEST(ViewPage, OnlyTheStopIsAWish) {
  Scene s;
  s.vehicle = two_rotors();
  s.live = s.may_stop = true;
  int stops = 0;
  const auto page = std::make_shared<ViewPage>(s, "", [&] { return ++stops, std::string("said"); });
  auto server = WebServer::start({}, [&](std::string_view path) { return page->get(path); }, {page});
  ASSERT_TRUE(server);
  for (const char* hostile : {"", "{", "null", "[]", "{\"wish\":\"arm\"}", "{\"wish\":\"cut\",\"x\":1}",
                              "{\"wish\":1}", "{\"wish\":[\"cut\"]}", "\"cut\""})
    page->received(**server, 1, hostile, false);
  page->received(**server, 1, "{\"wish\":\"cut\"}", true);
  EXPECT_EQ(stops, 0);
  EXPECT_EQ(page->refused(), 10U);
  page->received(**server, 1, "{\"wish\":\"cut\"}", false);
  EXPECT_EQ(stops, 1);
  s.may_stop = false;
  ViewPage without(s, "", [&] { return ++stops, std::string(); });
  without.received(**server, 1, "{\"wish\":\"cut\"}", false);
  EXPECT_EQ(stops, 1);
}

TEST(ViewPage, ShowsItsFilesAndAReplayOnlyWhenThereIsOne) {
  const ViewPage live({}, "", {}), replay({}, "{}", {});
  for (const char* path : {"/", "/view.js", "/world.js", "/view.css", "/three.js", "/dygraph.js",
                           "/dygraph.css", "/scene.json"}) {
    const auto found = live.get(path);
    ASSERT_TRUE(found) << path;
    EXPECT_GT(found->body->size(), 100U) << path;
  }
  EXPECT_FALSE(live.get("/replay.json"));
  EXPECT_TRUE(replay.get("/replay.json"));
  EXPECT_FALSE(live.get("/nothing"));
}

}  // namespace
}  // namespace omniflight::view

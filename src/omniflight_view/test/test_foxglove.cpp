// Foxglove's protocol, byte by byte as its specification has it, spoken by a hostile and a good client.
#include "omniflight_view/foxglove.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "omniflight_view/foxglove_scene.hpp"

namespace omniflight::view {
namespace {

using nlohmann::json;

/// A server that nobody can reach; what is published to clients that do not exist goes nowhere.
struct Room {
  std::shared_ptr<FoxgloveEndpoint> fox = std::make_shared<FoxgloveEndpoint>(
      "test", std::vector<FoxgloveChannel>{{"/a", "cdr", "x/msg/A", "float64 x", "ros2msg", false},
                                           {"/b", "json", "B", "{}", "jsonschema", true}});
  std::unique_ptr<WebServer> server;
  Room() {
    auto made = WebServer::start({}, [](std::string_view) { return std::optional<Resource>(); }, {fox});
    if (made) server = std::move(*made);
  }
};

TEST(Foxglove, CountsItsSubscribers) {
  Room room;
  ASSERT_TRUE(room.server);
  EXPECT_FALSE(room.fox->wanted(0));
  EXPECT_TRUE(room.fox->wanted(1));  // latched
  room.fox->opened(*room.server, 7);
  room.fox->received(*room.server, 7, R"({"op":"subscribe","subscriptions":[{"id":3,"channelId":0}]})",
                     false);
  EXPECT_TRUE(room.fox->wanted(0));
  room.fox->received(*room.server, 7, R"({"op":"subscribe","subscriptions":[{"id":3,"channelId":1}]})",
                     false);
  room.fox->received(*room.server, 7, R"({"op":"unsubscribe","subscriptionIds":[4,"x",-1,3]})", false);
  EXPECT_FALSE(room.fox->wanted(0));
  room.fox->received(*room.server, 7, R"({"op":"subscribe","subscriptions":[{"id":9,"channelId":0}]})",
                     false);
  room.fox->closed(7);
  EXPECT_FALSE(room.fox->wanted(0));
}

TEST(Foxglove, HostileMessagesChangeNothing) {
  Room room;
  room.fox->opened(*room.server, 1);
  for (const char* hostile : {"", "{", "[]", "{}", R"({"op":7})", R"({"op":"subscribe"})",
                              R"({"op":"subscribe","subscriptions":[{}]})",
                              R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":2}]})",
                              R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":0}]})",
                              R"({"op":"subscribe","subscriptions":[{"id":99999999999,"channelId":0}]})",
                              R"({"op":"subscribe","subscriptions":[{"id":1e3,"channelId":0}]})",
                              R"({"op":"setParameters","parameters":[]})"})
    room.fox->received(*room.server, 1, hostile, false);
  std::string long_word = "x";
  for (int k = 0; k < 100; ++k) long_word += "\u00e4";  // is cut in the middle of a character
  room.fox->received(*room.server, 1, "{\"op\":\"" + long_word + "\"}", false);
  room.fox->received(*room.server, 1, R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":0}]})", true);
  EXPECT_FALSE(room.fox->wanted(0));
}

/// Every field of a message is in its schema, with the type that it names.
void fits(const json& value, const json& schema, const std::string& where) {
  const std::string type = schema["type"];
  if (type == "object") {
    ASSERT_TRUE(value.is_object()) << where;
    for (const auto& [key, inner] : value.items()) {
      ASSERT_TRUE(schema["properties"].contains(key)) << where << "." << key;
      fits(inner, schema["properties"][key], where + "." + key);
    }
  } else if (type == "array") {
    ASSERT_TRUE(value.is_array()) << where;
    for (const json& inner : value) fits(inner, schema["items"], where + "[]");
  } else {
    EXPECT_TRUE(type == "string"    ? value.is_string()
                : type == "boolean" ? value.is_boolean()
                : type == "integer" ? value.is_number_integer()
                                    : value.is_number())
        << where << ": " << value;
  }
}

TEST(FoxgloveScene, MessagesFitTheirSchemas) {
  vehicle::Vehicle v;
  v.rotors.resize(2);
  for (auto& r : v.rotors) r.thrust_coefficient = 1e-5, r.max_thrust = 10, r.tilts = true, r.radius = 0.1;
  v.rotors[0].p_BR = Vec3(0.3, 0, 0);
  Frame f;
  EXPECT_EQ(transform_message(f, 0), "");  // not known yet
  f.p_WB = Vec3(1, 2, 3);
  f.rotor_speed = {1000, 0};
  f.alpha = kPi / 2;  // about x: the disc's axis turns from z to -y
  fits(json::parse(transform_message(f, 5'000'000'001)), json::parse(transform_channel().schema),
       "transform");
  const json vehicle = json::parse(vehicle_message(v, f, 1));
  fits(vehicle, json::parse(vehicle_channel().schema), "vehicle");
  const json& drawn = vehicle["entities"][0]["cylinders"];
  ASSERT_EQ(drawn.size(), 3U);  // an arm, and two discs
  const json& q = drawn[1]["pose"]["orientation"];
  const Vec3 axis = Quat(q["w"], q["x"], q["y"], q["z"]) * Vec3::UnitZ();
  EXPECT_NEAR((axis - Vec3(0, -1, 0)).norm(), 0, 1e-9);
  EXPECT_NE(drawn[1]["color"], drawn[2]["color"]);  // one is at its limit
  planning::Primitive box, rope;
  box.b = Vec3(1, 1, 1);
  rope.kind = planning::Primitive::Kind::capsule;
  rope.b = Vec3(0, 0, 1), rope.radius = 0.01;
  fits(json::parse(world_message({box, rope}, 1)), json::parse(world_channel().schema), "world");
  const json plan = json::parse(plan_message(std::vector<Vec3>(100'000, Vec3::Ones()), 1));
  fits(plan, json::parse(plan_channel().schema), "plan");
  EXPECT_LE(plan["entities"][0]["lines"][0]["points"].size(), 2000U);
}

}  // namespace
}  // namespace omniflight::view

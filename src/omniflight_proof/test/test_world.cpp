// World files: read whole, with defaults, and refused by file, line, field and unit.
#include <filesystem>

#include "fixture.hpp"
#include "omniflight_proof/sensors.hpp"

namespace omniflight::proof {
namespace {

Result<World> read(const std::string& body) {
  auto yaml = files::YamlReader::parse("schema: omniflight.proof_world/1\n" + body, "w.yaml");
  if (!yaml) return Failure(yaml.error());
  return read_world(*yaml);
}
std::string refusal(const std::string& body) {
  const auto world = read(body);
  return world ? "accepted" : world.error().text();
}

TEST(WorldFile, AbsentMeansNominalAndPresentMeansDefaults) {
  const auto world = read(
      "name: x\ncable: {links: 16}\nwind: {velocity_mps: [1, 2, 0]}\nblades: {}\n"
      "rotors:\n  - {rotor: 3, thrust_scale: 0.7, axis_tilt_deg: [0, 90, 0]}\n");
  EXPECT_FALSE(world) << "45 deg is the most a rotor axis may be off";
  const auto good = read(
      "cable: {links: 16}\nwind: {velocity_mps: [1, 2, 0]}\nblades: {}\n"
      "rotors:\n  - {rotor: 3, thrust_scale: 0.7, axis_tilt_deg: [0, 9, 0]}\n"
      "sensors:\n  faults:\n    - {sensor: rotor_speed, rotor: 2, frozen: true}\n");
  ASSERT_TRUE(good) << good.error().text();
  EXPECT_EQ(good->cable->links, 16);
  EXPECT_EQ(good->cable->linear_density, Cable{}.linear_density);
  EXPECT_EQ(good->wind->velocity_W, Vec3(1, 2, 0));
  ASSERT_EQ(good->rotors.size(), 1u);
  EXPECT_NEAR(good->rotors[0].axis_tilt_B.y(), to_radians(9.0), 1e-12);
  EXPECT_TRUE(good->sensors.faults[0].frozen);
  EXPECT_FALSE(good->jets);
  const auto nominal = read("name: nothing\n");
  ASSERT_TRUE(nominal);
  EXPECT_FALSE(nominal->articulated());
}

TEST(WorldFile, RefusesByFileLineFieldAndUnit) {
  EXPECT_NE(refusal("cabel: {}\n").find("w.yaml:2"), std::string::npos) << refusal("cabel: {}\n");
  EXPECT_NE(refusal("cabel: {}\n").find("cable"), std::string::npos) << "names the nearest key";
  const std::string mass = refusal("name: x\nbody:\n  payload_kg: -0.2\n");
  EXPECT_NE(mass.find("w.yaml:4: body.payload_kg"), std::string::npos) << mass;
  EXPECT_NE(mass.find("kg"), std::string::npos) << mass;
  EXPECT_NE(refusal("timestep_s: .nan\n").find("timestep_s"), std::string::npos);
  EXPECT_NE(refusal("cable: {length_m: .inf}\n").find("cable.length_m"), std::string::npos);
  EXPECT_NE(refusal("cable: {links: 4000}\n").find("cable.links"), std::string::npos);
  EXPECT_NE(refusal("laws: [{kind: magic, gain: 1}]\n").find("kind"), std::string::npos);
  EXPECT_NE(refusal("laws: [{kind: well, gain: 1, axis: [0, 0, 0]}]\n").find("without direction"),
            std::string::npos);
  EXPECT_NE(refusal("wind: {velocity_mps: [1, 0, 0]}\n").find("blows on nothing"), std::string::npos);
  auto other = files::YamlReader::parse("schema: omniflight.model/1\n", "m.yaml");
  ASSERT_TRUE(other);
  EXPECT_NE(read_world(*other).error().text().find("is not omniflight.proof_world/1"), std::string::npos);
}

TEST(WorldFile, EveryWorldAndSensorFileOfTheProjectIsRead) {
  namespace fs = std::filesystem;
  const fs::path configs = fs::path(OMNIFLIGHT_SOURCE_ROOT) / "configs";
  int count = 0;
  for (const auto& entry : fs::directory_iterator(configs / "proof_worlds")) {
    const auto world = load_world(entry.path());
    EXPECT_TRUE(world) << world.error().text();
    ++count;
  }
  EXPECT_GE(count, 2);
  for (const auto& entry : fs::directory_iterator(configs / "sensors")) {
    const auto sensors = load_sensors(entry.path());
    EXPECT_TRUE(sensors) << sensors.error().text();
  }
}

}  // namespace
}  // namespace omniflight::proof

#include <gtest/gtest.h>

#include "omniflight_files/yaml.hpp"

using namespace omniflight;
using namespace omniflight::files;

namespace {

constexpr const char* kVehicle = R"(name: small
mass: 0.037   # kg
rotors:
  - {position: [0.1, 0, 0], spin: +1}
  - position: [-0.1, 0, 0]
    spin: -1
tilt:
  kind: common
flag: true
nothing: null
)";

YamlReader parse(const std::string& text) {
  auto r = YamlReader::parse(text, "vehicle.yaml");
  if (!r) throw std::runtime_error(r.error().text());
  return *r;
}
std::string refusal(const std::string& text) {
  auto r = YamlReader::parse(text, "f.yaml");
  return r ? "accepted" : r.error().text();
}
bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

enum class Kind { common, none };
void read_all(YamlReader& root) {
  EXPECT_EQ(root.string("name"), "small");
  EXPECT_EQ(root.number("mass", positive("kg")), 0.037);
  EXPECT_EQ(root.number("drag", any_number(), 7.0), 7.0);
  auto rotors = root.children("rotors", 1, 8);
  ASSERT_EQ(rotors.size(), 2u);
  EXPECT_EQ(rotors[1].vec3("position", any_number("m")).x(), -0.1);
  EXPECT_EQ(rotors[0].integer("spin", -1, 1), 1);
  EXPECT_EQ(root.child("tilt").choice<Kind>("kind", {{"common", Kind::common}, {"none", Kind::none}}),
            Kind::common);
  EXPECT_TRUE(root.boolean("flag"));
  EXPECT_FALSE(root.has("nothing"));
}

TEST(Yaml, ReadsTypedFields) {
  auto root = parse(kVehicle);
  read_all(root);
  auto rotors = root.children("rotors");
  EXPECT_TRUE(root.status());
  const auto unread = root.finish();  // rotors[0].position and rotors[1].spin were never asked for
  ASSERT_FALSE(unread);
  EXPECT_EQ(unread.error().text(),
            "vehicle.yaml:4: rotors[0].position: is not a known key. Known keys: spin");
}

TEST(Yaml, ErrorsNameFileLineFieldUnitAndTheFirstOneStays) {
  auto root = parse("mass: -1\nrotors:\n  - position: [1, x, 2]\n");
  root.number("mass", positive("kg"));
  root.children("rotors")[0].vec3("position", any_number("m"));
  EXPECT_EQ(root.status().error().text(),
            "vehicle.yaml:1: mass: is -1 kg, must be more than 0 kg. Correct the value");
  auto again = parse("mass: 1\nrotors:\n  - position: [1, x, 2]\n");
  again.children("rotors")[0].vec3("position", any_number("m"));
  EXPECT_EQ(again.status().error().text(),
            "vehicle.yaml:3: rotors[0].position[1]: 'x' is not a finite decimal number. Give a number in m "
            "without the unit");
}

TEST(Yaml, AMisspeltKeyIsRefusedWithTheClosestKnownOne) {
  auto root = parse("mas: 1\n");
  root.number("mass", positive("kg"), 1.0);
  EXPECT_EQ(root.finish().error().text(), "vehicle.yaml:1: mas: is not a known key. Did you mean 'mass'?");
  auto missing = parse("mas: 1\n");
  missing.number("mass", positive("kg"));
  EXPECT_TRUE(contains(missing.status().error().text(), "vehicle.yaml:1: mass: is missing"));
}

TEST(Yaml, NumbersThatYamlReadersDisagreeAboutAreRefused) {
  for (const char* text : {".nan", ".inf", "nan", "inf", "1e400", "1.5m", "1,5", "1e", "~", "yes", "010",
                           "0x10", "\"1\"", "'2'", "++1", "", "1 2", "--1"}) {
    auto root = parse(std::string("a: ") + text + "\n");
    root.number("a", any_number());
    EXPECT_FALSE(root.ok()) << text;
  }
  for (const char* text : {"1", "-1.5", "+2", "1e-8", ".5", "0", "0.5", "-0", "5."}) {
    auto root = parse(std::string("a: ") + text + "\n");
    root.number("a", any_number());
    EXPECT_TRUE(root.ok()) << text;
  }
}

TEST(Yaml, HostileDocumentsAreRefused) {
  EXPECT_TRUE(contains(refusal("a: 1\nb: 2\na: 3\n"), "f.yaml:3: key 'a' appears twice"));
  EXPECT_TRUE(contains(refusal("a: &x 1\nb: *x\n"), "anchors"));
  EXPECT_TRUE(contains(refusal("&x {a: *x}"), "anchors"));
  EXPECT_TRUE(contains(refusal("a: !!python/object:os.system 1\n"), "f.yaml:1: tag"));
  EXPECT_TRUE(contains(refusal("a: 1\n---\nb: 2\n"), "more than one document"));
  EXPECT_TRUE(contains(refusal("a: \xff\n"), "UTF-8"));
  EXPECT_TRUE(contains(refusal(std::string("a: 1\0b", 6)), "UTF-8"));
  EXPECT_TRUE(contains(refusal(""), "is empty"));
  EXPECT_TRUE(contains(refusal("? [1, 2]\n: 3\n"), "key must be plain text"));
  EXPECT_TRUE(contains(refusal("a: [1, 2\n"), "not valid YAML"));
  EXPECT_TRUE(contains(refusal(std::string(100, '[') + std::string(100, ']')), "64 levels"));
  EXPECT_TRUE(contains(refusal(std::string(1000000, '[')), "64 levels"));
  std::string dashes;
  for (int i = 0; i < 100000; ++i) dashes += "- ";
  EXPECT_NE(refusal(dashes), "accepted");
  EXPECT_TRUE(contains(refusal("a: " + std::string(1 << 20, 'x')), "1 MB"));
}

TEST(Yaml, OverridesReplaceAddAndRefuse) {
  auto root = parse(kVehicle);
  ASSERT_TRUE(root.override_value("mass", "0.0397"));
  ASSERT_TRUE(root.override_value("rotors[1].position", "[1, 2, 3]"));
  ASSERT_TRUE(root.override_value("tilt.max_deg", "60"));
  EXPECT_EQ(root.number("mass", positive("kg")), 0.0397);
  EXPECT_EQ(root.children("rotors")[1].vec3("position", any_number("m")).z(), 3.0);
  EXPECT_EQ(root.child("tilt").number("max_deg", positive("deg")), 60.0);
  for (const char* path : {"rotors[2].spin", "a.b", "mass.x", "rotors[x]", "", "rotors[0", "."})
    EXPECT_FALSE(root.override_value(path, "1")) << path;
  EXPECT_FALSE(root.override_value("mass", "[1"));
}

TEST(Yaml, TruncatedAndDamagedDocumentsNeverCrash) {
  const std::string text = kVehicle;
  for (std::size_t i = 0; i < text.size(); ++i) {
    (void)refusal(text.substr(0, i));
    for (const char c : {'[', '\x80', '&', ':'}) {
      std::string damaged = text;
      damaged[i] = c;
      (void)refusal(damaged);
    }
  }
}

}  // namespace

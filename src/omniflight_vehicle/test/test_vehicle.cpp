#include <gtest/gtest.h>

#include <urdf_parser/urdf_parser.h>

#include <cstdlib>
#include <fstream>

#include "../src/urdf.hpp"
#include "omniflight_vehicle/robot_description.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::vehicle {
namespace {

class Vehicles : public ::testing::Test {
 protected:
  void SetUp() override { setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1); }
};

TEST_F(Vehicles, TheirDescriptionIsReadBackWithItsBodyAndItsJoints) {
  for (const std::string& name : vehicle_names()) {
    const auto v = load_vehicle(name);
    ASSERT_TRUE(v) << v.error().text();
    const std::string text = robot_description(*v);
    const auto body = read_urdf(text, name);
    ASSERT_TRUE(body) << body.error().text();
    EXPECT_NEAR(body->mass, v->mass, 1e-8 * v->mass);
    EXPECT_LT((body->inertia - v->inertia).norm(), 1e-7 * v->inertia.norm());
    EXPECT_LT((body->center_of_mass - v->center_of_mass).norm(), 1e-8);
    ASSERT_EQ(body->collision.size(), v->collision.size());
    for (std::size_t i = 0; i < v->collision.size(); ++i) {
      EXPECT_LT((body->collision[i].p_BS - v->collision[i].p_BS).norm(), 1e-7);
      EXPECT_LT(body->collision[i].q_BS.angularDistance(v->collision[i].q_BS), 1e-6);
    }
    const auto model = urdf::parseURDF(text);
    ASSERT_TRUE(model);
    const auto joints = joint_names(*v);
    EXPECT_EQ(model->joints_.size(), joints.size());
    for (const std::string& joint : joints) ASSERT_TRUE(model->getJoint(joint)) << joint;
    for (std::size_t i = 0; i < v->rotors.size(); ++i) {
      const Rotor& rotor = v->rotors[i];
      const std::string number = std::to_string(i + 1);
      const auto turns = model->getJoint("rotor_" + number);
      EXPECT_LT((Vec3(turns->axis.x, turns->axis.y, turns->axis.z) - rotor.axis_B).norm(), 1e-7);
      const auto first = rotor.tilts ? model->getJoint("tilt_" + number) : turns;
      const auto& place = first->parent_to_joint_origin_transform.position;
      EXPECT_LT((Vec3(place.x, place.y, place.z) - rotor.p_BR).norm(), 1e-7);
      EXPECT_EQ(first->parent_link_name, "base_link");
      if (!rotor.tilts) continue;
      EXPECT_LT((Vec3(first->axis.x, first->axis.y, first->axis.z) - rotor.tilt_axis_B).norm(), 1e-7);
      EXPECT_NEAR(first->limits->upper, v->tilt.max, 1e-7);
    }
  }
}

TEST_F(Vehicles, OmniMorphIsTheThesisGeometry) {
  const auto v = load_vehicle("omnimorph");
  ASSERT_TRUE(v) << v.error().text();
  EXPECT_EQ(v->rotor_count(), 8);
  EXPECT_DOUBLE_EQ(v->mass, 1.315);
  for (int i = 0; i < 8; ++i) {
    // thesis 5.2: at 45 deg every thrust axis is orthogonal to the position of its rotor
    EXPECT_NEAR(v->rotor_axis(i, to_radians(45)).dot(v->rotors[static_cast<std::size_t>(i)].p_BR), 0.0,
                1e-12);
    EXPECT_NEAR(v->rotor_axis(i, 0).z(), 1.0, 1e-15);
  }
  // alpha > 0 tilts rotor 1 toward -x and rotor 3 toward +y
  EXPECT_LT(v->rotor_axis(0, 0.1).x(), -0.05);
  EXPECT_GT(v->rotor_axis(2, 0.1).y(), 0.05);
  // the force map is isotropic where the geometry equals the omnicopter
  const AllocationMatrix F = v->allocation_matrix(std::acos(1 / std::sqrt(3.0)));
  const Mat3 S = F.topRows<3>() * F.topRows<3>().transpose();
  EXPECT_LT((S - 8.0 / 3.0 * Mat3::Identity()).norm(), 1e-12);
  for (double alpha = 0; alpha <= to_radians(60); alpha += to_radians(1)) {
    const AllocationMatrix B = v->allocation_matrix(alpha);
    // upright (alpha = 0) there is no lateral force, but roll, pitch and yaw torque at every tilt
    const Mat3 T = B.bottomRows<3>() * B.bottomRows<3>().transpose();
    EXPECT_GT(T.determinant(), 1e-6) << to_degrees(alpha);
    if (alpha > 0.5 * to_radians(1)) {
      EXPECT_EQ((B * B.transpose()).eval().fullPivLu().rank(), 6) << to_degrees(alpha);
    }
  }
}

TEST_F(Vehicles, VariantsAndOverrides) {
  const auto table = load_vehicle("omnimorph@table_4_1");
  ASSERT_TRUE(table) << table.error().text();
  EXPECT_DOUBLE_EQ(table->mass, 1.595);
  const auto heavy = load_vehicle("omnimorph", {"mass=2.0", "rotors.drag_ratio=0.02"});
  ASSERT_TRUE(heavy) << heavy.error().text();
  EXPECT_DOUBLE_EQ(heavy->mass, 2.0);
  EXPECT_DOUBLE_EQ(heavy->rotors[7].drag_ratio, 0.02);
  EXPECT_NE(heavy->sha256, table->sha256);
  const auto wrong = load_vehicle("omnimorf");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().text().find("Did you mean 'omnimorph'"), std::string::npos) << wrong.error().text();
}

TEST_F(Vehicles, TellHowWellTheirNumbersAreKnown) {
  const auto crazyflie = load_vehicle("crazyflie_brushless");
  ASSERT_TRUE(crazyflie) << crazyflie.error().text();
  EXPECT_DOUBLE_EQ(crazyflie->tolerance.at("inertia"), 0.25);
  EXPECT_EQ(crazyflie->tolerance.count("center_of_mass"), 0u);
  const auto told = load_vehicle("crazyflie_brushless", {"tolerance.inertia=0.1"});
  ASSERT_TRUE(told) << told.error().text();
  EXPECT_DOUBLE_EQ(told->tolerance.at("inertia"), 0.1);
  const auto wrong = load_vehicle("crazyflie_brushless", {"tolerance.inertia=25"});
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().text().find("tolerance.inertia"), std::string::npos) << wrong.error().text();
}

TEST_F(Vehicles, TellTheLagAndPlayOfTheirTiltServo) {
  const auto plain = load_vehicle("omnimorph");
  ASSERT_TRUE(plain) << plain.error().text();
  EXPECT_EQ(plain->tilt.time_constant, 0.0);
  EXPECT_EQ(plain->tilt.backlash, 0.0);
  const auto told = load_vehicle("omnimorph", {"tilt.time_constant_s=0.08", "tilt.backlash_deg=0.5"});
  ASSERT_TRUE(told) << told.error().text();
  EXPECT_DOUBLE_EQ(told->tilt.time_constant, 0.08);
  EXPECT_DOUBLE_EQ(told->tilt.backlash, to_radians(0.5));
  EXPECT_NE(told->sha256, plain->sha256);
}

TEST_F(Vehicles, RefuseATiltServoThatNoVehicleHas) {
  const auto refusal = [](const char* vehicle, const char* set) {
    const auto v = load_vehicle(vehicle, {set});
    return v ? std::string("accepted") : v.error().text();
  };
  const auto expect = [](const std::string& text, std::initializer_list<const char*> all) {
    for (const char* words : all) EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  expect(refusal("omnimorph", "tilt.time_constant_s=2.1"),
         {"omnimorph.yaml", "tilt.time_constant_s", "is 2.1 s", "at most 2 s"});
  expect(refusal("omnimorph", "tilt.time_constant_s=-0.1"), {"omnimorph.yaml", "tilt.time_constant_s"});
  expect(refusal("omnimorph", "tilt.backlash_deg=21"),
         {"omnimorph.yaml", "tilt.backlash_deg", "is 21 deg", "at most 20 deg"});
  expect(refusal("quadrotor_1200g", "tilt.time_constant_s=0.1"),
         {"quadrotor_1200g.yaml: tilt.time_constant_s", "is 0.1 s, but no rotor tilts"});
  Vehicle v = load_vehicle("omnimorph").value();
  v.tilt.max = to_radians(3);
  v.tilt.backlash = to_radians(4);
  expect(validate(v).error().text(),
         {"omnimorph.yaml: tilt.backlash_deg", "is 4 deg, must be less than the range of the tilt, 3 deg"});
  v.tilt.backlash = 0;
  v.tilt.time_constant = std::nan("");
  expect(validate(v).error().text(),
         {"tilt.time_constant_s", "is nan s, must be at least 0 and at most 2 s"});
}

TEST_F(Vehicles, ListTheirMassVariants) {
  const auto v = load_vehicle("omnimorph@flown");
  ASSERT_TRUE(v) << v.error().text();
  ASSERT_EQ(v->variants.size(), 3u);
  EXPECT_EQ(v->variants[1].name, "table_4_1");
  EXPECT_DOUBLE_EQ(v->variants[1].mass, 1.595);
  EXPECT_NE(v->variants[1].why.find("Table 4.1"), std::string::npos);
  EXPECT_TRUE(load_vehicle("quadrotor_1200g")->variants.empty());
}

TEST_F(Vehicles, EveryShippedVehicleLoads) {
  for (const auto& name : vehicle_names()) {
    const auto v = load_vehicle(name);
    EXPECT_TRUE(v) << v.error().text();
  }
}

TEST_F(Vehicles, RefusesWhatIsNotPhysical) {
  for (const char* bad :
       {"mass=-1", "mass=.nan", "inertia=[1, 1, 3, 0, 0, 0]", "rotors.max_thrust=0", "mass=1.5m"}) {
    const auto v = load_vehicle("crazyflie_brushless", {bad});
    EXPECT_FALSE(v) << bad;
    if (!v) {
      EXPECT_EQ(v.error().code, ErrorCode::bad_input);
    }
  }
}

TEST_F(Vehicles, SaysWhichMassAndInertiaItRefusesWithUnitAndBound) {
  const auto refusal = [](double mass, const Vec3& inertia) {
    Vehicle v = load_vehicle("crazyflie_brushless").value();
    v.mass = mass;
    v.inertia = inertia.asDiagonal();
    const auto ok = validate(v);
    return ok ? std::string("accepted") : ok.error().text();
  };
  const Vec3 fine(2.5e-5, 2.8e-5, 4.9e-5);
  EXPECT_EQ(refusal(0.04, fine), "accepted");
  const auto expect = [](const std::string& text, const char* words) {
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  expect(refusal(-1, fine), "mass: is -1.000000 kg, must be finite and above 0 kg");
  expect(refusal(std::nan(""), fine), "mass: is nan kg, must be finite and above 0 kg");
  expect(refusal(0.04, {2.5e-5, -1e-5, 3e-5}),
         "inertia: is not positive definite: its smallest principal moment is -1e-05 kg m2, must be above 0");
  expect(refusal(0.04, {2.5e-5, 2e-5, 6e-5}),
         "its largest principal moment is 6e-05 kg m2, at most the sum of the other two, 4.5e-05 kg m2");
}

std::string robot(const std::string& inside) { return "<robot name=\"r\">" + inside + "</robot>"; }
std::string link(const std::string& name, const std::string& mass) {
  return "<link name=\"" + name + "\"><inertial><mass value=\"" + mass +
         "\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>";
}

TEST(Urdf, HostileFilesAreRefusedWithAReason) {
  EXPECT_TRUE(read_urdf(robot(link("a", "1")), "ok.urdf"));
  std::string deep;
  for (int i = 0; i < 50000; ++i) deep += "<a>";
  const std::string joint_cycle =
      robot(link("r", "1") + link("a", "1") + link("b", "1") +
            "<joint name=\"j\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>"
            "<joint name=\"k\" type=\"fixed\"><parent link=\"b\"/><child link=\"a\"/></joint>");
  for (const std::string& text :
       {deep, robot(link("a", "-5")), robot(link("a", "nan")), robot(link("a", "1kg")),
        robot("<link name=\"a\"/>"), joint_cycle, robot(link("a", "1")).substr(0, 60),
        std::string("<!DOCTYPE x>") + robot(link("a", "1"))}) {
    const auto body = read_urdf(text, "bad.urdf");
    ASSERT_FALSE(body) << text.substr(0, 200);
    EXPECT_NE(body.error().text().find("bad.urdf"), std::string::npos);
  }
}

TEST(Urdf, NothingHidesElementsFromTheDepthScan) {
  // Attributes, declarations and stray tags must not make the scan see fewer open elements than the recursive
  // parser does, whose stack then overflows.
  const auto repeated = [](const std::string& piece, const std::string& before = {}) {
    std::string text = before;
    for (int i = 0; i < 100000; ++i) text += piece;
    return text;
  };
  for (const std::string& text :
       {repeated("<a x=\"/>\">"), repeated("<a x='/>'>"), repeated("<a></b x=\"<a>\">"),
        repeated("<a>", "<1 \">") + "\">", repeated("<a><?xml version=\"?>\" </a>"),
        repeated("</a>") + repeated("<a>"), repeated("<a>", "<?xml version=\"1.0\"?>"),
        repeated("<a", "<?xml version=\"?>\" "), repeated("<a><![CDATA[</a>]]>"), std::string("<")}) {
    const auto body = read_urdf(text, "hidden.urdf");
    ASSERT_FALSE(body) << text.substr(0, 60);
    EXPECT_NE(body.error().text().find("hidden.urdf"), std::string::npos);
  }
  const auto quoted =
      read_urdf("<?xml version=\"1.0\"?><!-- <a> -->\n" +
                    robot("<link name=\"a > b\"><inertial><mass value='1'/><inertia ixx=\"1\" "
                          "ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>"),
                "quoted.urdf");
  EXPECT_TRUE(quoted) << quoted.error().text();
}

}  // namespace
}  // namespace omniflight::vehicle

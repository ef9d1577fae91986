#include "omniflight_vehicle/robot_description.hpp"

#include <cstdio>

namespace omniflight::vehicle {
namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string numbers(std::initializer_list<double> values) {
  std::string out;
  char text[32];
  for (const double value : values) {
    std::snprintf(text, sizeof text, "%s%.9g", out.empty() ? "" : " ", value);
    out += text;
  }
  return out;
}
std::string numbers(const Vec3& v) { return numbers({v.x(), v.y(), v.z()}); }

std::string origin(const Vec3& p, const Quat& q = Quat::Identity()) {
  return "<origin xyz=\"" + numbers(p) + "\" rpy=\"" + numbers(roll_pitch_yaw(q)) + "\"/>";
}

std::string cylinder(double radius, double length) {
  return "<geometry><cylinder radius=\"" + numbers({radius}) + "\" length=\"" + numbers({length}) +
         "\"/></geometry>";
}

std::string geometry(const CollisionShape& shape) {
  switch (shape.kind) {
    case CollisionShape::Kind::sphere:
      return "<geometry><sphere radius=\"" + numbers({shape.size.x()}) + "\"/></geometry>";
    case CollisionShape::Kind::cylinder:
      return cylinder(shape.size.x(), shape.size.y());
    case CollisionShape::Kind::box:
      return "<geometry><box size=\"" + numbers(shape.size) + "\"/></geometry>";
  }
  return {};
}

std::string joint(const std::string& name, const char* type, const std::string& parent, const Vec3& place,
                  const Vec3& axis, const std::string& rest = {}) {
  return "  <joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + name + "_link\"/>" + origin(place) + "<axis xyz=\"" + numbers(axis) + "\"/>" +
         rest + "</joint>\n";
}

std::string base_link(const Vehicle& v) {
  const Mat3& J = v.inertia;
  std::string out = "  <link name=\"base_link\"><inertial>" + origin(v.center_of_mass) + "<mass value=\"" +
                    numbers({v.mass}) + "\"/><inertia ixx=\"" + numbers({J(0, 0)}) + "\" iyy=\"" +
                    numbers({J(1, 1)}) + "\" izz=\"" + numbers({J(2, 2)}) + "\" ixy=\"" + numbers({J(0, 1)}) +
                    "\" ixz=\"" + numbers({J(0, 2)}) + "\" iyz=\"" + numbers({J(1, 2)}) + "\"/></inertial>";
  for (const char* kind : {"visual", "collision"})
    for (const CollisionShape& shape : v.collision)
      out += "<" + std::string(kind) + ">" + origin(shape.p_BS, shape.q_BS) + geometry(shape) + "</" + kind +
             ">";
  return out + "</link>\n";
}

}  // namespace

std::vector<std::string> joint_names(const Vehicle& v) {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < v.rotors.size(); ++i) out.push_back("rotor_" + std::to_string(i + 1));
  for (std::size_t i = 0; i < v.rotors.size(); ++i)
    if (v.rotors[i].tilts) out.push_back("tilt_" + std::to_string(i + 1));
  return out;
}

std::string robot_description(const Vehicle& v) {
  constexpr double kDiscShare = 0.05;    // of the radius: as thick as a disc is drawn
  constexpr double kSmallRadius = 0.05;  // m, of rotors whose radius the file does not tell
  std::string out = "<?xml version=\"1.0\"?>\n<robot name=\"" + escaped(v.name) + "\">\n" + base_link(v);
  for (std::size_t i = 0; i < v.rotors.size(); ++i) {
    const Rotor& rotor = v.rotors[i];
    const std::string number = std::to_string(i + 1);
    std::string parent = "base_link";
    Vec3 place = rotor.p_BR;
    if (rotor.tilts) {
      const std::string tilt = "tilt_" + number;
      const double rate = v.tilt.rate > 0.0 ? v.tilt.rate : 100.0;
      out += joint(tilt, "revolute", parent, place, rotor.tilt_axis_B,
                   "<limit lower=\"" + numbers({v.tilt.min}) + "\" upper=\"" + numbers({v.tilt.max}) +
                       "\" velocity=\"" + numbers({rate}) + "\" effort=\"0\"/>");
      out += "  <link name=\"" + tilt + "_link\"/>\n";
      parent = tilt + "_link";
      place = Vec3::Zero();
    }
    out += joint("rotor_" + number, "continuous", parent, place, rotor.axis_B);
    const double radius = rotor.radius > 0.0 ? rotor.radius : kSmallRadius;
    out += "  <link name=\"rotor_" + number + "_link\"><visual>" +
           origin(Vec3::Zero(), Quat::FromTwoVectors(Vec3::UnitZ(), rotor.axis_B)) +
           cylinder(radius, kDiscShare * radius) + "</visual></link>\n";
  }
  return out + "</robot>\n";
}

}  // namespace omniflight::vehicle

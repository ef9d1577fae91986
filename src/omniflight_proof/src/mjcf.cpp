#include "mjcf.hpp"

#include <sstream>

#include "chain.hpp"

namespace omniflight::proof {
namespace {

std::string numbers(const Vec3& v) {
  std::ostringstream out;
  out.precision(17);
  out << v.x() << ' ' << v.y() << ' ' << v.z();
  return out.str();
}

/// Inertia of a point mass about the origin.
Mat3 steiner(double mass, const Vec3& p) {
  return mass * (p.squaredNorm() * Mat3::Identity() - p * p.transpose());
}

constexpr double kPodRadius = 0.02;  // m, of the ball a pod's mass is

struct Core {
  double mass = 0;
  Vec3 com = Vec3::Zero();
  Mat3 inertia = Mat3::Zero();
};

/// What remains of the vehicle without the parts that move on their own.
Result<Core> core(const vehicle::Vehicle& v, const World& w) {
  const Vec3 com = v.center_of_mass + w.body.com_shift_B;
  const Mat3 scale = w.body.inertia_scale.cwiseSqrt().asDiagonal();
  const Mat3 turn = exp_rotation(w.body.inertia_turn_B).toRotationMatrix();
  const Mat3 own = turn * (scale * v.inertia * scale) * turn.transpose();
  Core out{v.mass, v.mass * com, own + steiner(v.mass, com)};
  const auto take = [&](double mass, const Vec3& p, double moment) {
    out.mass -= mass;
    out.com -= mass * p;
    out.inertia -= steiner(mass, p) + moment * Mat3::Identity();
  };
  if (w.flexible_arms)
    for (const auto& rotor : v.rotors)
      take(w.flexible_arms->pod_mass, rotor.p_BR, 0.4 * w.flexible_arms->pod_mass * kPodRadius * kPodRadius);
  if (w.body.sloshing_mass > 0) take(w.body.sloshing_mass, com, 0);
  if (!(out.mass > 0.05 * v.mass))
    return bad_input(
        "leave " + std::to_string(out.mass) + " kg of " + std::to_string(v.mass) + " kg for the core",
        "flexible_arms.pod_mass_kg, body.sloshing_mass_kg", "Take lighter ones");
  out.com /= out.mass;
  out.inertia -= steiner(out.mass, out.com);
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(out.inertia);
  const Vec3 e = solver.eigenvalues();
  if (!(e[0] > 0) || e[0] + e[1] < e[2] * (1 - 1e-9))
    return bad_input("leaves moments of inertia of " + numbers(e) + " kg m2, which no body has",
                     "body.inertia_scale, flexible_arms.pod_mass_kg", "They must be positive and a triangle");
  return out;
}

void chain(std::ostream& xml, const std::string& name, int links, double length, double density,
           const Vec3& attachment, double damping, double stiffness, double contact_radius) {
  const double l = length / links, mass = density * l;
  const double across = mass * l * l / 12, along = std::max(1e-9, 0.02 * across);
  for (int i = 1; i <= links; ++i) {
    xml << "<body name='" << name << '_' << i << "' pos='" << numbers(i == 1 ? attachment : Vec3(0, 0, -l))
        << "'>"
        << "<joint type='ball' damping='" << damping << "' stiffness='" << stiffness / l << "'/>"
        << "<inertial pos='" << numbers(Vec3(0, 0, -l / 2)) << "' mass='" << mass << "' diaginertia='"
        << numbers(Vec3(across, across, along)) << "'/>";
    if (contact_radius > 0)
      xml << "<geom class='touching' pos='" << numbers(Vec3(0, 0, -l)) << "' size='" << contact_radius
          << "'/>";
  }
  for (int i = 0; i < links; ++i) xml << "</body>";
}

/// A rope of a hundredth of the ball's mass, and the ball at its end.
void rope_with_ball(std::ostream& xml, const SlungBall& b) {
  const double l = b.length / b.links, mass = 0.01 * b.mass / b.links, across = mass * l * l / 12;
  for (int i = 1; i <= b.links; ++i)
    xml << "<body name='ball" << (i == 1 ? "" : "_" + std::to_string(i)) << "' pos='"
        << numbers(i == 1 ? b.attachment_B : Vec3(0, 0, -l)) << "'><joint type='ball' damping='"
        << b.damping / b.links << "'/><inertial pos='" << numbers(Vec3(0, 0, -l / 2)) << "' mass='" << mass
        << "' diaginertia='" << numbers(Vec3(across, across, std::max(1e-9, 0.02 * across))) << "'/>";
  xml << "<body name='ball_end' pos='" << numbers(Vec3(0, 0, -l)) << "'><inertial pos='0 0 0' mass='"
      << b.mass << "' diaginertia='" << numbers(Vec3::Constant(0.4 * b.mass * b.radius * b.radius))
      << "'/><geom class='touching' size='" << b.radius << "'/></body>";
  for (int i = 0; i < b.links; ++i) xml << "</body>";
}

}  // namespace

Result<std::string> write_mjcf(const vehicle::Vehicle& v, const World& w, const RigidState& start) {
  auto hull = core(v, w);
  if (!hull) return Failure(hull.error());
  std::ostringstream xml;
  xml.precision(17);
  xml << "<mujoco model='vehicle'><compiler angle='radian' inertiafromgeom='false'/>"
      << "<option timestep='" << w.timestep << "' gravity='0 0 " << -kGravity << "' integrator='"
      << (w.integrator == Integrator::implicit ? "implicit" : "Euler")
      << "' cone='elliptic' solver='Newton' iterations='20' tolerance='1e-8' jacobian='dense'/>"
      << "<size njmax='1200' nconmax='200'/>"
      << "<default><default class='touching'><geom type='sphere' contype='0' conaffinity='1' condim='3' "
         "friction='"
      << (w.cable ? w.cable->floor_friction : 0.5) << " 0.005 0.0001' solref='0.01 1'/></default></default>"
      << "<worldbody><geom type='plane' pos='0 0 " << w.floor_z
      << "' size='0 0 1' contype='1' conaffinity='0' friction='0 0 0'/>";
  const Quat q = start.q_WB.normalized();
  const Mat3& J = hull->inertia;
  xml << "<body name='vehicle' pos='" << numbers(start.p_WB) << "' quat='" << q.w() << ' ' << numbers(q.vec())
      << "'><freejoint/><inertial pos='" << numbers(hull->com) << "' mass='" << hull->mass
      << "' fullinertia='" << numbers(J.diagonal()) << ' ' << J(0, 1) << ' ' << J(0, 2) << ' ' << J(1, 2)
      << "'/>";
  if (const BodyChange& b = w.body; b.payload > 0)
    xml << "<body name='payload' pos='" << numbers(b.payload_p_B) << "'><inertial pos='0 0 0' mass='"
        << b.payload << "' diaginertia='"
        << numbers(Vec3::Constant(0.4 * b.payload * b.payload_radius * b.payload_radius)) << "'/></body>";
  if (const BodyChange& b = w.body; b.sloshing_mass > 0) {
    const double rate = 2 * kPi * b.sloshing_frequency;
    xml << "<body name='slosh' pos='" << numbers(v.center_of_mass + b.com_shift_B) << "'>";
    for (const char* axis : {"1 0 0", "0 1 0", "0 0 1"})
      xml << "<joint type='slide' axis='" << axis << "' stiffness='" << b.sloshing_mass * rate * rate
          << "' damping='" << 2 * b.sloshing_damping_ratio * rate * b.sloshing_mass << "'/>";
    xml << "<inertial pos='0 0 0' mass='" << b.sloshing_mass << "' diaginertia='1e-7 1e-7 1e-7'/></body>";
  }
  if (w.flexible_arms) {
    const FlexibleArms& a = *w.flexible_arms;
    for (std::size_t i = 0; i < v.rotors.size(); ++i) {
      const Vec3 hinge = pod_hinge(v, a, i), arm = v.rotors[i].p_BR - hinge;
      const double own = 0.4 * a.pod_mass * kPodRadius * kPodRadius;
      const double moment = a.pod_mass * arm.squaredNorm() + own, rate = 2 * kPi * a.frequency;
      if (arm.norm() < 1e-3)
        return bad_input("puts the hinge of rotor " + std::to_string(i + 1) + " on its hub",
                         "flexible_arms.root");
      xml << "<body name='pod_" << i + 1 << "' pos='" << numbers(hinge) << "'><joint type='ball' stiffness='"
          << moment * rate * rate << "' damping='" << 2 * a.damping_ratio * rate * moment
          << "'/><inertial pos='" << numbers(arm) << "' mass='" << a.pod_mass << "' diaginertia='"
          << numbers(Vec3::Constant(own)) << "'/></body>";
    }
  }
  if (w.cable)
    chain(xml, "cable", w.cable->links, w.cable->length, w.cable->linear_density, w.cable->attachment_B,
          w.cable->damping, w.cable->bending_stiffness, 0.5 * w.cable->diameter);
  if (w.overhead_rope)
    chain(xml, "rope", even_links(*w.overhead_rope), w.overhead_rope->length, w.overhead_rope->linear_density,
          w.overhead_rope->attachment_B, w.overhead_rope->damping, 0, 0);
  if (w.slung_ball) {
    const SlungBall& b = *w.slung_ball;
    if (b.links > 1) {
      rope_with_ball(xml, b);
    } else {
      xml << "<body name='ball' pos='" << numbers(b.attachment_B) << "'><joint type='ball' damping='"
          << b.damping << "'/><inertial pos='0 0 " << -b.length << "' mass='" << b.mass << "' diaginertia='"
          << numbers(Vec3::Constant(0.4 * b.mass * b.radius * b.radius))
          << "'/><geom class='touching' pos='0 0 " << -b.length << "' size='" << b.radius << "'/></body>";
    }
  }
  xml << "</body></worldbody>";
  if (w.overhead_rope)
    xml << "<equality><connect body1='rope_" << even_links(*w.overhead_rope) << "' anchor='0 0 "
        << -w.overhead_rope->length / even_links(*w.overhead_rope) << "' solref='0.01 1'/></equality>";
  xml << "</mujoco>";
  return xml.str();
}

}  // namespace omniflight::proof

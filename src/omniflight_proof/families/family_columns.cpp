#include "family_columns.hpp"

#include <cmath>
#include <map>

namespace omniflight::proof {
namespace {

using Eigen::MatrixXd;
using Wrench = Vec6;

Wrench at(const Vec3& force, const Vec3& point) {
  Wrench w;
  w << force, point.cross(force);
  return w;
}
Wrench torque(const Vec3& t) {
  Wrench w;
  w << Vec3::Zero(), t;
  return w;
}

class Builder {
 public:
  Builder(const FamilyVehicle& f, const FlightSeries& s)
      : v(f.nominal), s_(s), n_(static_cast<int>(s.state.size())) {}

  template <class Of>
  MatrixXd column(Of of) const {
    MatrixXd c(n_, 6);
    for (int i = 0; i < n_; ++i) c.row(i) = Wrench(of(i)).transpose();
    return c;
  }
  template <class Of>
  void add(std::vector<ColumnGroup>& out, const char* id, int count, Of of) const {
    ColumnGroup g{id, {}};
    for (int k = 0; k < count; ++k) g.columns.push_back(column([&](int i) { return of(i, k); }));
    out.push_back(std::move(g));
  }
  const RigidState& state(int i) const { return s_.state[static_cast<std::size_t>(i)]; }
  Mat3 R(int i) const { return state(i).q_WB.toRotationMatrix(); }
  Vec3 force(int i) const { return s_.specific_force[static_cast<std::size_t>(i)]; }
  Vec3 turning(int i) const { return s_.angular_acceleration[static_cast<std::size_t>(i)]; }
  Vec3 rate(int i) const { return state(i).w_WB_B; }
  Vec3 velocity_B(int i) const { return R(i).transpose() * state(i).v_WB_W; }
  Vec3 up_B(int i) const { return R(i).transpose() * Vec3::UnitZ(); }
  double speed(int i, int k) const { return s_.speed[static_cast<std::size_t>(i)][k]; }
  Vec3 axis(int i, int k) const { return v.rotor_axis(k, s_.alpha[static_cast<std::size_t>(i)]); }
  const vehicle::Rotor& rotor(int k) const { return v.rotors[static_cast<std::size_t>(k)]; }
  Wrench thrust(int i, int k, double share = 1) const {
    const Vec3 T = share * rotor(k).thrust(speed(i, k)) * axis(i, k);
    Wrench w = at(T, rotor(k).p_BR);
    w.tail<3>() += rotor(k).spin * rotor(k).drag_ratio * T;
    return w;
  }
  template <class Of>
  Wrench all_rotors(Of of) const {
    Wrench sum = Wrench::Zero();
    for (int k = 0; k < v.rotor_count(); ++k) sum += of(k);
    return sum;
  }
  Vec3 hub_velocity(int i, int k) const { return velocity_B(i) + rate(i).cross(rotor(k).p_BR); }
  int n() const { return n_; }

  const vehicle::Vehicle& v;

 private:
  const FlightSeries& s_;
  int n_;
};

void body(const Builder& b, std::vector<ColumnGroup>& out) {
  const double mass = b.v.mass;
  const Mat3& J = b.v.inertia;
  b.add(out, "payload_mass", 1, [&](int i, int) { return at(-b.force(i), Vec3::Zero()); });
  b.add(out, "com_offset", 3, [&](int i, int k) {
    const Vec3 c = Vec3::Unit(k), w = b.rate(i);
    Wrench x = at(-mass * (b.turning(i).cross(c) + w.cross(w.cross(c))), Vec3::Zero());
    x.tail<3>() = -mass * c.cross(b.force(i));
    return x;
  });
  b.add(out, "inertia_error", 3, [&](int i, int k) {
    Mat3 one = Mat3::Zero();
    one(k, k) = J(k, k);
    return torque(-(one * b.turning(i) + b.rate(i).cross(one * b.rate(i))));
  });
  b.add(out, "rotor_thrust_scale", b.v.rotor_count(), [&](int i, int k) { return b.thrust(i, k); });
  b.add(out, "thrust_curve", 1, [&](int i, int) {
    return b.all_rotors([&](int k) {
      const double half = 0.5 * b.rotor(k).max_speed();
      return b.thrust(i, k, half / std::max(1.0, std::abs(b.speed(i, k))) - 1);
    });
  });
  b.add(out, "drag_torque_scale", 1, [&](int i, int) {
    return b.all_rotors([&](int k) {
      return torque(b.rotor(k).spin * b.rotor(k).drag_ratio * Vec3(b.thrust(i, k).head<3>()));
    });
  });
  b.add(out, "rotor_inertia", 1, [&](int i, int) {
    return b.all_rotors([&](int k) {
      const int j = std::min(i + 1, b.n() - 1), h = std::max(i - 1, 0);
      const double change = (b.speed(j, k) - b.speed(h, k)) * kSeriesRate / std::max(1, j - h);
      const Vec3 n = b.axis(i, k);
      return torque(b.rotor(k).spin * (change * n + b.speed(i, k) * b.rate(i).cross(n)));
    });
  });
  if (b.v.tilt.kind == vehicle::TiltKind::none) return;
  b.add(out, "tilt_offset", 1, [&](int i, int) {
    return b.all_rotors([&](int k) {
      const Vec3 turned = b.rotor(k).tilt_axis_B.cross(Vec3(b.thrust(i, k).head<3>()));
      return at(turned, b.rotor(k).p_BR);
    });
  });
}

void air(const Builder& b, std::vector<ColumnGroup>& out) {
  b.add(out, "rotor_drag", 1, [&](int i, int) {
    return b.all_rotors([&](int k) {
      const Vec3 v = b.hub_velocity(i, k), n = b.axis(i, k);
      return at(-std::abs(b.speed(i, k)) * (v - v.dot(n) * n), b.rotor(k).p_BR);
    });
  });
  b.add(out, "blade_flapping", 1, [&](int i, int) {
    return b.all_rotors(
        [&](int k) { return torque(std::abs(b.speed(i, k)) * b.hub_velocity(i, k).cross(b.axis(i, k))); });
  });
  b.add(out, "axial_inflow", 1, [&](int i, int) {
    return b.all_rotors([&](int k) {
      const Vec3 n = b.axis(i, k);
      return at(-std::abs(b.speed(i, k)) * b.hub_velocity(i, k).dot(n) * n, b.rotor(k).p_BR);
    });
  });
  b.add(out, "parasitic_drag", 1, [&](int i, int) {
    const Vec3 v = b.velocity_B(i);
    return at(-v.norm() * v, Vec3::Zero());
  });
  b.add(out, "ground_effect", 1, [&](int i, int) {
    return b.all_rotors([&](int k) {
      const double h = std::max(0.5 * b.rotor(k).radius, b.state(i).p_WB.z()),
                   ratio = b.rotor(k).radius / (4 * h);
      return b.thrust(i, k, ratio * ratio);
    });
  });
}

void tethers(const Builder& b, std::vector<ColumnGroup>& out) {
  b.add(out, "constant_pull", 3,
        [&](int i, int k) { return at(b.R(i).transpose() * Vec3::Unit(k), Vec3::Zero()); });
  b.add(out, "hung_cable", 1, [&](int i, int) { return at(-b.state(i).p_WB.z() * b.up_B(i), Vec3::Zero()); });
  // about where the flight begins and the first heading: free anchors would make every constant a spring
  const Vec3 anchor = b.state(0).p_WB;
  const double heading = roll_pitch_yaw(b.state(0).q_WB).z();
  b.add(out, "lateral_stiffness", 1, [&](int i, int) {
    const Vec3 off = anchor - b.state(i).p_WB;
    return at(b.R(i).transpose() * Vec3(off.x(), off.y(), 0), Vec3::Zero());
  });
  b.add(out, "cable_torsion", 1, [&](int i, int) {
    return torque(std::remainder(heading - roll_pitch_yaw(b.state(i).q_WB).z(), 2 * kPi) * b.up_B(i));
  });
  b.add(out, "guide_friction", 2, [&](int i, int k) {
    const Vec3 v = b.state(i).v_WB_W;
    const Vec3 part = k == 0 ? Vec3(0, 0, v.z()) : Vec3(v.x(), v.y(), 0);
    return at(b.R(i).transpose() * Vec3(-part / std::max(0.03, part.norm())), Vec3::Zero());
  });
  // a load on a rope, linear about the vertical: x'' + 2 zeta w x' + w^2 x = -a, force m w^2 x, and its
  // weight
  for (const double length : {0.2, 0.45, 1.0}) {
    const double w2 = kGravity / length, damping = 2 * 0.05 * std::sqrt(w2), h = 1 / kSeriesRate;
    std::vector<Vec3> force(static_cast<std::size_t>(b.n()));
    Vec3 x = Vec3::Zero(), v = Vec3::Zero();
    for (int i = 0; i < b.n(); ++i) {
      const Vec3 a = b.R(i) * b.force(i) - kGravity * Vec3::UnitZ();
      v += h * (-damping * v - w2 * x - Vec3(a.x(), a.y(), 0));
      x += h * v;
      force[static_cast<std::size_t>(i)] = w2 * x - Vec3(0, 0, kGravity + a.z());
    }
    b.add(out, "slung_load", 1, [&](int i, int) {
      return at(b.R(i).transpose() * force[static_cast<std::size_t>(i)], Vec3::Zero());
    });
  }
}

}  // namespace

std::vector<ColumnGroup> textbook_columns(const FamilyVehicle& vehicle, const FlightSeries& series) {
  const Builder b(vehicle, series);
  std::vector<ColumnGroup> out;
  body(b, out);
  air(b, out);
  tethers(b, out);
  return out;
}

std::vector<MatrixXd> calibration_columns(const FamilyVehicle& vehicle, const FlightSeries& series,
                                          double thrust_scale, double level, double trim,
                                          double accelerometer) {
  const Builder b(vehicle, series);
  const double weight = vehicle.weight();
  std::vector<MatrixXd> out;
  out.push_back(b.column(
      [&](int i) { return Wrench(thrust_scale * b.all_rotors([&](int k) { return b.thrust(i, k); })); }));
  for (int k = 0; k < 2; ++k)
    out.push_back(b.column(
        [&](int i) { return at(b.R(i).transpose() * (weight * level * Vec3::Unit(k)), Vec3::Zero()); }));
  for (int k = 0; k < 3; ++k) {
    out.push_back(b.column([&](int i) {
      return torque(-b.v.mass * trim * vehicle.arm() * Vec3(Vec3::Unit(k)).cross(b.force(i)));
    }));
    out.push_back(b.column([&](int) { return at(b.v.mass * accelerometer * Vec3::Unit(k), Vec3::Zero()); }));
  }
  return out;
}

std::vector<MatrixXd> untold_columns(const FamilyVehicle& vehicle, const FlightSeries& series) {
  const Builder b(vehicle, series);
  std::vector<ColumnGroup> groups;
  body(b, groups);
  const std::map<std::string, double> deviation{{"com_offset", 0.02 * vehicle.arm()},
                                                {"inertia_error", 0.08},
                                                {"rotor_thrust_scale", 0.02},
                                                {"drag_torque_scale", 0.1}};
  std::vector<MatrixXd> out;
  for (const ColumnGroup& g : groups)
    if (const auto at = deviation.find(g.id); at != deviation.end())
      for (const MatrixXd& c : g.columns) out.push_back(at->second * c);
  return out;
}

}  // namespace omniflight::proof

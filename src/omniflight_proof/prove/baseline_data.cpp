#include "baseline_data.hpp"

#include <fmt/format.h>

#include <cmath>

namespace omniflight::proof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRate = 40, kFine = 200, kCutoff = 10;  // Hz

/// Gaussian of the cutoff's width, zero phase, on the fine grid.
MatrixXd smooth(const MatrixXd& x) {
  const double sigma = kFine / (2 * kPi * kCutoff) * 1.18;  // -3 dB at the cutoff
  const int half = static_cast<int>(std::ceil(4 * sigma));
  VectorXd kernel(2 * half + 1);
  for (int k = -half; k <= half; ++k) kernel[k + half] = std::exp(-0.5 * k * k / (sigma * sigma));
  kernel /= kernel.sum();
  MatrixXd out(x.rows(), x.cols());
  const auto n = static_cast<int>(x.rows());
  for (int i = 0; i < n; ++i) {
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(x.cols());
    for (int k = -half; k <= half; ++k) sum += kernel[k + half] * x.row(std::clamp(i + k, 0, n - 1));
    out.row(i) = sum;
  }
  return out;
}

MatrixXd derivative(const MatrixXd& x) {
  MatrixXd out = MatrixXd::Zero(x.rows(), x.cols());
  for (Eigen::Index i = 1; i + 1 < x.rows(); ++i) out.row(i) = (x.row(i + 1) - x.row(i - 1)) * (kFine / 2);
  return out;
}

/// Gaps are bridged; the grid lies inside the signal.
Result<MatrixXd> on_grid(const recording::Recording& r, const char* name, const std::vector<double>& t) {
  auto s = r.require(name);
  if (!s) return Failure(s.error());
  MatrixXd x = recording::resample(**s, t);
  for (Eigen::Index c = 0; c < x.cols(); ++c) {
    double last = 0;
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      if (std::isfinite(x(i, c)))
        last = x(i, c);
      else
        x(i, c) = last;
    }
  }
  return x;
}

struct Wrench6 {
  Vec3 F = Vec3::Zero(), M = Vec3::Zero();
};

class Builder {
 public:
  Builder(BaselineData& out, int n) : out_(out), n_(n) {}
  /// Adds a group; of(i, k) is the wrench at sample i for a unit of parameter k.
  template <class Of>
  void term(const char* id, const char* stage, std::vector<std::string> parameters, Of of) {
    Term t{id, stage, std::move(parameters), static_cast<int>(out_.columns.size())};
    for (int k = 0; k < t.columns(); ++k) {
      MatrixXd c(n_, 6);
      for (int i = 0; i < n_; ++i) {
        const Wrench6 w = of(i, k);
        c.row(i) << w.F.transpose(), w.M.transpose();
      }
      out_.columns.push_back(std::move(c));
    }
    out_.terms.push_back(std::move(t));
  }

 private:
  BaselineData& out_;
  int n_;
};

}  // namespace

Result<BaselineData> prepare_baseline(const recording::Recording& r, const vehicle::Vehicle& v,
                                      bool use_commands) {
  double from = 0, to = 1e300;
  for (const char* name : {"attitude", "position", "acc", "gyro", "rotor_command", "ref_position",
                           "ref_acceleration", "ref_angular_velocity", "ref_angular_acceleration"}) {
    auto s = r.require(name);
    if (!s) return Failure(s.error());
    from = std::max(from, (*s)->t_s.front());
    to = std::min(to, (*s)->t_s.back());
  }
  from += 0.5;
  to -= 0.5;
  if (to - from < 5) return bad_input("is shorter than 6 s", r.file);
  std::vector<double> t;
  for (double x = from; x <= to; x += 1 / kFine) t.push_back(x);
  auto q = on_grid(r, "attitude", t), p = on_grid(r, "position", t), f = on_grid(r, "acc", t),
       w = on_grid(r, "gyro", t), command = on_grid(r, "rotor_command", t),
       ref = on_grid(r, "ref_position", t), ref_a = on_grid(r, "ref_acceleration", t),
       ref_w = on_grid(r, "ref_angular_velocity", t), ref_dw = on_grid(r, "ref_angular_acceleration", t);
  for (const auto* x : {&q, &p, &f, &w, &command, &ref, &ref_a, &ref_w, &ref_dw})
    if (!*x) return Failure(x->error());
  MatrixXd speed;
  if (use_commands) {
    speed = *command;
    for (Eigen::Index i = 1; i < speed.rows(); ++i)
      for (Eigen::Index k = 0; k < speed.cols(); ++k) {
        const double tau = v.rotors[static_cast<std::size_t>(k)].time_constant;
        speed(i, k) = (*command)(i, k) +
                      (speed(i - 1, k) - (*command)(i, k)) * std::exp(-1 / (kFine * std::max(1e-6, tau)));
      }
  } else {
    auto s = on_grid(r, "rotor_speed", t);
    if (!s) return Failure(s.error());
    speed = std::move(*s);
  }
  if (speed.cols() != v.rotor_count())
    return bad_input("has another number of rotors than the vehicle", r.file);
  MatrixXd alpha = MatrixXd::Zero(static_cast<Eigen::Index>(t.size()), 1);
  if (const auto* s = r.find("alpha"))
    alpha = recording::resample(*s, t).unaryExpr([](double x) { return std::isfinite(x) ? x : 0.0; });

  const MatrixXd fs = smooth(*f), ws = smooth(*w), dws = smooth(derivative(*w)),
                 vs = smooth(derivative(smooth(*p)));
  const MatrixXd domega = smooth(derivative(speed));
  // thrusts are squared before they are smoothed, as the vehicle does it
  const auto rotors = static_cast<int>(speed.cols());
  MatrixXd thrust(speed.rows(), rotors);
  for (Eigen::Index i = 0; i < speed.rows(); ++i)
    for (int k = 0; k < rotors; ++k) thrust(i, k) = v.rotors[static_cast<std::size_t>(k)].thrust(speed(i, k));
  thrust = smooth(thrust);

  const int every = static_cast<int>(kFine / kRate);
  BaselineData out;
  out.n = static_cast<int>(t.size()) / every;
  out.period = 1 / kRate;
  const auto at = [every](int i) { return static_cast<Eigen::Index>(i) * every; };
  std::vector<Mat3> R(static_cast<std::size_t>(out.n));
  std::vector<std::vector<Vec3>> axis(static_cast<std::size_t>(out.n));
  out.residual.resize(out.n, 6);
  for (int i = 0; i < out.n; ++i) {
    const auto s = static_cast<std::size_t>(i);
    const Eigen::Index g = at(i);
    R[s] = Quat((*q)(g, 0), (*q)(g, 1), (*q)(g, 2), (*q)(g, 3)).normalized().toRotationMatrix();
    Vec3 F = v.mass * fs.row(g).transpose();
    const Vec3 wi = ws.row(g).transpose(), dw = dws.row(g).transpose();
    Vec3 M = v.inertia * dw + wi.cross(v.inertia * wi);
    for (int k = 0; k < rotors; ++k) {
      const auto& rotor = v.rotors[static_cast<std::size_t>(k)];
      axis[s].push_back(v.rotor_axis(k, alpha(g, 0)));
      const Vec3 T = thrust(g, k) * axis[s].back();
      F -= T;
      M -= rotor.p_BR.cross(T) + rotor.spin * rotor.drag_ratio * T;
    }
    out.residual.row(i) << F.transpose(), M.transpose();
  }
  // Accelerations of the regressors come from the reference: measured ones stand on the left side, too, and a
  // mass of minus the vehicle's would "explain" everything.
  const auto force = [&](int i) {
    return Vec3(R[static_cast<std::size_t>(i)].transpose() *
                (ref_a->row(at(i)).transpose() + kGravity * Vec3::UnitZ()));
  };
  const auto rate = [&](int i) { return Vec3(ref_w->row(at(i)).transpose()); };
  const auto angular = [&](int i) { return Vec3(ref_dw->row(at(i)).transpose()); };
  const auto velocity_B = [&](int i) {
    return Vec3(R[static_cast<std::size_t>(i)].transpose() * vs.row(at(i)).transpose());
  };
  const auto rotor_wrench = [&](int i, int k) {
    const auto& rotor = v.rotors[static_cast<std::size_t>(k)];
    const Vec3 T = thrust(at(i), k) * axis[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
    return Wrench6{T, rotor.p_BR.cross(T) + rotor.spin * rotor.drag_ratio * T};
  };
  const auto over_rotors = [&](auto of) {
    Wrench6 sum;
    for (int k = 0; k < rotors; ++k) {
      const Wrench6 one = of(k);
      sum.F += one.F;
      sum.M += one.M;
    }
    return sum;
  };
  Builder b(out, out.n);
  b.term("payload_mass", "wrench", {"mass"}, [&](int i, int) { return Wrench6{-force(i), Vec3::Zero()}; });
  b.term("com_offset", "wrench", {"x", "y", "z"}, [&](int i, int k) {
    const Vec3 c = Vec3::Unit(k), wi = rate(i);
    return Wrench6{-v.mass * (angular(i).cross(c) + wi.cross(wi.cross(c))), -v.mass * c.cross(force(i))};
  });
  b.term("inertia_error", "wrench", {"xx", "yy", "zz"}, [&](int i, int k) {
    Mat3 J = Mat3::Zero();
    J(k, k) = 1;
    const Vec3 wi = rate(i);
    return Wrench6{Vec3::Zero(), -(J * angular(i) + wi.cross(J * wi))};
  });
  b.term("thrust_scale", "wrench", {"scale"},
         [&](int i, int) { return over_rotors([&](int k) { return rotor_wrench(i, k); }); });
  std::vector<std::string> each;
  for (int k = 0; k < rotors; ++k) each.push_back(fmt::format("scale_{}", k + 1));
  b.term("rotor_thrust_scale", "wrench", each, [&](int i, int k) { return rotor_wrench(i, k); });
  b.term("drag_torque_scale", "wrench", {"scale"}, [&](int i, int) {
    return over_rotors([&](int k) {
      const auto& rotor = v.rotors[static_cast<std::size_t>(k)];
      return Wrench6{Vec3::Zero(), rotor.spin * rotor.drag_ratio * rotor_wrench(i, k).F};
    });
  });
  b.term("rotor_inertia", "wrench", {"inertia"}, [&](int i, int) {
    return over_rotors([&](int k) {
      const Vec3& n = axis[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
      const double s = v.rotors[static_cast<std::size_t>(k)].spin;
      return Wrench6{Vec3::Zero(), s * (domega(at(i), k) * n + speed(at(i), k) * rate(i).cross(n))};
    });
  });
  b.term("tilt_efficiency", "wrench", {"loss", "recovery"}, [&](int i, int which) {
    const double factor = which == 0 ? -1.0 : alpha(at(i), 0);
    return over_rotors([&](int k) {
      const Wrench6 w6 = rotor_wrench(i, k);
      return Wrench6{factor * w6.F, factor * w6.M};
    });
  });
  b.term("tilt_offset", "wrench", {"offset"}, [&](int i, int) {
    return over_rotors([&](int k) {
      const auto& rotor = v.rotors[static_cast<std::size_t>(k)];
      const Vec3 turned = rotor.tilt_axis_B.cross(rotor_wrench(i, k).F);
      return Wrench6{turned, rotor.p_BR.cross(turned) + rotor.spin * rotor.drag_ratio * turned};
    });
  });
  b.term("rotor_drag", "wrench", {"coefficient"}, [&](int i, int) {
    return over_rotors([&](int k) {
      const Vec3& n = axis[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
      const Vec3& arm = v.rotors[static_cast<std::size_t>(k)].p_BR;
      const Vec3 va = velocity_B(i) + rate(i).cross(arm);
      const Vec3 F = -std::abs(speed(at(i), k)) * (va - va.dot(n) * n);
      return Wrench6{F, arm.cross(F)};
    });
  });
  b.term("axial_inflow", "wrench", {"coefficient"}, [&](int i, int) {
    return over_rotors([&](int k) {
      const Vec3& n = axis[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
      const Vec3& arm = v.rotors[static_cast<std::size_t>(k)].p_BR;
      const Vec3 F = -std::abs(speed(at(i), k)) * (velocity_B(i) + rate(i).cross(arm)).dot(n) * n;
      return Wrench6{F, arm.cross(F)};
    });
  });
  b.term("parasitic_drag", "wrench", {"area"}, [&](int i, int) {
    const Vec3 va = velocity_B(i);
    return Wrench6{-0.5 * 1.2 * va.norm() * va, Vec3::Zero()};
  });
  b.term("constant_pull", "wrench", {"x", "y", "z"}, [&](int i, int k) {
    return Wrench6{R[static_cast<std::size_t>(i)].transpose() * Vec3::Unit(k), Vec3::Zero()};
  });
  b.term("hung_cable", "wrench", {"linear_density"}, [&](int i, int) {
    return Wrench6{-kGravity * (*p)(at(i), 2) * R[static_cast<std::size_t>(i)].transpose() * Vec3::UnitZ(),
                   Vec3::Zero()};
  });
  b.term("accelerometer_error", "sensing", {"bias_x", "bias_y", "bias_z"}, [&](int, int k) {
    return Wrench6{v.mass * Vec3::Unit(k), Vec3::Zero()};
  });
  b.term("imu_lever_arm", "sensing", {"x", "y", "z"}, [&](int i, int k) {
    const Vec3 c = Vec3::Unit(k), wi = rate(i);
    return Wrench6{v.mass * (angular(i).cross(c) + wi.cross(wi.cross(c))), Vec3::Zero()};
  });

  out.features.resize(out.n, 12);
  Vec3 lowest = Vec3::Constant(1e9), highest = Vec3::Constant(-1e9), squares = Vec3::Zero();
  for (int i = 0; i < out.n; ++i) {
    out.features.row(i) << p->row(at(i)), vs.row(at(i)), rate(i).transpose(), alpha(at(i), 0),
        force(i).norm(), angular(i).norm();
    const Vec3 r_i = ref->row(at(i)).transpose(), e = p->row(at(i)).transpose() - r_i;
    squares += e.cwiseAbs2();
    lowest = lowest.cwiseMin(r_i);
    highest = highest.cwiseMax(r_i);
  }
  out.tracking_rmse = (squares / out.n).cwiseSqrt();
  const Vec3 span = highest - lowest;
  out.flight = span.z() < 0.05 ? "level" : span.y() < 0.05 ? "steps" : "sines";
  return out;
}

}  // namespace omniflight::proof

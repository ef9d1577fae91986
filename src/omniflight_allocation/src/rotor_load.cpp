#include "omniflight_allocation/rotor_load.hpp"

namespace omniflight::allocation {

Result<RotorLoad> RotorLoad::create(const vehicle::Vehicle& vehicle, double alpha) {
  auto wrenches = WrenchSet::create(vehicle, alpha);
  if (!wrenches) return Failure(std::move(wrenches.error()));
  return RotorLoad(std::move(*wrenches), vehicle, alpha);
}

RotorLoad::RotorLoad(WrenchSet wrenches, const vehicle::Vehicle& vehicle, double alpha)
    : wrenches_(std::move(wrenches)),
      alpha_(alpha),
      mass_(vehicle.mass),
      hover_slope_(vehicle.mass * kGravity * wrenches_.load_slope_of_force()),
      inertia_(vehicle.inertia),
      p_BBcm_(vehicle.center_of_mass) {}

double RotorLoad::load(const Vec6& wrench_B) const {
  Vec6 about_cm = wrench_B;
  about_cm.tail<3>() -= p_BBcm_.cross(wrench_B.head<3>());
  return wrenches_.load(about_cm);
}

Vec6 RotorLoad::required_wrench(const Reference& m) const {
  const Vec3 g_W(0.0, 0.0, -kGravity);
  const Vec3 acceleration_B = m.q_WB.conjugate() * (m.a_WB_W - g_W) + m.dw_WB_B.cross(p_BBcm_) +
                              m.w_WB_B.cross(m.w_WB_B.cross(p_BBcm_));
  Vec6 wrench;
  wrench.head<3>() = mass_ * acceleration_B;
  wrench.tail<3>() =
      inertia_ * m.dw_WB_B + m.w_WB_B.cross(inertia_ * m.w_WB_B) + p_BBcm_.cross(wrench.head<3>());
  return wrench;
}

RotorLoad::Inertial RotorLoad::inertial_wrench(const Reference& motion) const {
  Reference hover;
  hover.q_WB = motion.q_WB;
  const auto about_cm = [&](Vec6 wrench) {
    wrench.tail<3>() -= p_BBcm_.cross(wrench.head<3>());
    return wrench;
  };
  const Vec6 whole = about_cm(required_wrench(motion)), still = about_cm(required_wrench(hover));
  return {wrenches_.unreachable(whole), wrenches_.scaled_norm(whole - still)};
}

double RotorLoad::hover_load(const Quat& q_WB) const {
  return wrenches_.load_of_force(q_WB.conjugate() * Vec3(0.0, 0.0, mass_ * kGravity));
}

}  // namespace omniflight::allocation

#include "omniflight_simulation/faults.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::simulation {
namespace {

constexpr double kSameInstant = 1e-9;  // s, rounding of step times

bool begun(const Fault& f, double t) { return t >= f.at - kSameInstant; }
bool over(const Fault& f, double t) { return t >= f.at + f.duration - kSameInstant; }

}  // namespace

FaultInjector::FaultInjector(std::vector<Fault> faults)
    : faults_(std::move(faults)), progress_(faults_.size()) {}

std::size_t FaultInjector::active() const {
  return static_cast<std::size_t>(std::count_if(progress_.begin(), progress_.end(),
                                                [](const Progress& p) { return p.begun && !p.ended; }));
}

void FaultInjector::before_step(Plant& plant) {
  const double t = plant.time();
  for (std::size_t k = 0; k < faults_.size(); ++k)
    if ((!progress_[k].begun && begun(faults_[k], t)) || (!progress_[k].ended && over(faults_[k], t)))
      (void)plant.situation();  // the answers of this instant are those from before the change
  // ends first: another fault of the same rotor may begin at this instant
  for (std::size_t k = 0; k < faults_.size(); ++k) {
    const Fault& f = faults_[k];
    if (!progress_[k].begun || progress_[k].ended || !over(f, t)) continue;
    progress_[k].ended = true;
    if (f.kind == FaultKind::rotor_loss || f.kind == FaultKind::stuck_rotor) plant.heal_rotor(f.rotor);
  }
  for (std::size_t k = 0; k < faults_.size(); ++k) {
    const Fault& f = faults_[k];
    if (progress_[k].begun || !begun(f, t)) continue;
    progress_[k].begun = true;
    if (over(f, t)) {  // shorter than a step
      progress_[k].ended = true;
      continue;
    }
    if (f.kind == FaultKind::rotor_loss) plant.cut_rotor(f.rotor);
    if (f.kind == FaultKind::stuck_rotor)
      plant.seize_rotor(f.rotor, std::isnan(f.speed) ? plant.rotor_speed()[f.rotor] : f.speed);
    if (f.kind == FaultKind::rope_snag)
      progress_[k].caught_W = plant.body().p_WB + plant.body().q_WB * f.point_B;
  }
  plant.set_disturbance(this);
}

void FaultInjector::add_wrench(const physics::Situation& s, physics::Wrench& out) const {
  for (std::size_t k = 0; k < faults_.size(); ++k) {
    const Fault& f = faults_[k];
    if (!progress_[k].begun || progress_[k].ended) continue;
    if (f.kind == FaultKind::gust) {
      const double phase = std::clamp((s.t - f.at) / f.duration, 0.0, 1.0);
      const double swell = 0.5 * (1 - std::cos(2 * kPi * phase));
      out.force_B += swell * (s.R_WB.transpose() * f.force_W);
      out.torque_B += swell * f.torque_B;
    } else if (f.kind == FaultKind::rope_snag) {
      const Vec3 out_W = s.body.p_WB + s.R_WB * f.point_B - progress_[k].caught_W;
      const double length = out_W.norm();
      if (length <= f.slack || length < 1e-9) continue;
      const Vec3 along_B = s.R_WB.transpose() * out_W / length;
      const Vec3 v_B = s.v_WB_B + s.body.w_WB_B.cross(f.point_B);
      const double tension = std::max(0.0, f.stiffness * (length - f.slack) + f.damping * along_B.dot(v_B));
      out.add_at(f.point_B, -tension * along_B);
    }
  }
}

bool FaultInjector::acts(const Fault& f, FaultySensor sensor, double t) const {
  return (f.kind == FaultKind::sensor_freeze || f.kind == FaultKind::sensor_loss) && f.sensor == sensor &&
         begun(f, t) && !over(f, t);
}

void FaultInjector::alter(double t, SensorFrame& frame) {
  bool* const due[] = {&frame.imu, &frame.mocap, &frame.rotor, &frame.battery};
  for (int k = 0; k < 4; ++k) {
    if (!*due[k]) continue;
    const Fault* fault = nullptr;
    for (const Fault& f : faults_)
      if (acts(f, static_cast<FaultySensor>(k), t)) fault = &f;
    // a sensor that freezes before its first sample has nothing to repeat
    if (fault && (fault->kind == FaultKind::sensor_loss || !seen_[k])) {
      *due[k] = false;
      continue;
    }
    const auto follow = [&](auto& now, auto& last) {
      if (fault) {
        const double stamp = now.t;
        now = last;
        now.t = stamp;
      } else {
        last = now;
      }
    };
    if (k == 0) follow(frame.imu_sample, last_.imu_sample);
    if (k == 1) follow(frame.mocap_sample, last_.mocap_sample);
    if (k == 2) follow(frame.rotor_sample, last_.rotor_sample);
    if (k == 3) follow(frame.battery_sample, last_.battery_sample);
    seen_[k] = true;
  }
}

}  // namespace omniflight::simulation

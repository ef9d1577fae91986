// Forces that no library of multirotor effects has, and springs and pulls between vehicle and world.
#pragma once

#include <vector>

#include "omniflight_proof/world.hpp"

namespace omniflight::proof {

struct Motion {
  double t = 0;
  Vec3 p_W, v_W, w_B;
  Mat3 R_WB;
  Vec3 rotor_circulation_B;    ///< sum of rotor speeds along their axes [rad/s]
  double rotor_speed_sum = 0;  ///< of their sizes [rad/s]
};
struct BodyWrench {
  Vec3 force_B = Vec3::Zero();   ///< N
  Vec3 torque_B = Vec3::Zero();  ///< N m about the body origin
  void add_at(const Vec3& force_in_B, const Vec3& point_B) {
    force_B += force_in_B;
    torque_B += point_B.cross(force_in_B);
  }
};

void add_law(const Law& law, const Motion& motion, BodyWrench& out);
void add_spring(const Spring& spring, const Motion& motion, BodyWrench& out);
void add_pull(const Pull& pull, const Motion& motion, BodyWrench& out);

}  // namespace omniflight::proof

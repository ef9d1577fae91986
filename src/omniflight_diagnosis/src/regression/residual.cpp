#include "omniflight_diagnosis/residual.hpp"

namespace omniflight::diagnosis {

Vec6 wrench_residual(const physics::Situation& s, const Vec3& f, const Vec3& c) {
  const Vec3 &w = s.body.w_WB_B, &dw = s.dw_WB_B;
  const Vec3 f_com = f + dw.cross(c) + w.cross(w.cross(c));
  Vec6 r = -physics::rotor_wrench(s);
  r.head<3>() += s.mass * f_com;
  r.tail<3>() += s.inertia * dw + w.cross(s.inertia * w) + s.mass * c.cross(f_com);
  return r;
}

}  // namespace omniflight::diagnosis

#include "chain.hpp"

namespace omniflight::proof {

Result<std::vector<Vec3>> hanging(const Cable& cable, const Vec3& attachment_W, double floor_z) {
  const double link = cable.length / cable.links;
  const double lowest = floor_z + 0.55 * cable.diameter;  // of the axis of a lying link
  double z = attachment_W.z();
  if (z <= lowest)
    return bad_input("is " + std::to_string(z - floor_z) + " m above the floor at the start",
                     "cable.attachment_m", "Start higher, or move the attachment or floor_z_m");
  std::vector<Vec3> out;
  const double half = 0.5 * cable.initial_bend;
  for (int i = 0; i < cable.links; ++i) {
    const double side = i % 2 == 0 ? half : -half;
    Vec3 direction(std::sin(side), 0.3 * std::sin(side), -std::cos(side));
    direction.normalize();
    if (z + link * direction.z() < lowest) {
      const double down = std::min(1.0, (z - lowest) / link);  // 0 for a link that lies
      const double flat = std::sqrt(1 - down * down);
      direction = Vec3(flat * std::cos(side), flat * std::sin(side), -down);
    }
    z += link * direction.z();
    out.push_back(direction);
  }
  return out;
}

Result<std::vector<Vec3>> bulging(const OverheadRope& rope, const Vec3& attachment_W) {
  const Vec3 reach = rope.anchor_W - attachment_W;
  const double distance = reach.norm();
  if (distance > 0.999 * rope.length)
    return bad_input("is " + std::to_string(rope.length) + " m, and the anchor is " +
                         std::to_string(distance) + " m away at the start",
                     "overhead_rope.length_m", "Give a longer rope");
  // hangs straight down as far as the rest still reaches the anchor, then goes up in two equal parts that
  // bulge
  const int links = even_links(rope);
  const double link = rope.length / links;
  int down = 0;
  while (down + 2 < links &&
         (reach + (down + 2) * link * Vec3::UnitZ()).norm() <= 0.999 * (links - down - 2) * link)
    down += 2;
  const Vec3 rest = reach + down * link * Vec3::UnitZ();
  const Vec3 along = rest.norm() > 1e-6 ? Vec3(rest.normalized()) : Vec3::UnitZ();
  const Vec3 aside = Vec3::UnitY() - along.y() * along;
  const Vec3 side = aside.norm() > 0.1 ? Vec3(aside.normalized()) : Vec3::UnitX();
  const int up = links - down;
  const double cosine = rest.norm() / (up * link), sine = std::sqrt(1 - cosine * cosine);
  std::vector<Vec3> out(static_cast<std::size_t>(down), -Vec3::UnitZ());
  for (int i = 0; i < up; ++i) out.push_back(cosine * along + (i < up / 2 ? sine : -sine) * side);
  return out;
}

std::vector<Quat> joint_attitudes(const std::vector<Vec3>& directions, const Quat& q_WB) {
  std::vector<Quat> out;
  Quat before = q_WB;
  Vec3 from = q_WB * -Vec3::UnitZ();
  for (const Vec3& direction : directions) {
    const Quat now = (shortest_rotation(from, direction) * before).normalized();
    out.push_back((before.conjugate() * now).normalized());
    before = now;
    from = direction;
  }
  return out;
}

}  // namespace omniflight::proof

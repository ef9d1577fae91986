#include "trajectory_message.hpp"

namespace omniflight::components {

void to_message(const Trajectory& trajectory, TrajectoryMessage& out) {
  bus::set_text(out.header.frame_id, "map");
  bus::resize(out.joint_names, 2);
  bus::set_text(bus::view(out.joint_names)[0], "base_link");
  bus::set_text(bus::view(out.joint_names)[1], "tilt");
  bus::resize(out.points, trajectory.knots().size());
  auto points = bus::view(out.points);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const TrajectoryKnot& knot = trajectory.knots()[k];
    auto& point = points[k];
    const std::int64_t ns = to_ns(knot.t);
    point.time_from_start.sec = static_cast<std::int32_t>(ns / 1'000'000'000);
    point.time_from_start.nanosec = static_cast<std::uint32_t>(ns % 1'000'000'000);
    bus::resize(point.transforms, 2);
    bus::resize(point.velocities, 2);
    bus::resize(point.accelerations, 2);
    const Quat tilt(Eigen::AngleAxisd(knot.reference.alpha, Vec3::UnitX()));
    put_quaternion(bus::view(point.transforms)[1].rotation, tilt);
    put(bus::view(point.transforms)[0].translation, knot.reference.p_WB);
    put_quaternion(bus::view(point.transforms)[0].rotation, knot.reference.q_WB);
    put(bus::view(point.velocities)[0].linear, knot.reference.v_WB_W);
    put(bus::view(point.velocities)[0].angular, knot.reference.w_WB_B);
    put(bus::view(point.accelerations)[0].linear, knot.reference.a_WB_W);
    put(bus::view(point.accelerations)[0].angular, knot.reference.dw_WB_B);
  }
}

bool tells_tilt(const TrajectoryMessage& message) { return message.joint_names._length == 2; }

Result<Trajectory> from_message(const TrajectoryMessage& message) {
  std::vector<TrajectoryKnot> knots;
  const std::uint32_t joints = tells_tilt(message) ? 2 : 1;
  const auto points = bus::view(message.points);
  knots.reserve(points.size());
  for (const auto& point : points) {
    if (point.transforms._length != joints || point.velocities._length != joints ||
        point.accelerations._length != joints)
      return bad_input("a point has not one transform, velocity and acceleration a joint",
                       "/command_trajectory point " + std::to_string(knots.size()));
    TrajectoryKnot knot;
    knot.t = static_cast<double>(point.time_from_start.sec) + 1e-9 * point.time_from_start.nanosec;
    const auto& transform = bus::view(point.transforms)[0];
    knot.reference.p_WB = get(transform.translation);
    knot.reference.q_WB = get_quaternion(transform.rotation);
    const auto& velocity = bus::view(point.velocities)[0];
    const auto& acceleration = bus::view(point.accelerations)[0];
    knot.reference.v_WB_W = get(velocity.linear);
    knot.reference.w_WB_B = get(velocity.angular);
    knot.reference.a_WB_W = get(acceleration.linear);
    knot.reference.dw_WB_B = get(acceleration.angular);
    if (joints == 2) {
      const Quat tilt = get_quaternion(bus::view(point.transforms)[1].rotation);
      if (!(std::abs(tilt.norm() - 1.0) < 1e-3))
        return bad_input("the tilt is no rotation",
                         "/command_trajectory point " + std::to_string(knots.size()));
      knot.reference.alpha = log_rotation(tilt.normalized()).x();
    }
    knots.push_back(knot);
  }
  auto trajectory = Trajectory::create(std::move(knots));
  if (!trajectory) {
    Error error = trajectory.error();
    error.where = "/command_trajectory " + error.where;
    return Failure(error);
  }
  return trajectory;
}

}  // namespace omniflight::components

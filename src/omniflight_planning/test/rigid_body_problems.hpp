// Rigid bodies among meshes, made for tests and benchmarks.
#pragma once

#include "meshes.hpp"
#include "omniflight_planning/rigid_body.hpp"

namespace omniflight::planning {

/// Two bars of 0.8 m and 0.1 m thickness that meet at a right angle, about the corner of their box.
inline TriangleMesh l_shaped_body() {
  TriangleMesh mesh;
  add_box(mesh, Vec3(-0.25, -0.25, -0.05), Vec3(0.55, -0.15, 0.05));
  add_box(mesh, Vec3(-0.25, -0.15, -0.05), Vec3(-0.15, 0.55, 0.05));
  return mesh;
}
inline TriangleMesh rod(double length, double thickness) {
  TriangleMesh mesh;
  const Vec3 half(0.5 * length, 0.5 * thickness, 0.5 * thickness);
  add_box(mesh, -half, half);
  return mesh;
}

/// The L through a window of this width and height in the wall between two rooms.
inline RigidBodyProblem l_through_window(double width, double height) {
  return {window_room(width, height),
          l_shaped_body(),
          {Vec3(-1.1, 0.2, 1.2), from_roll_pitch_yaw(Vec3(0.2, 0.1, 0.7))},
          {Vec3(1.1, -0.3, 1.1), from_roll_pitch_yaw(Vec3(0.1, 0.4, -0.5))},
          Vec3(-2, -1.5, 0),
          Vec3(2, 1.5, 2.4)};
}

/// A corridor of 1 m x 1 m with two bends (the shape of a Z), and a rod of this length in it.
inline RigidBodyProblem rod_in_bent_corridor(double length) {
  TriangleMesh world;
  add_box(world, Vec3(0, 1, 0), Vec3(2.5, 4, 1));  // beside the first and the middle part
  add_box(world, Vec3(3.5, 0, 0), Vec3(6, 3, 1));
  add_box(world, Vec3(-0.1, -0.1, -0.1), Vec3(6.1, 4.1, 0));
  add_box(world, Vec3(-0.1, -0.1, 1), Vec3(6.1, 4.1, 1.1));
  add_box(world, Vec3(-0.1, -0.1, 0), Vec3(6.1, 0, 1));
  add_box(world, Vec3(-0.1, 4, 0), Vec3(6.1, 4.1, 1));
  add_box(world, Vec3(-0.1, 0, 0), Vec3(0, 4, 1));
  add_box(world, Vec3(6, 0, 0), Vec3(6.1, 4, 1));
  return {std::move(world),
          rod(length, 0.1),
          {Vec3(0.5 * length + 0.1, 0.5, 0.5), Quat::Identity()},
          {Vec3(5.9 - 0.5 * length, 3.5, 0.5), Quat::Identity()},
          Vec3(0, 0, 0),
          Vec3(6, 4, 1)};
}

}  // namespace omniflight::planning

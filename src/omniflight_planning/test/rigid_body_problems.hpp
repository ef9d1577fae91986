// Rigid bodies among meshes, made for tests and benchmarks.
#pragma once

#include <map>
#include <numbers>

#include "meshes.hpp"
#include "omniflight_core/random.hpp"
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

/// The same surface in triangles without an edge longer than `edge` [m], whose corners are moved by up to
/// `height` [m] each way: closed where it was, and convex nowhere.
inline TriangleMesh roughened(const TriangleMesh& mesh, double edge, double height) {
  TriangleMesh out;
  out.vertices = mesh.vertices;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  auto waiting = mesh.triangles;
  while (!waiting.empty()) {
    const auto t = waiting.back();
    waiting.pop_back();
    const auto length = [&](std::size_t k) {
      return (out.vertices[t[k]] - out.vertices[t[(k + 1) % 3]]).norm();
    };
    std::size_t k = 0;
    for (std::size_t i = 1; i < 3; ++i)
      if (length(i) > length(k)) k = i;
    if (length(k) <= edge) {
      out.triangles.push_back(t);
      continue;
    }
    const auto a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
    const auto [at, is_new] =
        middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(out.vertices.size()));
    if (is_new) out.vertices.push_back(0.5 * (out.vertices[a] + out.vertices[b]));
    waiting.push_back({a, at->second, c});
    waiting.push_back({at->second, b, c});
  }
  Random random(8);
  for (Vec3& p : out.vertices)
    for (int i = 0; i < 3; ++i) p[i] += random.uniform(-height, height);
  out.move(Vec3::Zero());  // measures its box
  return out;
}

/// A ring in the plane of x and y: so many corners round it and round its tube.
inline TriangleMesh ring(double radius, double tube, std::uint32_t around = 40, std::uint32_t across = 16) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t k = 0; k < across; ++k) {
      const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * k / across;
      const double r = radius + tube * std::cos(v);
      mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), tube * std::sin(v));
      const auto at = [&](std::uint32_t di, std::uint32_t dk) {
        return (i + di) % around * across + (k + dk) % across;
      };
      mesh.triangles.push_back({at(0, 0), at(1, 0), at(1, 1)});
      mesh.triangles.push_back({at(0, 0), at(1, 1), at(0, 1)});
    }
  mesh.move(Vec3::Zero());
  return mesh;
}

/// The L and the room of l_through_window() in thousands of small triangles, none of them part of a convex
/// solid.
inline RigidBodyProblem rough_l_through_window(double width, double height) {
  RigidBodyProblem out = l_through_window(width, height);
  out.body = roughened(out.body, 0.06, 0.002);
  out.environment = roughened(out.environment, 0.35, 0.005);
  return out;
}

/// A ring of 0.7 m and a tube of 0.1 m through a window of this width and height.
inline RigidBodyProblem ring_through_window(double width, double height) {
  RigidBodyProblem out = rough_l_through_window(width, height);
  out.body = ring(0.3, 0.05);
  return out;
}

}  // namespace omniflight::planning

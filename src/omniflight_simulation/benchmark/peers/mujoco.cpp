// MuJoCo: free joint and ball joints in reduced coordinates.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <sstream>

#include "peers.hpp"

#ifdef OMNIFLIGHT_HAVE_MUJOCO
#include <mujoco/mujoco.h>

namespace omniflight::benchmarks {
namespace {

std::string mjcf(const vehicle::Vehicle& v, const std::vector<Push>& pushes, int links,
                 MujocoIntegrator integrator, MujocoOptions options) {
  std::ostringstream xml;
  xml.precision(17);
  const double length = kCableLength / kLinks, m = kCableMass / kLinks, bend = m * length * length / 12;
  xml << "<mujoco><option timestep='" << kStep << "' gravity='0 0 " << -kGravity << "' integrator='"
      << (integrator == MujocoIntegrator::rk4 ? "RK4" : "Euler") << "'>"
      << (options == MujocoOptions::bare ? "<flag contact='disable' constraint='disable' sensor='disable'/>"
                                         : "")
      << "</option><worldbody>"
      << "<body name='vehicle' pos='0 0 10'><freejoint/><inertial pos='0 0 0' mass='" << v.mass
      << "' diaginertia='" << v.inertia(0, 0) << ' ' << v.inertia(1, 1) << ' ' << v.inertia(2, 2) << "'/>";
  const bool motors = options == MujocoOptions::rotors;
  for (std::size_t k = 0; motors && k < pushes.size(); ++k) {
    const Vec3 &p = pushes[k].p_B, z = pushes[k].force_B.normalized();
    xml << "<site name='rotor" << k << "' pos='" << p.x() << ' ' << p.y() << ' ' << p.z() << "' zaxis='"
        << z.x() << ' ' << z.y() << ' ' << z.z() << "'/>";
  }
  for (int k = 0; k < links; ++k)
    xml << "<body pos='0 0 " << (k == 0 ? 0.0 : -length) << "'><joint type='ball'/><inertial pos='0 0 "
        << -0.5 * length << "' mass='" << m << "' diaginertia='" << bend << ' ' << bend << ' ' << m * 4.5e-6
        << "'/>";
  for (int k = 0; k < links; ++k) xml << "</body>";
  xml << "</body></worldbody>";
  if (motors) xml << "<actuator>";
  for (std::size_t k = 0; motors && k < pushes.size(); ++k)
    xml << "<motor site='rotor" << k << "' gear='0 0 1 0 0 0'/>";
  xml << (motors ? "</actuator></mujoco>" : "</mujoco>");
  return xml.str();
}

struct World {
  mjModel* model = nullptr;
  mjData* data = nullptr;
  std::vector<Push> pushes;
  bool motors;

  World(const vehicle::Vehicle& v, int links, MujocoIntegrator integrator, MujocoOptions options)
      : pushes(hover_pushes(v, links ? kCableMass : 0)), motors(options == MujocoOptions::rotors) {
    const std::string text = mjcf(v, pushes, links, integrator, options);
    auto vfs = std::make_unique<mjVFS>();
    mj_defaultVFS(vfs.get());
    if (mj_makeEmptyFileVFS(vfs.get(), "model.xml", static_cast<int>(text.size())) == 0) {
      std::memcpy(vfs->filedata[0], text.data(), text.size());
      char error[500] = "";
      model = mj_loadXML("model.xml", vfs.get(), error, sizeof(error));
      if (!model) std::fprintf(stderr, "MuJoCo refuses the benchmark's model: %s\n", error);
    }
    mj_deleteVFS(vfs.get());
    if (model) data = mj_makeData(model);
    if (data) data->qvel[3] = 0.1, data->qvel[4] = 0.2, data->qvel[5] = 0.3;
  }
  World(const World&) = delete;
  ~World() {
    if (data) mj_deleteData(data);
    if (model) mj_deleteModel(model);
  }
  void run(int steps) {
    for (int k = 0; k < steps; ++k) {
      if (motors) {
        for (std::size_t i = 0; i < pushes.size(); ++i) data->ctrl[i] = pushes[i].force_B.norm();
        mj_step(model, data);
        continue;
      }
      mjtNum* out = data->xfrc_applied + 6;
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(data->xmat + 9);
      Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
      for (const Push& p : pushes) {
        const Vec3 f = R * p.force_B;
        force += f;
        torque += (R * p.p_B).cross(f);
      }
      for (int i = 0; i < 3; ++i) out[i] = force[i], out[3 + i] = torque[i];
      mj_step(model, data);
    }
  }
};

Contender make(const vehicle::Vehicle& v, int links, MujocoIntegrator integrator, MujocoOptions options) {
  std::string name = integrator == MujocoIntegrator::rk4 ? "MuJoCo RK4" : "MuJoCo Euler";
  if (options == MujocoOptions::rotors) name += ", eight motors";
  if (options == MujocoOptions::bare) name += ", bare";
  auto world = std::make_shared<World>(v, links, integrator, options);
  if (!world->data) return {name, {}, 1, "the model was refused"};
  return {name, [world](int n) { world->run(n); }, 1, {}};
}

}  // namespace
Contender mujoco_free_body(const vehicle::Vehicle& v, MujocoIntegrator i, MujocoOptions o) {
  return make(v, 0, i, o);
}
Contender mujoco_chain(const vehicle::Vehicle& v, MujocoIntegrator i) {
  return make(v, kLinks, i, MujocoOptions::bare);
}
}  // namespace omniflight::benchmarks

#else
namespace omniflight::benchmarks {
Contender mujoco_free_body(const vehicle::Vehicle&, MujocoIntegrator, MujocoOptions) {
  return {"MuJoCo", {}, 1, "libmujoco-dev is not installed"};
}
Contender mujoco_chain(const vehicle::Vehicle& v, MujocoIntegrator i) {
  return mujoco_free_body(v, i, MujocoOptions::bare);
}
}  // namespace omniflight::benchmarks
#endif

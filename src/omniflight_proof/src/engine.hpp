// MuJoCo's model and data as an owner. The only file with its header besides plant code.
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <string>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight::proof {

struct FreeModel {
  void operator()(mjModel* m) const { mj_deleteModel(m); }
};
struct FreeData {
  void operator()(mjData* d) const { mj_deleteData(d); }
};

struct Engine {
  std::unique_ptr<mjModel, FreeModel> model;
  std::unique_ptr<mjData, FreeData> data;

  /// Compiles MJCF text. MuJoCo's own message becomes the error.
  static Result<Engine> compile(const std::string& xml);

  int body(const std::string& name) const { return mj_name2id(model.get(), mjOBJ_BODY, name.c_str()); }
  int joint(const std::string& name) const { return mj_name2id(model.get(), mjOBJ_JOINT, name.c_str()); }

  Vec3 body_position(int id) const { return Eigen::Map<const Vec3>(data->xpos + 3 * id); }
  Quat body_attitude(int id) const {
    const mjtNum* q = data->xquat + 4 * id;
    return Quat(q[0], q[1], q[2], q[3]);
  }
};

}  // namespace omniflight::proof

#include "engine.hpp"

#include <cstring>
#include <mutex>

namespace omniflight::proof {

Result<Engine> Engine::compile(const std::string& xml) {
  static std::mutex mutex;  // the compiler of MuJoCo keeps its last XML in a global
  const std::lock_guard lock(mutex);
  // a warning must not leave MUJOCO_LOG.TXT in whatever folder this runs in; the plant looks at the state
  // itself
  mju_user_warning = [](const char*) {};
  const auto vfs = std::make_unique<mjVFS>();
  mj_defaultVFS(vfs.get());
  if (mj_makeEmptyFileVFS(vfs.get(), "world.xml", static_cast<int>(xml.size())) != 0)
    return fail(ErrorCode::internal, "no room for the model's text", "mujoco");
  std::memcpy(vfs->filedata[0], xml.data(), xml.size());
  char message[1000] = "";
  Engine out;
  out.model.reset(mj_loadXML("world.xml", vfs.get(), message, sizeof message));
  mj_deleteVFS(vfs.get());
  if (!out.model) return bad_input(std::string("MuJoCo refuses the model: ") + message, "world");
  out.data.reset(mj_makeData(out.model.get()));
  if (!out.data) return fail(ErrorCode::internal, "not enough memory for the model", "mujoco");
  return out;
}

}  // namespace omniflight::proof

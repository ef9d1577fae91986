// Meshes of unknown origin: the scan of the bytes, and assimp behind it where the scan lets them pass. The
// first byte of an input tells its format.
#include "meshes.hpp"
#include "mutated_inputs.hpp"

namespace {

constexpr const char* kNames[] = {"fuzz.stl", "fuzz.obj", "fuzz.ply", "fuzz.dae"};

omniflight::planning::TriangleMesh box() {
  omniflight::planning::TriangleMesh mesh;
  omniflight::planning::add_box(mesh, {-1, 0, 0.5}, {1, 2, 1.25});
  return mesh;
}

}  // namespace

std::vector<std::string> seeds() {
  using namespace omniflight::planning;
  return {'\0' + binary_stl_of(box()), '\0' + ascii_stl_of(box()), '\1' + obj_of(box()),
          '\2' + ascii_ply_of(box()), '\3' + dae_of(box())};
}

void feed(std::string_view input) {
  if (input.empty()) return;
  const char* name = kNames[static_cast<unsigned char>(input.front()) % 4];
  (void)omniflight::planning::mesh_of(std::string(input.substr(1)), name, {.any_span = true});
}

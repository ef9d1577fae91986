// The only file that knows assimp.
#include <assimp/BaseImporter.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <algorithm>
#include <assimp/DefaultLogger.hpp>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <assimp/ProgressHandler.hpp>
#include <cmath>
#include <cstring>
#include <unordered_map>

#include "mesh_scan.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/mesh.hpp"
#include "text.hpp"

namespace omniflight::planning {
namespace {

constexpr int kMostLevels = 64;  // of nodes

/// The file's bytes, and nothing else: a mesh that names another file does not get it.
class OneFile final : public Assimp::IOSystem {
 public:
  OneFile(const std::string& bytes, std::string file) : bytes_(bytes), file_(std::move(file)) {}
  bool Exists(const char* file) const override { return file_ == file; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    return file_ == file && std::strchr(mode, 'r') != nullptr ? new Stream(bytes_) : nullptr;
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  class Stream final : public Assimp::IOStream {
   public:
    explicit Stream(const std::string& bytes) : bytes_(bytes) {}
    std::size_t Read(void* to, std::size_t size, std::size_t count) override {
      if (size == 0) return 0;
      const std::size_t whole = std::min(count, (bytes_.size() - at_) / size);
      std::memcpy(to, bytes_.data() + at_, whole * size);
      at_ += whole * size;
      return whole;
    }
    std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
    aiReturn Seek(std::size_t offset, aiOrigin origin) override {
      const std::size_t from = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? at_ : bytes_.size();
      // SetEnd counts back from there
      if (origin == aiOrigin_END ? offset > from : offset > bytes_.size() - from) return aiReturn_FAILURE;
      at_ = origin == aiOrigin_END ? from - offset : from + offset;
      return aiReturn_SUCCESS;
    }
    std::size_t Tell() const override { return at_; }
    std::size_t FileSize() const override { return bytes_.size(); }
    void Flush() override {}

   private:
    const std::string& bytes_;
    std::size_t at_ = 0;
  };
  const std::string& bytes_;
  const std::string file_;
};

class Hurry final : public Assimp::ProgressHandler {
 public:
  explicit Hurry(const Deadline& deadline) : deadline_(deadline) {}
  bool Update(float) override { return !deadline_.passed(); }

 private:
  const Deadline& deadline_;
};

/// Triangles that the faces of a scene ask for, each mesh once.
std::size_t triangles_asked(const aiScene& scene) {
  std::size_t sum = 0;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m)
    for (unsigned f = 0; f < scene.mMeshes[m]->mNumFaces; ++f)
      sum += std::max(2u, scene.mMeshes[m]->mFaces[f].mNumIndices) - 2u;
  return sum;
}

/// assimp takes a face without corners for a polygon, and aborts the process when it is to make triangles of
/// it.
bool has_empty_face(const aiScene& scene) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m)
    for (unsigned f = 0; f < scene.mMeshes[m]->mNumFaces; ++f)
      if (scene.mMeshes[m]->mFaces[f].mNumIndices == 0) return true;
  return false;
}

/// Joins the meshes of a scene, each where its nodes place it, and vertices of the same coordinates.
class Joiner {
 public:
  Joiner(const aiScene& scene, const std::string& name) : scene_(scene), name_(name) {}

  Status add(const aiNode& node, const aiMatrix4x4& parent, int level) {
    if (level > kMostLevels) return refuse_mesh("nodes within nodes, more than 64 deep", name_);
    const aiMatrix4x4 placed = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i)
      if (auto ok = add(*scene_.mMeshes[node.mMeshes[i]], placed); !ok) return ok;
    for (unsigned i = 0; i < node.mNumChildren; ++i)
      if (auto ok = add(*node.mChildren[i], placed, level + 1); !ok) return ok;
    return {};
  }
  TriangleMesh mesh;

 private:
  struct Bits {
    std::array<double, 3> at;
    bool operator==(const Bits&) const = default;
  };
  struct Hash {
    std::size_t operator()(const Bits& b) const {
      std::size_t out = 0;
      for (const double x : b.at) out = out * 1'000'003u ^ std::hash<double>()(x);
      return out;
    }
  };

  Status add(const aiMesh& part, const aiMatrix4x4& placed) {
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices < 3) continue;  // points and lines have no surface
      if (mesh.triangles.size() >= kMaxMeshTriangles)
        return refuse_mesh(text("more than %zu triangles", kMaxMeshTriangles), name_);
      std::array<std::uint32_t, 3> corners{};
      for (unsigned k = 0; k < 3; ++k) {
        if (face.mIndices[k] >= part.mNumVertices)
          return refuse_mesh("a face points outside of its vertices", name_);
        const aiVector3D p = placed * part.mVertices[face.mIndices[k]];
        const Bits bits{{p.x + 0.0, p.y + 0.0, p.z + 0.0}};  // -0 is 0
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
          return refuse_mesh(text("a coordinate of triangle %zu is not finite", mesh.triangles.size() + 1),
                             name_);
        const auto [at, is_new] = known_.try_emplace(bits, static_cast<std::uint32_t>(mesh.vertices.size()));
        if (is_new) mesh.vertices.emplace_back(bits.at[0], bits.at[1], bits.at[2]);
        corners[k] = at->second;
      }
      mesh.triangles.push_back(corners);
    }
    return {};
  }

  const aiScene& scene_;
  const std::string& name_;
  std::unordered_map<Bits, std::uint32_t, Hash> known_;
};

void measure(TriangleMesh& mesh) {
  mesh.lower = Vec3::Constant(HUGE_VAL), mesh.upper = -mesh.lower;
  for (const Vec3& p : mesh.vertices)
    mesh.lower = mesh.lower.cwiseMin(p), mesh.upper = mesh.upper.cwiseMax(p);
}

const char* extension(MeshFormat format) {
  switch (format) {
    case MeshFormat::stl:
      return "stl";
    case MeshFormat::obj:
      return "obj";
    case MeshFormat::ply:
      return "ply";
    case MeshFormat::dae:
      return "dae";
  }
  return "";
}

/// The one reader that is asked; the others are not offered the file. Who unregisters a reader owns it
/// (assimp 5.2, Importer::UnregisterLoader only takes it off the list).
void keep_only(Assimp::Importer& importer, const char* format) {
  Assimp::BaseImporter* wanted = importer.GetImporter(format);
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;)
    if (Assimp::BaseImporter* reader = importer.GetImporter(i); reader != wanted)
      if (importer.UnregisterLoader(reader) == aiReturn_SUCCESS) delete reader;
}

Result<TriangleMesh> parse(const std::string& bytes, const std::string& name, MeshFormat format,
                           const Deadline& deadline) {
  const std::string file = std::string("mesh.") + extension(format);
  Assimp::Importer importer;
  keep_only(importer, extension(format));
  importer.SetIOHandler(new OneFile(bytes, file));
  importer.SetProgressHandler(new Hurry(deadline));
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(file, 0);
  const auto no_scene = [&]() -> Failure {
    if (deadline.passed()) return out_of_time(deadline, "reading the mesh " + name);
    return refuse_mesh("the mesh cannot be read: " + files::shown(importer.GetErrorString()), name);
  };
  if (scene == nullptr || scene->mRootNode == nullptr || scene->mNumMeshes == 0) return no_scene();
  if (has_empty_face(*scene)) return refuse_mesh("a face has no corners", name);
  const std::size_t asked = triangles_asked(*scene);
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr) return no_scene();
  // a face that was left out would be a hole
  if (triangles_asked(*scene) < asked)
    return refuse_mesh(
        "a face of more than three corners cannot be made triangles: it crosses itself or has no area", name);
  Joiner join(*scene, name);
  if (auto ok = join.add(*scene->mRootNode, aiMatrix4x4(), 0); !ok) return Failure(ok.error());
  if (join.mesh.triangles.empty()) return refuse_mesh("the file has no triangle", name);
  measure(join.mesh);
  return std::move(join.mesh);
}

}  // namespace

Vec3 TriangleMesh::mean_vertex() const {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : vertices) sum += p;
  return sum / static_cast<double>(vertices.size());
}

void TriangleMesh::move(const Vec3& by) {
  for (Vec3& p : vertices) p += by;
  measure(*this);
}

void TriangleMesh::scale(double factor) {
  for (Vec3& p : vertices) p *= factor;
  measure(*this);
}

Result<TriangleMesh> mesh_of(const std::string& bytes, const std::string& name, const MeshOptions& options) {
  const auto header = scan_mesh(bytes, name);
  if (!header) return Failure(header.error());
  if (options.deadline.passed()) return out_of_time(options.deadline, "looking through the mesh " + name);
  auto mesh = parse(bytes, name, header->format, options.deadline);
  if (!mesh) return mesh;
  // assimp has applied the file's unit, and left its axes (COLLADA 1.4.1, up_axis) as they are
  const double scale = options.scale ? *options.scale / header->unit : 1.0;
  for (Vec3& p : mesh->vertices) {
    if (header->up_axis == 'Y') p = Vec3(p.x(), -p.z(), p.y());
    if (header->up_axis == 'X') p = Vec3(-p.y(), -p.z(), p.x());
  }
  measure(*mesh);
  if (scale != 1.0) mesh->scale(scale);
  const double span = (mesh->upper - mesh->lower).maxCoeff();
  const double farthest = std::max(mesh->lower.cwiseAbs().maxCoeff(), mesh->upper.cwiseAbs().maxCoeff());
  if (!options.any_span && !(span >= kMinMeshSpan && span <= kMaxMeshSpan && farthest <= 10.0 * kMaxMeshSpan))
    return bad_input(
        text("the mesh spans %.4g m, at up to %.4g m from its origin: %.4g to %.4g m are allowed", span,
             farthest, kMinMeshSpan, kMaxMeshSpan),
        name, "Its unit is hardly the metre: export it in metres, or give --scale (0.001 for millimetres)");
  return mesh;
}

Result<TriangleMesh> read_mesh(const std::filesystem::path& path, const MeshOptions& options) {
  const auto bytes = files::read_file(path, kMaxMeshBytes);
  if (!bytes) return Failure(bytes.error());
  return mesh_of(*bytes, path.string(), options);
}

}  // namespace omniflight::planning

// Mesh files: the same surface from every format, and what is refused.
#include "omniflight_planning/mesh.hpp"

#include <gtest/gtest.h>
#include <malloc.h>
#include <octomap/OcTree.h>

#include <fstream>

#include "bench.hpp"
#include "meshes.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_planning/octree_file.hpp"

namespace omniflight::planning {
namespace {

TriangleMesh box() {
  TriangleMesh mesh;
  add_box(mesh, Vec3(-1, 0, 0.5), Vec3(1, 2, 1.25));
  return mesh;
}

std::string binary_ply(bool big) {
  const TriangleMesh mesh = box();
  std::string out =
      std::string("ply\nformat binary_") + (big ? "big" : "little") +
      "_endian 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face "
      "12\nproperty list uchar int vertex_indices\nend_header\n";
  const auto put = [&](auto value) {
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
    if (big) bytes = std::string(bytes.rbegin(), bytes.rend());
    out += bytes;
  };
  for (const Vec3& p : mesh.vertices)
    for (int k = 0; k < 3; ++k) put(static_cast<float>(p[k]));
  for (const auto& t : mesh.triangles) {
    out += '\3';
    for (const auto i : t) put(i);
  }
  return out;
}

void expect_box(const Result<TriangleMesh>& mesh, double scale = 1.0) {
  ASSERT_TRUE(mesh) << mesh.error().text();
  EXPECT_EQ(mesh->vertices.size(), 8u);
  EXPECT_EQ(mesh->triangles.size(), 12u);
  EXPECT_LT((mesh->lower - scale * Vec3(-1, 0, 0.5)).norm(), 1e-6 * scale);
  EXPECT_LT((mesh->upper - scale * Vec3(1, 2, 1.25)).norm(), 1e-6 * scale);
}

void expect_refused(const Result<TriangleMesh>& mesh, const std::string& why) {
  ASSERT_FALSE(mesh) << why;
  EXPECT_EQ(mesh.error().code, ErrorCode::bad_input);
  EXPECT_NE(mesh.error().text().find(why), std::string::npos) << mesh.error().text();
  EXPECT_FALSE(mesh.error().where.empty());
  EXPECT_FALSE(mesh.error().next_step.empty());
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(Mesh, IsTheSameFromEveryFormat) {
  expect_box(mesh_of(binary_stl_of(box()), "a.stl"));
  expect_box(mesh_of(ascii_stl_of(box()), "a.STL"));
  expect_box(mesh_of(obj_of(box()), "a.obj"));
  expect_box(mesh_of(ascii_ply_of(box()), "a.ply"));
  expect_box(mesh_of(binary_ply(false), "a.ply"));
  expect_box(mesh_of(binary_ply(true), "a.ply"));
  expect_box(mesh_of(dae_of(box()), "a.dae"));
}

TEST(Mesh, TakesTheUnitThatAColladaFileTells) {
  expect_box(mesh_of(dae_of(box(), "<unit name=\"centimeter\" meter=\"0.01\"/>"), "a.dae"), 0.01);
  expect_box(mesh_of(dae_of(box(), "<unit name=\"centimeter\" meter=\"0.01\"/>"), "a.dae", {.scale = 1.0}));
  expect_box(mesh_of(binary_stl_of(box()), "a.stl", {.scale = 2.0}), 2.0);
}

TEST(Mesh, TurnsTheUpAxisOfAColladaFileToZ) {
  const auto of = [](const char* axis) {
    return mesh_of(replaced(dae_of(box()), "Z_UP", axis), "a.dae").value();
  };
  const Vec3 low(-1, 0, 0.5), high(1, 2, 1.25);  // as the file tells them
  EXPECT_LT((of("Y_UP").lower - Vec3(low.x(), -high.z(), low.y())).norm(), 1e-6);
  EXPECT_LT((of("Y_UP").upper - Vec3(high.x(), -low.z(), high.y())).norm(), 1e-6);
  EXPECT_LT((of("X_UP").lower - Vec3(-high.y(), -high.z(), low.x())).norm(), 1e-6);
  EXPECT_LT((of("X_UP").upper - Vec3(-low.y(), -low.z(), high.x())).norm(), 1e-6);
  expect_refused(mesh_of(replaced(dae_of(box()), "Z_UP", "W_UP"), "a.dae"), "up_axis");
}

TEST(Mesh, PlacesANodeWhereItsMatrixDoes) {
  const auto mesh =
      mesh_of(dae_of(box(), "<unit meter=\"1\"/>",
                     "<node><matrix>1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1</matrix><node><instance_geometry "
                     "url=\"#g\"/></node></node><node><instance_geometry url=\"#g\"/></node>"),
              "a.dae");
  ASSERT_TRUE(mesh) << mesh.error().text();
  EXPECT_EQ(mesh->triangles.size(), 24u);
  EXPECT_NEAR(mesh->upper.x(), 6.0, 1e-5);
  EXPECT_NEAR(mesh->lower.x(), -1.0, 1e-5);
}

TEST(Mesh, MakesTrianglesOfFacesThatAreNone) {
  const auto mesh = mesh_of("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 0.2 0\nv 0 1 0\nf 1 2 3 4 5\n", "a.obj");
  ASSERT_TRUE(mesh) << mesh.error().text();
  EXPECT_EQ(mesh->triangles.size(), 3u);
  double area = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto t = mesh->corners(i);
    area += 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm();
  }
  EXPECT_NEAR(area, 1.2, 1e-6);  // 2 x 1 less the notch of 2 x 0.8 / 2
}

TEST(Mesh, RefusesAnotherUnitByTheSpan) {
  TriangleMesh wide = box();
  wide.scale(3000.0);
  expect_refused(mesh_of(binary_stl_of(wide), "a.stl"), "spans 6000 m");
  wide.scale(1e-8);
  expect_refused(mesh_of(binary_stl_of(wide), "a.stl"), "spans 6e-05 m");
  EXPECT_TRUE(mesh_of(binary_stl_of(wide), "a.stl", {.any_span = true}));
}

TEST(Mesh, RefusesHostileStl) {
  const std::string good = binary_stl_of(box());
  std::string lying = good;
  lying[83] = '\x7f';
  expect_refused(mesh_of(lying, "a.stl"), "84 + 50 a triangle");
  expect_refused(mesh_of(good.substr(0, good.size() - 1), "a.stl"), "84 + 50 a triangle");
  expect_refused(mesh_of("", "a.stl"), "neither an ASCII .stl");
  expect_refused(mesh_of(std::string(84, '\0'), "a.stl"), "no triangle");
  std::string not_finite = good;
  const float nan = NAN;
  std::memcpy(not_finite.data() + 84 + 12 + 50, &nan, sizeof nan);
  expect_refused(mesh_of(not_finite, "a.stl"), "not finite");
  expect_refused(mesh_of(replaced(ascii_stl_of(box()), "vertex -1", "vertex nan"), "a.stl"),
                 "a finite number");
  expect_refused(mesh_of(replaced(ascii_stl_of(box()), "endloop", "loop"), "a.stl"), "'endloop' is due");
  expect_refused(mesh_of("solid\nfacet normal 0 0 0\n", "a.stl"), "'outer' is due");
  expect_refused(mesh_of("solid\nendsolid\n", "a.stl"), "no triangle");
}

TEST(Mesh, RefusesHostileObj) {
  const std::string good = obj_of(box());
  expect_refused(mesh_of(good + "f 1 2 9\n", "a.obj"), "none of the 8 vertices");
  expect_refused(mesh_of(good + "f 1 2 -9\n", "a.obj"), "none of the 8 vertices");
  expect_refused(mesh_of(good + "f 1 2 0\n", "a.obj"), "none of the 8 vertices");
  expect_refused(mesh_of(good + "f 1 2\n", "a.obj"), "fewer than three corners");
  expect_refused(mesh_of(good + "v 1 2 inf\n", "a.obj"), "no coordinate");
  expect_refused(mesh_of(good + "curv2 1 2\n", "a.obj"), "'curv2'");
  expect_refused(mesh_of(good + "f 1 \\\n2 3\n", "a.obj"), "continued");
  expect_refused(mesh_of("v 0 0 0\n", "a.obj"), "no face");
  std::string wide = good + "f";
  for (int i = 0; i < 1002; ++i) wide += " 1";
  expect_refused(mesh_of(wide + "\n", "a.obj"), "more than 1000 corners");
}

TEST(Mesh, RefusesHostilePly) {
  const std::string good = ascii_ply_of(box());
  expect_refused(mesh_of(replaced(good, "element vertex 8", "element vertex 4000000000"), "a.ply"),
                 "no count");
  expect_refused(mesh_of(replaced(good, "element vertex 8", "element vertex 7"), "a.ply"), "");
  expect_refused(mesh_of(replaced(good, "3 0 2 1", "3 0 2 8"), "a.ply"), "outside of the 8 vertices");
  expect_refused(mesh_of(replaced(good, "3 0 2 1", "3 0 2 -1"), "a.ply"), "outside of the 8 vertices");
  expect_refused(mesh_of(replaced(good, "3 0 2 1", "200 0 2 1"), "a.ply"), "face");
  expect_refused(mesh_of(replaced(good, "list uchar", "list float"), "a.ply"), "no whole type");
  expect_refused(mesh_of(replaced(good, "ascii 1.0", "ascii64 1.0"), "a.ply"), "format 'ascii64'");
  expect_refused(mesh_of(replaced(good, "end_header", "end_heade"), "a.ply"), "unknown line");
  expect_refused(mesh_of(binary_ply(true).substr(0, 300), "a.ply"), "the file ends there");
  // assimp takes one line for an element: what is left of it would be the next one, a face without corners
  expect_refused(mesh_of(replaced(good, "1 2 1.25\n3 0", "1 2 \n.25\n3 0"), "a.ply"), "lacks a finite 'z'");
  expect_refused(mesh_of(replaced(good, "-1 0 0.5", "-1 0\r0.5"), "a.ply"), "a line of its own");
  expect_refused(mesh_of(replaced(good, "-1 0 0.5", "-1 0 0.5 7"), "a.ply"), "a line of its own");
}

TEST(Mesh, RefusesHostileCollada) {
  const std::string good = dae_of(box());
  expect_refused(mesh_of(replaced(good, "<COLLADA", "<!DOCTYPE x [<!ENTITY a \"b\">]><COLLADA"), "a.dae"),
                 "declarations");
  expect_refused(mesh_of(replaced(good, "count=\"24\"", "count=\"4000000000\""), "a.dae"),
                 "count of 'float_array'");
  expect_refused(mesh_of(replaced(good, "offset=\"0\"", "offset=\"500000000\""), "a.dae"),
                 "offset of 'input'");
  expect_refused(mesh_of(good.substr(0, good.size() - 20), "a.dae"), "");
  expect_refused(mesh_of(dae_of(box(), "<unit meter=\"1e300\"/>"), "a.dae"), "unit meter");
  std::string deep, ends;
  for (int i = 0; i < 100; ++i) deep += "<node>", ends += "</node>";
  expect_refused(mesh_of(dae_of(box(), "", deep + ends), "a.dae"), "64 deep");
  expect_refused(
      mesh_of(replaced(good, "<library_geometries>",
                       "<library_nodes><node id=\"a\"><instance_node url=\"#a\"/></node></library_nodes>"
                       "<library_geometries>"),
              "a.dae"),
      "unfold without end");
  std::string many;
  for (int i = 0; i < 400; ++i) many += "<node><instance_node url=\"#n\"/></node>";
  expect_refused(mesh_of(dae_of(box(), "", many), "a.dae"), "may unfold");
  expect_refused(mesh_of(replaced(good, "0 2 1", "0 2 99999999"), "a.dae"), "");
  // the reader of assimp 5.2 loops at these
  expect_refused(mesh_of(replaced(good, "<p>0 2 1", "<p>0 x 1"), "a.dae"), "'x' of 'p' is no index");
  expect_refused(mesh_of(replaced(good, "<p>0 2 1", "<p><!-- --> x 2 1"), "a.dae"), "other than numbers");
  expect_refused(mesh_of(replaced(good, "<p>0 2 1", "<p>0 -2 1"), "a.dae"), "'-2' of 'p' is no index");
  expect_refused(mesh_of(replaced(good, "-1 0 0.5", "-1 nan 0.5"), "a.dae"), "'nan' of 'float_array'");
  expect_refused(mesh_of(replaced(good, "<p>0 2 1", "<p>0 \f2 1"), "a.dae"), "control character");
  // what is read beyond the numbers of a list
  expect_refused(mesh_of(replaced(good, "a\" count=", "a\" coump="), "a.dae"),
                 "count of 'float_array' is missing");
  expect_refused(mesh_of(replaced(good, "count=\"24\"", "count=\"23\""), "a.dae"),
                 "24 numbers where count tells 23");
  expect_refused(mesh_of(replaced(good, "count=\"8\"", "count=\"9\""), "a.dae"),
                 "reads 27 numbers where there are 24");
  expect_refused(mesh_of(replaced(good, "stride=\"3\"", "stride=\"4\""), "a.dae"), "reads 31 numbers");
  expect_refused(mesh_of(replaced(good, "stride=\"3\"", "stride=\"3\" offset=\"1\""), "a.dae"),
                 "reads 25 numbers");
  expect_refused(mesh_of(replaced(good, "source=\"#a\"", "source=\"#b\""), "a.dae"), "'b'");
  expect_refused(mesh_of(replaced(good, "<param name=\"X\"", "<param/><param name=\"X\""), "a.dae"),
                 "reads 25 numbers");
  const std::string shorter = "<float_array id=\"a\" count=\"1\">0</float_array><technique_common>";
  expect_refused(mesh_of(replaced(good, "<technique_common>", shorter), "a.dae"), "where there are 1");
  expect_refused(mesh_of(replaced(good, "source=\"#a\"", "source=\"#&#97;\""), "a.dae"),
                 "written as another");
  expect_refused(mesh_of(replaced(good, "id=\"a\"", "id=\"a\n\""), "a.dae"), "written as another");
  // a count that only this scan would see, and a > in a value
  expect_refused(mesh_of(replaced(good, "a\" count=\"24\"", "a\" name=' count=\"24\"'"), "a.dae"),
                 "count of 'float_array' is missing");
  expect_refused(mesh_of(replaced(good, "<unit ", "<unit name=\">\" "), "a.dae"), "NAME=\"VALUE\"");
  expect_refused(
      mesh_of(replaced(good, "<scene>", "<library_animations><animation/></library_animations><scene>"),
              "a.dae"),
      "animations and skins");
}

TEST(Mesh, RefusesWhatIsTooLargeOrOfAnotherKind) {
  expect_refused(mesh_of(std::string(kMaxMeshBytes + 1, ' '), "a.obj"), "more than the limit");
  expect_refused(mesh_of(binary_stl_of(box()), "a.blend"), "'.blend'");
  std::string many = obj_of(box());
  for (int i = 0; i < 500'001; ++i) many += "f 1 2 3\n";
  expect_refused(mesh_of(many, "a.obj"), "more than 500000 triangles");
}

/// What damaged files do: an error or a mesh, never a crash nor a number that is not finite.
void damage(const char* name, const std::string& good, int least_read) {
  Random random(1);
  int read = 0, refused = 0;
  for (int round = 0; round < 400; ++round) {
    std::string bytes = good;
    const auto place = [&] {
      return static_cast<std::size_t>(random.uniform() * static_cast<double>(bytes.size()));
    };
    const int changes = 1 + static_cast<int>(4 * random.uniform());
    for (int i = 0; i < changes; ++i) bytes[place()] = static_cast<char>(256 * random.uniform());
    if (random.uniform() < 0.2) bytes.resize(place());
    std::ofstream(std::filesystem::path(testing::TempDir()) / (std::string("damaged_") + name),
                  std::ios::binary)
        << bytes;  // what a crash leaves behind
    const auto mesh = mesh_of(bytes, name, {.any_span = true});
    ++(mesh ? read : refused);
    if (!mesh) continue;
    for (const Vec3& p : mesh->vertices) EXPECT_TRUE(p.allFinite());
    for (const auto& t : mesh->triangles)
      for (const auto i : t) EXPECT_LT(i, mesh->vertices.size());
  }
  EXPECT_GT(read, least_read);  // a change of a text is hardly ever a number
  EXPECT_GT(refused, 20);
}

TEST(DamagedMesh, BinaryStl) { damage("b.stl", binary_stl_of(box()), 20); }
TEST(DamagedMesh, AsciiStl) { damage("a.stl", ascii_stl_of(box()), -1); }
TEST(DamagedMesh, Obj) { damage("a.obj", obj_of(box()), -1); }
TEST(DamagedMesh, AsciiPly) { damage("a.ply", ascii_ply_of(box()), -1); }
TEST(DamagedMesh, BinaryPly) { damage("b.ply", binary_ply(false), 20); }
TEST(DamagedMesh, Collada) { damage("a.dae", dae_of(box()), -1); }

TEST(MeshOctree, HoldsEveryPointOfTheSurfaceAndLeavesTheRestFree) {
  Random random(3);
  TriangleMesh mesh = box();
  for (Vec3& p : mesh.vertices)  // nothing lies on a voxel's face any more
    p = exp_rotation(Vec3(0.3, -0.2, 0.5)) * (p + Vec3(0.013, 0.007, 0.003));
  mesh.move(Vec3::Zero());
  const auto tree = make_octree(mesh, "a", {.resolution = 0.1}).value();
  for (int i = 0; i < 20'000; ++i) {
    const auto t = mesh.corners(static_cast<std::size_t>(12 * random.uniform()));
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3 p = t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
    const auto* node = tree->search(p.x(), p.y(), p.z());
    ASSERT_TRUE(node != nullptr && tree->isNodeOccupied(node)) << p.transpose();
  }
  // voxels a diagonal and more away from the surface are free: the conservatism has an end
  int looked = 0;
  for (int i = 0; i < 20'000; ++i) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = random.uniform(mesh.lower[k], mesh.upper[k]);
    double nearest = HUGE_VAL;
    const Vec3 in_box = exp_rotation(Vec3(0.3, -0.2, 0.5)).conjugate() * p - Vec3(0.013, 0.007, 0.003);
    const Vec3 low = in_box - Vec3(-1, 0, 0.5), high = Vec3(1, 2, 1.25) - in_box;
    if (low.minCoeff() > 0 && high.minCoeff() > 0) nearest = std::min(low.minCoeff(), high.minCoeff());
    if (nearest == HUGE_VAL || nearest < 0.1 * std::sqrt(3.0) + 1e-6) continue;
    ++looked;
    const auto* node = tree->search(p.x(), p.y(), p.z());
    ASSERT_TRUE(node != nullptr && !tree->isNodeOccupied(node)) << p.transpose();
  }
  EXPECT_GT(looked, 1000);
}

TEST(MeshOctree, HoldsThatOfTheSamePrimitives) {
  // the walls of the test bed lie a millimetre inside of their voxels: the mesh of these boxes gives the same
  const TestBed bed = window_bed(0.6, 0.6, 0.05);
  TriangleMesh mesh;
  for (const Primitive& p : bed.primitives) add_box(mesh, p.a - 0.5 * p.b, p.a + 0.5 * p.b);
  const auto tree =
      make_octree(mesh, "a", {.resolution = 0.05, .box = std::array{bed.lower, bed.upper}}).value();
  const auto same = make_octree(bed).value();
  std::size_t surface = 0;
  for (double x = -1.975; x < 2; x += 0.05)
    for (double y = -1.475; y < 1.5; y += 0.05)
      for (double z = 0.025; z < 2.4; z += 0.05) {
        const auto *here = tree->search(x, y, z), *there = same->search(x, y, z);
        ASSERT_TRUE(here != nullptr && there != nullptr);
        // walls of two voxels have no inside, so that the surface is all of them
        ASSERT_EQ(tree->isNodeOccupied(here), same->isNodeOccupied(there)) << x << " " << y << " " << z;
        surface += tree->isNodeOccupied(here);
      }
  EXPECT_GT(surface, 1000u);
}

TEST(Mesh, ReadingKeepsNoMemory) {
  const auto read = [](int times) {
    for (int k = 0; k < times; ++k) {
      EXPECT_TRUE(mesh_of(binary_stl_of(box()), "box.stl"));
      EXPECT_TRUE(mesh_of(obj_of(box()), "box.obj"));
      EXPECT_TRUE(mesh_of(ascii_ply_of(box()), "box.ply"));
      EXPECT_TRUE(mesh_of(dae_of(box()), "box.dae"));
    }
    return mallinfo2().uordblks;
  };
  const std::size_t before = read(10);  // what is made once
  EXPECT_LE(read(100), before + (16u << 10)) << "bytes in use before and after 400 readings";
}

TEST(MeshOctree, RefusesBoxesThatHoldNothingOrTooMuch) {
  const auto text_of = [](const auto& result) { return result ? std::string() : result.error().text(); };
  EXPECT_NE(text_of(make_octree(box(), "a", {.resolution = 1e-4})).find("outside [0.001, 10]"),
            std::string::npos);
  EXPECT_NE(text_of(make_octree(box(), "a", {.resolution = 1e-3})).find("more than the limit"),
            std::string::npos);
  EXPECT_NE(text_of(make_octree(box(), "a", {.box = std::array{Vec3(4, 4, 4), Vec3(5, 5, 5)}}))
                .find("no triangle lies"),
            std::string::npos);
  EXPECT_NE(text_of(make_octree(box(), "a", {.deadline = Deadline(-1.0)})), "");
  TriangleMesh far = box();
  far.move(Vec3(5000, 0, 0));
  EXPECT_NE(text_of(make_octree(far, "a")).find("leaves the range"), std::string::npos);
}

TEST(MeshOctree, IsAMapWhereverAMapIsRead) {
  const auto path = std::filesystem::path(testing::TempDir()) / "room.stl";
  std::ofstream(path, std::ios::binary) << binary_stl_of(window_room(0.8, 0.8));
  const auto file = read_octree(path);
  ASSERT_TRUE(file) << file.error().text();
  const auto map = DistanceMap::load(path, {.cache = std::filesystem::path(testing::TempDir()) / "fields"});
  ASSERT_TRUE(map) << map.error().text();
  EXPECT_EQ(map->sha256(), file->sha256);
  EXPECT_NEAR(map->resolution(), 0.05, 1e-12);
  EXPECT_GT(map->distance(Vec3(-1, 0, 1.2)), 0.85);
  EXPECT_EQ(map->distance(Vec3(0.05, 1, 1.2)), 0.0);
  EXPECT_GT(map->distance(Vec3(0.05, 0, 1.2)), 0.3);
  EXPECT_LT(map->distance(Vec3(0.05, 0, 1.2)), 0.41);
  // a second time, from the field that is kept
  const auto again = DistanceMap::load(path, {.cache = std::filesystem::path(testing::TempDir()) / "fields"});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->distance(Vec3(-1, 0, 1.2)), map->distance(Vec3(-1, 0, 1.2)));
  // the same bytes under another ending are no map
  const auto other = path.parent_path() / "room.obj";
  std::filesystem::copy_file(path, other, std::filesystem::copy_options::overwrite_existing);
  EXPECT_FALSE(DistanceMap::load(other, {.cache = std::filesystem::path(testing::TempDir()) / "fields"}));
}

}  // namespace
}  // namespace omniflight::planning

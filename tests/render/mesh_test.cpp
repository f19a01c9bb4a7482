#include "render/scene/mesh.h"

#include "render/scene/mesh_preflight.h"
#include "render/scene/mesh_weld.h"
#include "tests/render/scene_fixture.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace opaline {
namespace {

using nlohmann::json;
using test::message_of;
using test::TempFolder;
using test::tetrahedron_obj;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

const double tetrahedron_area = 1.5 + std::sqrt(3.0) / 2;

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

template <typename T>
void append(std::string& bytes, T value, bool big_endian = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

std::string ply_header(const std::string& format) {
  return "ply\nformat " + format +
         " 1.0\ncomment tiny\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 4\nproperty list uchar int vertex_indices\nend_header\n";
}

std::string ascii_ply() {
  return ply_header("ascii") + "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
}

std::string binary_ply(bool big_endian) {
  std::string bytes = ply_header(big_endian ? "binary_big_endian" : "binary_little_endian");
  for (const auto& corner : corners) {
    for (float x : corner) append(bytes, x, big_endian);
  }
  for (const auto& face : faces) {
    append<unsigned char>(bytes, 3);
    for (int i : face) append(bytes, i, big_endian);
  }
  return bytes;
}

/// A tetrahedron under two nodes: one moved by 10 in x, one mirrored in x.
json gltf_document() {
  return json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
    "nodes": [{"mesh": 0, "translation": [10, 0, 0]}, {"mesh": 0, "scale": [-1, 1, 1]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                   "min": [0, 0, 0], "max": [1, 1, 1]},
                  {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48},
                    {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
    "buffers": [{"byteLength": 72}]})");
}

std::string gltf_buffer(int first_index = 0) {
  std::string bytes;
  for (const auto& corner : corners) {
    for (float x : corner) append(bytes, x);
  }
  for (const auto& face : faces) {
    for (int i : face) append(bytes, static_cast<std::uint16_t>(i));
  }
  bytes[48] = static_cast<char>(first_index);
  return bytes;
}

std::string glb(const json& document, const std::string& buffer) {
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string bytes = "glTF";
  append<std::uint32_t>(bytes, 2);
  append(bytes, static_cast<std::uint32_t>(28 + text.size() + buffer.size()));
  append(bytes, static_cast<std::uint32_t>(text.size()));
  bytes += "JSON" + text;
  append(bytes, static_cast<std::uint32_t>(buffer.size()));
  return bytes + std::string("BIN\0", 4) + buffer;
}

std::string binary_stl() {
  std::string bytes(80, 'x');
  append<std::uint32_t>(bytes, 4);
  for (const auto& face : faces) {
    for (int i = 0; i < 3; ++i) append(bytes, 0.0f);
    for (int v : face) {
      for (float x : corners[v]) append(bytes, x);
    }
    append<std::uint16_t>(bytes, 0);
  }
  return bytes;
}

/// Divergence theorem: the enclosed volume, positive when triangles are counter-clockwise outside.
double volume(const Mesh& mesh) {
  double sum = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
    sum += glm::dot(a, glm::cross(b, c)) / 6;
  }
  return sum;
}

class MeshFile : public testing::Test {
 protected:
  Mesh load(const std::string& name, const std::string& bytes) { return load_mesh(folder.write(name, bytes)); }

  /// The error's text after the file's name.
  std::string error(const std::string& name, const std::string& bytes) {
    const std::string path = folder.write(name, bytes);
    const std::string message = message_of([&] { load_mesh(path); });
    EXPECT_THAT(message, StartsWith(path + ": "));
    return message.substr(std::min(message.size(), path.size() + 2));
  }
  TempFolder folder;
};

TEST_F(MeshFile, EveryFormatHoldsTheSameTetrahedron) {
  const std::pair<const char*, std::string> files[] = {{"t.obj", tetrahedron_obj},
                                                       {"t.ply", ascii_ply()},
                                                       {"l.ply", binary_ply(false)},
                                                       {"b.PLY", binary_ply(true)},
                                                       {"t.stl", binary_stl()}};
  for (const auto& [name, bytes] : files) {
    Mesh mesh = load(name, bytes);
    EXPECT_EQ(mesh.triangles.size(), 4u) << name;
    EXPECT_NEAR(surface_area(mesh), tetrahedron_area, 1e-6) << name;
    EXPECT_NEAR(volume(mesh), 1 / 6.0, 1e-7) << name;
    EXPECT_EQ(validate_mesh(mesh, ZeroAreaTriangles::reject, name, ""), 0u) << name;
  }
}

TEST_F(MeshFile, GltfNodesAreMergedInPlaceAndMirrorsKeepTheirOutside) {
  folder.write("t.bin", gltf_buffer());
  json with_uri = gltf_document();
  with_uri["buffers"][0]["uri"] = "t.bin";
  for (const Mesh& mesh : {load("t.glb", glb(gltf_document(), gltf_buffer())), load("t.gltf", with_uri.dump())}) {
    EXPECT_EQ(mesh.triangles.size(), 8u);
    EXPECT_NEAR(volume(mesh), 2 / 6.0, 1e-6);
    float low = 0, high = 0;
    for (const glm::vec3& p : mesh.positions) {
      low = std::min(low, p.x);
      high = std::max(high, p.x);
    }
    EXPECT_EQ(low, -1);
    EXPECT_EQ(high, 11);
  }
}

TEST_F(MeshFile, MissingUnknownEmptyAndFolderAreErrors) {
  EXPECT_EQ(message_of([&] { load_mesh(folder.file("no.obj")); }), folder.file("no.obj") + ": the file does not exist");
  EXPECT_THAT(error("a.xyz", "1 2 3"), EndsWith("valid: .obj, .ply, .gltf, .glb, .stl"));
  for (const char* name : {"e.obj", "e.ply", "e.glb", "e.gltf", "e.stl"}) {
    EXPECT_THAT(error(name, ""), HasSubstr("the mesh is empty")) << name;
  }
  EXPECT_THAT(error("v.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\n"), HasSubstr("the mesh is empty: it has no faces"));
  EXPECT_THAT(error("p.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"),
              HasSubstr("no element \"face\""));
}

TEST_F(MeshFile, ObjNumbersThatAssimpWouldDropAreRead) {
  const Mesh mesh = load("q.obj",
                         "# a square\n\tv -.5 +.5 0\nv .5 .5 0 # right\n  v .5 -.5 0 1 0 0\nv -.5 -.5 -0\n"
                         "g square\nusemtl none\n f 1 4 \\\n 3 -3\n");
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_NEAR(surface_area(mesh), 1, 1e-6);
}

TEST_F(MeshFile, ObjErrorsNameTheLine) {
  const std::string good = tetrahedron_obj;
  EXPECT_THAT(error("a.obj", replaced(good, "v 1 0 0", "v nan 0 0")), StartsWith("line 2: \"nan\" is not a finite"));
  EXPECT_THAT(error("a.obj", replaced(good, "v 1 0 0", "v 1e60 0 0")), StartsWith("line 2: \"1e60\" is not a finite"));
  EXPECT_THAT(error("a.obj", replaced(good, "v 1 0 0", "v 1e999 0 0")),
              StartsWith("line 2: \"1e999\" is not a finite"));
  EXPECT_THAT(error("a.obj", replaced(good, "v 1 0 0", "v one 0 0")), StartsWith("line 2: \"one\" is not a number"));
  EXPECT_THAT(error("a.obj", replaced(good, "v 1 0 0", "v 1 0")), StartsWith("line 2: \"v\" needs 3 numbers"));
  EXPECT_THAT(error("a.obj", replaced(good, "f 1 2 4", "f 1 2 9")),
              StartsWith("line 6: the face names vertex 9, but there are 4"));
  EXPECT_THAT(error("a.obj", replaced(good, "f 1 2 4", "f 1 2 -5")), StartsWith("line 6: the face names vertex -5"));
  EXPECT_THAT(error("a.obj", replaced(good, "f 1 2 4", "f 0 2 4")), StartsWith("line 6: \"0\" is not a vertex number"));
  EXPECT_THAT(error("a.obj", replaced(good, "f 1 2 4", "f 1/1 2/1 4/1")), HasSubstr("names texture vertex 1"));
  EXPECT_THAT(error("a.obj", replaced(good, "f 1 2 4", "f 1 2")), StartsWith("line 6: a face needs at least 3"));
  EXPECT_THAT(error("a.obj", good + "hello\n"), StartsWith("line 9: unknown OBJ statement \"hello\""));
  EXPECT_THAT(error("a.obj", std::string("\x01\x02\x03 1 2\n")), StartsWith("line 1: unknown OBJ statement \"???\""));
}

TEST_F(MeshFile, CutPlyIsAnErrorAtEveryLength) {
  for (const std::string& bytes : {ascii_ply(), binary_ply(false), binary_ply(true)}) {
    // Two bytes fewer: an ascii file may lack its last newline, but not its last number.
    for (std::size_t size = 1; size + 2 <= bytes.size(); ++size) {
      error("cut.ply", bytes.substr(0, size));
      if (HasFailure()) FAIL() << "cut to " << size << " of " << bytes.size() << " bytes";
    }
  }
  EXPECT_THAT(error("cut.ply", binary_ply(false).substr(0, binary_ply(false).size() - 1)),
              HasSubstr("the file ends early: in face 3 of 4"));
}

TEST_F(MeshFile, BadPlyIsAnError) {
  EXPECT_THAT(error("a.ply", replaced(ascii_ply(), "1 0 0", "nan 0 0")), StartsWith("vertex 1: its position is NaN"));
  EXPECT_THAT(error("a.ply", replaced(ascii_ply(), "1 0 0", "x 0 0")), StartsWith("line 12: \"x\" is not a number"));
  EXPECT_THAT(error("a.ply", replaced(ascii_ply(), "3 1 2 3", "3 1 2 7")),
              StartsWith("face 2: names vertex 7, but there are 4"));
  EXPECT_THAT(error("a.ply", replaced(ascii_ply(), "3 1 2 3", "3 1 2 3 4")), HasSubstr("more numbers than a face has"));
  EXPECT_THAT(error("a.ply", replaced(ascii_ply(), "ascii", "text")), HasSubstr("valid: ascii, binary_little_endian"));
  EXPECT_THAT(error("a.ply", replaced(ascii_ply(), "float x", "real x")), StartsWith("line 5: a property needs"));
}

TEST_F(MeshFile, CutGlbIsAnErrorAtEveryLength) {
  const std::string bytes = glb(gltf_document(), gltf_buffer());
  for (std::size_t size = 1; size < bytes.size(); size += 3) {
    error("cut.glb", bytes.substr(0, size));
    if (HasFailure()) FAIL() << "cut to " << size << " of " << bytes.size() << " bytes";
  }
  EXPECT_THAT(error("cut.glb", bytes.substr(0, bytes.size() - 1)), HasSubstr("the file ends early"));
}

TEST_F(MeshFile, BadGltfIsAnError) {
  EXPECT_THAT(error("bad.glb", glb(gltf_document(), gltf_buffer(9))),
              StartsWith("1 of 4 triangles name vertices that do not exist"));
  EXPECT_THAT(error("cut.gltf", gltf_document().dump().substr(0, 200)), HasSubstr("malformed or ends early"));
  json absent = gltf_document();
  absent["buffers"][0]["uri"] = "absent.bin";
  EXPECT_THAT(error("a.gltf", absent.dump()), HasSubstr("absent.bin"));
  folder.write("short.bin", gltf_buffer().substr(0, 40));
  absent["buffers"][0]["uri"] = "short.bin";
  EXPECT_THAT(error("s.gltf", absent.dump()), StartsWith("cannot be read as a mesh: "));
}

TEST_F(MeshFile, CutStlIsAnError) {
  EXPECT_THAT(error("cut.stl", binary_stl().substr(0, 270)), HasSubstr("it has 270 of 284 bytes"));
  EXPECT_THAT(error("cut.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"),
              HasSubstr("endsolid"));
}

TEST_F(MeshFile, ZeroAreaTrianglesFollowThePolicy) {
  const std::string text = std::string(tetrahedron_obj) + "v 2 0 0\nf 1 1 2\nf 1 2 5\n";
  Mesh mesh = load("z.obj", text);
  ASSERT_EQ(mesh.triangles.size(), 6u);
  EXPECT_EQ(message_of([&] { validate_mesh(mesh, ZeroAreaTriangles::reject, "z.obj", "/objects/0"); }),
            "z.obj: /objects/0: 2 triangles (the first: 4, counted from 0) with zero area; mend the mesh, or set "
            "\"zero_area_triangles\": \"drop\"");
  EXPECT_EQ(validate_mesh(mesh, ZeroAreaTriangles::drop, "z.obj", ""), 2u);
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_NEAR(surface_area(mesh), tetrahedron_area, 1e-6);
  for (const glm::vec3& p : mesh.positions) EXPECT_LE(p.x, 1);  // the vertex at x = 2 went with them
  EXPECT_EQ(mesh.normals.size(), mesh.positions.size());
}

TEST(ValidateMesh, NamesWhatIsWrongAndWhere) {
  const Mesh good = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}, {}, {{0, 1, 2}}};
  const auto problem = [](Mesh mesh) {
    return message_of([&] { validate_mesh(mesh, ZeroAreaTriangles::reject, "m", "p"); });
  };
  EXPECT_EQ(problem({}), "m: p: the mesh is empty: it has no triangles");
  Mesh bad = good;
  bad.positions[1].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(problem(bad), HasSubstr("the position of 1 vertex (the first: 1, counted from 0) is NaN or infinite"));
  bad = good;
  bad.triangles[0].z = 3;
  EXPECT_THAT(problem(bad), HasSubstr("name vertices that do not exist; there are 3"));
  bad = good;
  bad.normals.resize(2);
  EXPECT_THAT(problem(bad), HasSubstr("one normal and one uv for each vertex"));
  bad = good;
  bad.triangles[0].z = 1;
  EXPECT_THAT(message_of([&] { validate_mesh(bad, ZeroAreaTriangles::drop, "m", "p"); }),
              HasSubstr("all its triangles have zero area"));
}

TEST(ValidateMesh, ZeroAreaIsRelativeToTheMesh) {
  for (float scale : {1e-6f, 1.0f, 1e6f}) {
    Mesh mesh = {{{0, 0, 0}, {scale, 0, 0}, {0, scale, 0}}, {}, {}, {{0, 1, 2}}};
    EXPECT_EQ(validate_mesh(mesh, ZeroAreaTriangles::reject, "m", ""), 0u) << scale;
  }
}

/// A prism around z with n sides and no caps.
TriangleSoup prism(int n) {
  TriangleSoup soup;
  const auto at = [&](int i, float z) {
    const double angle = 2 * M_PI * (i % n) / n;
    return glm::vec3(std::cos(angle), std::sin(angle), z);
  };
  for (int i = 0; i < n; ++i) {
    for (const glm::vec3& p : {at(i, 0), at(i + 1, 0), at(i + 1, 1), at(i, 0), at(i + 1, 1), at(i, 1)}) {
      soup.positions.push_back(p);
    }
  }
  return soup;
}

TEST(WeldSoup, SmoothsEdgesFlatterThanTheCreaseOnly) {
  const Mesh round = weld_soup(prism(12), 60);  // 30 degrees an edge
  EXPECT_EQ(round.positions.size(), 24u);
  for (std::size_t i = 0; i < round.positions.size(); ++i) {
    const glm::vec3 p = round.positions[i];
    EXPECT_NEAR(glm::distance(round.normals[i], glm::vec3(p.x, p.y, 0)), 0, 1e-6);
  }
  const Mesh sharp = weld_soup(prism(4), 60);  // 90 degrees: every side keeps its own four vertices
  EXPECT_EQ(sharp.positions.size(), 16u);
  for (const glm::uvec3& t : sharp.triangles) {
    const glm::vec3 a = sharp.positions[t.x], b = sharp.positions[t.y], c = sharp.positions[t.z];
    const glm::vec3 face = glm::normalize(glm::cross(b - a, c - a));
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(glm::distance(sharp.normals[t[k]], face), 0, 1e-6);
  }
}

TEST(WeldSoup, UvSeamsStayApartButDoNotStopSmoothing) {
  TriangleSoup soup = prism(12);
  for (std::size_t c = 0; c < soup.positions.size(); ++c) soup.uvs.push_back({static_cast<float>(c / 6), 0});
  const Mesh mesh = weld_soup(soup, 60);
  EXPECT_EQ(mesh.positions.size(), 48u);  // each vertex belongs to two sides with their own uv
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::vec3 p = mesh.positions[i];
    EXPECT_NEAR(glm::distance(mesh.normals[i], glm::vec3(p.x, p.y, 0)), 0, 1e-6);
  }
}

TEST(WeldSoup, GivenNormalsAreKeptAndNormalised) {
  TriangleSoup soup = prism(4);
  soup.normals.assign(soup.positions.size(), {0, 0, 3});
  soup.normals[0] = {0, 0, 0};  // none given for this corner
  const Mesh mesh = weld_soup(soup, 60);
  EXPECT_EQ(mesh.normals[mesh.triangles[0].y], glm::vec3(0, 0, 1));
  const glm::vec3 smoothed = mesh.normals[mesh.triangles[0].x];
  EXPECT_NEAR(glm::distance(smoothed, glm::vec3(std::sqrt(0.5f), std::sqrt(0.5f), 0)), 0, 1e-6);
}

}  // namespace
}  // namespace opaline

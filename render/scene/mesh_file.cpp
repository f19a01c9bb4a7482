// load_mesh (declared in mesh.h): checks the file's bytes, lets assimp parse and triangulate, then
// joins vertices and smooths normals itself. Assimp's own joining merges vertices closer than 1e-5
// in whatever unit, and its smoothing stops at uv seams.
#include "render/file.h"
#include "render/input_error.h"
#include "render/scene/mesh.h"
#include "render/scene/mesh_preflight.h"
#include "render/scene/mesh_weld.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

namespace opaline {
namespace {

constexpr double crease_deg = 60;

std::string extension_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

/// Faces of `scene` that have at least three corners, and the triangles they fall into.
struct FaceCount {
  std::size_t faces = 0, triangles = 0;
};

FaceCount count_faces(const aiScene& scene) {
  FaceCount count;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    for (unsigned f = 0; f < scene.mMeshes[m]->mNumFaces; ++f) {
      const unsigned corners = scene.mMeshes[m]->mFaces[f].mNumIndices;
      if (corners < 3) continue;
      count.faces += 1;
      count.triangles += corners - 2;
    }
  }
  return count;
}

/// Triangulation would read past the vertices, so this comes first.
void check_face_indices(const aiMesh& mesh, const std::string& path) {
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    for (unsigned i = 0; i < mesh.mFaces[f].mNumIndices; ++i) {
      const unsigned vertex = mesh.mFaces[f].mIndices[i];
      if (vertex < mesh.mNumVertices) continue;
      throw InputError(path, "face " + std::to_string(f),
                       "names vertex " + std::to_string(vertex) + ", but there are " +
                           std::to_string(mesh.mNumVertices) + " (both counted from 0)");
    }
  }
}

/// Here the numbers of the vertices are still the file's own.
void check_finite(const aiMesh& mesh, const std::string& path) {
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
    const aiVector3D& p = mesh.mVertices[v];
    if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) continue;
    throw InputError(path, "vertex " + std::to_string(v), "its position is NaN or infinite (counted from 0)");
  }
}

[[noreturn]] void throw_unreadable(const Assimp::Importer& importer, const std::string& path) {
  throw InputError(path, "", std::string("cannot be read as a mesh: ") + importer.GetErrorString());
}

/// The checked file in assimp's memory, faces not yet triangulated.
const aiScene& import_file(Assimp::Importer& importer, const std::string& path) {
  const std::string extension = extension_of(path), bytes = read_file(path);
  if (bytes.empty()) throw InputError(path, "", "the mesh is empty: the file has no bytes");
  std::size_t promised = 0;
  const aiScene* scene = nullptr;
  if (extension == ".obj") {
    const std::string clean = clean_obj(bytes, path);
    if (clean.find("f ") == std::string::npos) throw InputError(path, "", "the mesh is empty: it has no faces (f)");
    scene = importer.ReadFileFromMemory(clean.data(), clean.size(), 0, "obj");
  } else {
    if (extension == ".ply") check_ply(bytes, path);
    if (extension == ".stl") check_stl(bytes, path);
    if (extension == ".gltf" || extension == ".glb") promised = check_gltf(bytes, path);
    scene = importer.ReadFile(path, 0);
  }
  if (scene == nullptr || scene->mRootNode == nullptr) throw_unreadable(importer, path);
  const std::size_t triangles = count_faces(*scene).triangles;
  if (triangles < promised) {
    throw InputError(path, "",
                     std::to_string(promised - triangles) + " of " + std::to_string(promised) +
                         " triangles name vertices that do not exist");
  }
  return *scene;
}

const aiScene& import_triangles(Assimp::Importer& importer, const std::string& path) {
  const aiScene& polygons = import_file(importer, path);
  for (unsigned m = 0; m < polygons.mNumMeshes; ++m) {
    check_face_indices(*polygons.mMeshes[m], path);
    check_finite(*polygons.mMeshes[m], path);
  }
  const std::size_t expected = count_faces(polygons).triangles;
  const aiScene* scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr) throw_unreadable(importer, path);
  if (count_faces(*scene).faces != expected) {
    throw InputError(path, "",
                     "has polygons that cross themselves and cannot be split into triangles; " +
                         std::string("triangulate the mesh where it was made"));
  }
  return *scene;
}

glm::dmat4 to_glm(const aiMatrix4x4& m) {
  return glm::transpose(
      glm::dmat4(m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3, m.d4));
}

/// Appends the meshes of a file, corner by corner, in the file's world frame.
class SoupBuilder {
 public:
  explicit SoupBuilder(const aiScene& scene) : scene_(scene) {
    for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
      has_normals_ |= scene.mMeshes[m]->HasNormals();
      has_uvs_ |= scene.mMeshes[m]->HasTextureCoords(0);
    }
  }

  void add(const aiNode& node, const glm::dmat4& parent) {
    const glm::dmat4 to_world = parent * to_glm(node.mTransformation);
    for (unsigned m = 0; m < node.mNumMeshes; ++m) add(*scene_.mMeshes[node.mMeshes[m]], to_world);
    for (unsigned c = 0; c < node.mNumChildren; ++c) add(*node.mChildren[c], to_world);
  }

  TriangleSoup soup;

 private:
  void add(const aiMesh& mesh, const glm::dmat4& to_world) {
    const glm::dmat3 linear(to_world);
    const double determinant = glm::determinant(linear);
    // A flattened node has no normal matrix; zero normals mean "none given".
    const glm::dmat3 to_normal = determinant == 0 ? glm::dmat3(0) : glm::transpose(glm::inverse(linear));
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines
      const bool mirrored = determinant < 0;
      for (unsigned i : {0u, mirrored ? 2u : 1u, mirrored ? 1u : 2u}) add(mesh, face.mIndices[i], to_world, to_normal);
    }
  }

  void add(const aiMesh& mesh, unsigned v, const glm::dmat4& to_world, const glm::dmat3& to_normal) {
    const auto vec = [](const aiVector3D& a) { return glm::dvec3(a.x, a.y, a.z); };
    soup.positions.emplace_back(to_world * glm::dvec4(vec(mesh.mVertices[v]), 1));
    if (has_normals_) {
      soup.normals.emplace_back(mesh.HasNormals() ? to_normal * vec(mesh.mNormals[v]) : glm::dvec3(0));
    }
    if (has_uvs_) {
      soup.uvs.emplace_back(mesh.HasTextureCoords(0) ? glm::dvec2(vec(mesh.mTextureCoords[0][v])) : glm::dvec2(0));
    }
  }

  const aiScene& scene_;
  bool has_normals_ = false, has_uvs_ = false;
};

void check_extension(const std::string& path) {
  const std::string extension = extension_of(path);
  for (const char* valid : {".obj", ".ply", ".gltf", ".glb", ".stl"}) {
    if (extension == valid) return;
  }
  throw InputError(path, "", "unknown mesh format \"" + extension + "\"; valid: .obj, .ply, .gltf, .glb, .stl");
}

}  // namespace

Mesh load_mesh(const std::string& path) {
  check_extension(path);
  Assimp::Importer importer;
  const aiScene& scene = import_triangles(importer, path);
  SoupBuilder builder(scene);
  builder.add(*scene.mRootNode, glm::dmat4(1));
  Mesh mesh = weld_soup(builder.soup, crease_deg);
  if (mesh.triangles.empty()) throw InputError(path, "", "the mesh is empty: it has no triangles");
  return mesh;
}

}  // namespace opaline

// Checks of a mesh file's bytes before assimp sees them. Assimp 5.2 drops OBJ vertices that it
// can't parse (".5", an indented "v"), reads past the end of a PLY that is cut (a crash, or the
// last face over and over), and drops glTF triangles with bad indices. Each is an InputError here.
#pragma once

#include <cstddef>
#include <string>

namespace opaline {

/// The geometry of an OBJ (v, vt, vn, f) in a form that assimp reads without loss: one statement a
/// line, no comments, no continuation lines, numbers with a digit before the point. Throws
/// InputError with the line for an unknown statement, a number that is none or not finite, a face
/// of fewer than three vertices, or a reference to a vertex that the file doesn't have.
std::string clean_obj(const std::string& text, const std::string& path);

/// Walks a PLY (ascii or binary) from header to end. Throws InputError for a bad header, elements
/// the file ends before, ascii numbers that are none, or a file without vertices or faces.
void check_ply(const std::string& bytes, const std::string& path);

/// Throws InputError when an STL is cut: a binary one shorter than its triangle count, an ascii
/// one without "endsolid".
void check_stl(const std::string& bytes, const std::string& path);

/// Checks a .glb's length against its header and returns how many triangles the accessors of a
/// .gltf or .glb promise; 0 when that can't be told.
std::size_t check_gltf(const std::string& bytes, const std::string& path);

}  // namespace opaline

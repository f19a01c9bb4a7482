// Shapes by formula, and the library of them that scenes are loaded against.
//
// Every shape is closed and consistently oriented (counter-clockwise seen from outside), every edge
// is shared by exactly two triangles, no triangle has zero area, and the vertex normals are unit
// and point outwards. Lengths are in the caller's units. `triangles` is a wish: the count that
// comes out is within a factor 2 of it, or the shape's smallest count where that is larger.
// Arguments out of range trip a check; the JSON rows validate them first and throw InputError.
#pragma once

#include "render/scene/mesh.h"
#include "render/scene/shapes.h"

namespace opaline {

/// All shapes, by the name a scene uses. Every row reads an optional integer key "triangles".
const ShapeLibrary& synthetic_shapes();

/// Largest `triangles` a row accepts (the bust's takes 2 million).
inline constexpr int max_shape_triangles = 20'000'000;

// --- sphere {"radius"} ---------------------------------------------------------------------------
/// Sphere centred at the origin: an icosahedron whose faces are divided into f^2 triangles, placed
/// so that their areas are nearly equal (largest / smallest < 1.6). Vertices lie on the sphere, so
/// volume and area come out small by O(1/triangles). Normals are the sphere's. 20 f^2 triangles.
Mesh make_sphere(double radius, int triangles = 20000);

// --- slab {"size": [x, y, z]} --------------------------------------------------------------------
/// Box centred in x and y whose lit face is +z, with its top at z = 0 and its bottom at -size.z.
/// Regular grid of nearly square cells. Edges are hard: a vertex on an edge or a corner is repeated
/// with each face's normal, at the very same position, so the box is watertight by position (the
/// other shapes are welded by index, except at the teapot's creases).
Mesh make_slab(glm::dvec3 size, int triangles = 20000);

// --- torus {"major_radius", "minor_radius"} ------------------------------------------------------
/// Torus about the z axis, centred at the origin; 0 < minor_radius < major_radius. Vertices lie on
/// the torus, normals are its own. Cells are nearly square where the torus is major_radius wide.
Mesh make_torus(double major_radius, double minor_radius, int triangles = 20000);

// --- teapot {"height"} ---------------------------------------------------------------------------
/// Newell's teapot (M. Newell, The Utilization of Procedure Models in Digital Image Synthesis, 1975,
/// in the customary proportions, 1.3 times lower than his): its 32 bicubic Bezier patches, with
/// +y up and the spout towards +x; the axis of the body is the y axis and y runs over
/// [-height / 2, height / 2]. The width in x is 2.04 heights, the depth in z 1.27.
/// Three closed parts: the body with its lid, the handle and the spout. Handle and spout enter the
/// body, as in the original. Where the original is open it is closed flat: the slit between lid
/// and rim, the ends of the handle, and the two ends of the spout. Those creases are watertight by
/// position, with the normals of both sides. Normals are those of the patches, at poles the axis.
Mesh make_teapot(double height, int triangles = 20000);

// --- bust {"height"} -----------------------------------------------------------------------------
/// Head, neck and shoulders, facing +z, +y up; y runs over [-height / 2, height / 2], symmetric
/// in x. Thin ears that stand out, a sharp nose, eye sockets. One closed part of genus 0.
/// The surface is the zero set of a field built of smooth unions (bust_field.h); vertices lie on it
/// to 1e-4 of the height and normals are its gradient. Triangles are smaller where it bends. Any
/// count keeps the ears whole; from 20000 on they are as thick as stated to 10 %, and from 50000 on
/// every normal agrees with its triangles (below that a few at the rims of the ears do not). Takes
/// about 0.7 s for 60000 triangles, and hardly less for fewer.
Mesh make_bust(double height, int triangles = 60000);

// --- fish {"length"} -----------------------------------------------------------------------------
/// Along x from -length / 2 (end of the tail) to length / 2 (nose), back towards +y, symmetric in z, near y = 0 at its
/// middle. Thin tail, dorsal and anal fins: the tail is 1.7 % of the length thick in its middle. One closed part of
/// genus 0, of rings round the axis.
Mesh make_fish(double length, int triangles = 4000);

/// A place on the bust's left ear (x > 0) where it is a thin plate: what to light from behind.
struct EarPlate {
  glm::dvec3 centre;  ///< middle of the plate
  glm::dvec3 normal;  ///< across the plate, unit, forwards and outwards
  double thickness;   ///< along the normal: 1.2 % of the height
};
EarPlate bust_ear_plate(double height);

}  // namespace opaline

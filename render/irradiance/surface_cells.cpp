#include "render/irradiance/surface_cells.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

struct HeapEntry {
  float area;
  std::uint32_t cell;
  // Equal areas are ordered by index, so that the result does not depend on the heap's inner order.
  bool operator<(const HeapEntry& other) const { return area != other.area ? area < other.area : cell > other.cell; }
};

/// Keeps one half of the cell across its longest edge and returns the other.
SurfaceCell bisect(SurfaceCell& cell) {
  const float ab = glm::dot(cell.b - cell.a, cell.b - cell.a), bc = glm::dot(cell.c - cell.b, cell.c - cell.b),
              ca = glm::dot(cell.a - cell.c, cell.a - cell.c);
  // Turn the triangle so that its longest edge is ab.
  if (bc >= ab && bc >= ca) {
    cell = {cell.b, cell.c, cell.a, cell.triangle};
  } else if (ca >= ab && ca >= bc) {
    cell = {cell.c, cell.a, cell.b, cell.triangle};
  }
  const glm::vec3 middle = 0.5f * (cell.a + cell.b);
  const SurfaceCell other{middle, cell.b, cell.c, cell.triangle};
  cell.b = middle;
  return other;
}

}  // namespace

SurfaceCells make_surface_cells(const Mesh& mesh, std::size_t count) {
  SurfaceCells cells;
  cells.reserve(std::max(count, mesh.triangles.size()));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3 i = mesh.triangles[t];
    cells.push_back({mesh.positions[i.x], mesh.positions[i.y], mesh.positions[i.z], static_cast<std::uint32_t>(t)});
  }
  std::vector<HeapEntry> heap;
  heap.reserve(cells.capacity());
  for (std::size_t i = 0; i < cells.size(); ++i) heap.push_back({cell_area(cells[i]), static_cast<std::uint32_t>(i)});
  std::make_heap(heap.begin(), heap.end());
  while (cells.size() < count) {
    std::pop_heap(heap.begin(), heap.end());
    const std::uint32_t largest = heap.back().cell;
    const SurfaceCell other = bisect(cells[largest]);
    heap.back() = {cell_area(cells[largest]), largest};
    std::push_heap(heap.begin(), heap.end());
    heap.push_back({cell_area(other), static_cast<std::uint32_t>(cells.size())});
    std::push_heap(heap.begin(), heap.end());
    cells.push_back(other);
  }
  return cells;
}

std::vector<SurfaceCells> make_surface_cells(const Scene& scene, std::size_t total) {
  std::vector<double> areas;
  double sum = 0;
  for (const Object& object : scene.objects) sum += areas.emplace_back(surface_area(object.mesh));
  std::vector<SurfaceCells> result;
  for (std::size_t i = 0; i < areas.size(); ++i) {
    const double share = static_cast<double>(total) * areas[i] / sum;
    result.push_back(make_surface_cells(scene.objects[i].mesh, static_cast<std::size_t>(std::lround(share))));
  }
  return result;
}

void split_in_four(const SurfaceCell& cell, SurfaceCell quarters[4]) {
  const glm::vec3 ab = 0.5f * (cell.a + cell.b), bc = 0.5f * (cell.b + cell.c), ca = 0.5f * (cell.c + cell.a);
  quarters[0] = {cell.a, ab, ca, cell.triangle};
  quarters[1] = {ab, cell.b, bc, cell.triangle};
  quarters[2] = {ca, bc, cell.c, cell.triangle};
  quarters[3] = {bc, ca, ab, cell.triangle};
}

}  // namespace opaline

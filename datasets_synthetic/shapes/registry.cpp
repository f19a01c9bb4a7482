#include "datasets_synthetic/shapes/shapes.h"

namespace opaline {

#define OPALINE_ROW(name) ShapeMaker name##_shape();
#include "shape_registry.inc"
#undef OPALINE_ROW

const ShapeLibrary& synthetic_shapes() {
  static const ShapeLibrary library{
#define OPALINE_ROW(name) {#name, name##_shape()},
#include "shape_registry.inc"
#undef OPALINE_ROW
  };
  return library;
}

}  // namespace opaline

# cmake -D ROOT=DIR -D SHADERS="a.comp;b.glsl" -D OUTPUT=shaders.inc -P embed_shaders.cmake
# Writes one initialiser {"path from ROOT", "text"} per shader, in the order of their paths.
list(SORT SHADERS)
set(rows "// Generated from the shaders of render/.\n")
foreach(shader IN LISTS SHADERS)
  file(RELATIVE_PATH name "${ROOT}" "${shader}")
  file(READ "${shader}" text)
  string(APPEND rows "{\"${name}\", R\"glsl(${text})glsl\"},\n")
endforeach()
file(WRITE "${OUTPUT}" "${rows}")

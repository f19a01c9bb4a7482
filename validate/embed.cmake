# cmake -D FILES="a.json;b.json" -D OUTPUT=all.inc -P embed.cmake
# Writes one initialiser {"name", "text"} per file, in their order.
set(rows "// Generated from JSON files.\n")
foreach(file IN LISTS FILES)
  cmake_path(GET file STEM name)
  file(READ "${file}" text)
  string(APPEND rows "{\"${name}\", R\"embedded(${text})embedded\"},\n")
endforeach()
file(WRITE "${OUTPUT}" "${rows}")

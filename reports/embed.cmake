# cmake -D FILES="a.js;b.css" -D OUTPUT=page.inc -P embed.cmake
# Writes one initialiser {"name", "text"} per file. A file's name keeps its ending unless STEM is set.
set(rows "// Generated.\n")
foreach(file IN LISTS FILES)
  cmake_path(GET file FILENAME name)
  if(STEM)
    cmake_path(GET file STEM name)
  endif()
  file(READ "${file}" text)
  string(APPEND rows "{\"${name}\", R\"embedded(${text})embedded\"},\n")
endforeach()
file(WRITE "${OUTPUT}" "${rows}")

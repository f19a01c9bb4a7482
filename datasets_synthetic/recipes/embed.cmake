# cmake -D RECIPES="a.json;b.json" -D OUTPUT=recipes.inc -P embed.cmake
# Writes one initialiser {"name", "text"} per recipe, in the order of their names.
list(SORT RECIPES)
set(rows "// Generated from recipes/*.json.\n")
foreach(recipe IN LISTS RECIPES)
  cmake_path(GET recipe STEM name)
  file(READ "${recipe}" text)
  string(APPEND rows "{\"${name}\", R\"recipe(${text})recipe\"},\n")
endforeach()
file(WRITE "${OUTPUT}" "${rows}")

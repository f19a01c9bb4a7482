# Warnings, optimisation and coverage as INTERFACE targets; library and registry helpers.

# -Wno-restrict: GCC 12 warns falsely inside std::string at -O3 (its bug 105651).
add_library(opaline_options INTERFACE)
target_compile_options(opaline_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Wcast-qual -Wconversion -Wno-sign-conversion
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  -fno-math-errno -fno-trapping-math
  $<$<BOOL:${OPALINE_WERROR}>:-Werror>)
if(OPALINE_COVERAGE)
  target_compile_options(opaline_options INTERFACE --coverage -O1 -g)
  target_link_options(opaline_options INTERFACE --coverage)
endif()

# opaline_library(NAME SOURCES...): static library opaline_NAME, alias opaline::NAME.
function(opaline_library name)
  add_library(opaline_${name} STATIC ${ARGN})
  add_library(opaline::${name} ALIAS opaline_${name})
  set_target_properties(opaline_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(opaline_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                    $<INSTALL_INTERFACE:include/opaline>)
  target_link_libraries(opaline_${name} PRIVATE $<BUILD_INTERFACE:opaline_options>)
endfunction()

# opaline_registry(TARGET KIND NAMES...): one line per entry. Adds NAME.cpp to TARGET and writes
# KIND_registry.inc with OPALINE_ROW(NAME) for each, which KIND's registry.cpp expands.
function(opaline_registry target kind)
  set(rows "")
  foreach(name IN LISTS ARGN)
    target_sources(${target} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/${name}.cpp)
    string(APPEND rows "OPALINE_ROW(${name})\n")
  endforeach()
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${kind}_registry.inc CONTENT "${rows}" @ONLY)
  target_include_directories(${target} PRIVATE $<BUILD_INTERFACE:${CMAKE_CURRENT_BINARY_DIR}>)
endfunction()

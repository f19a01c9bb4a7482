# The GL layer of opaline_render. Nothing links to a GL library: they are opened at run time.
# Included, not a subdirectory: a rule for a generated file serves only targets of its own directory.
target_sources(opaline_render PRIVATE
  gl/clip_matrix.cpp
  gl/context.cpp
  gl/platform_egl.cpp
  gl/platform_osmesa.cpp
  gl/program.cpp
  gl/profile_family.cpp
  gl/profile_texture.cpp
  gl/resources.cpp
  gl/shadow_irradiance.cpp
  gl/glad/src/gl.c)
# Generated C that is C++ as well; its warnings are not ours.
set_source_files_properties(gl/glad/src/gl.c PROPERTIES LANGUAGE CXX COMPILE_OPTIONS "-w")
target_include_directories(opaline_render SYSTEM PUBLIC
                           $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/gl/glad/include>)
target_link_libraries(opaline_render PRIVATE ${CMAKE_DL_LIBS})

# Every shader beside the code that runs it is built in.
file(GLOB_RECURSE shaders CONFIGURE_DEPENDS *.vert *.frag *.comp *.glsl)
set(embed ${CMAKE_CURRENT_SOURCE_DIR}/gl/embed_shaders.cmake)
set(shaders_inc ${CMAKE_CURRENT_BINARY_DIR}/gl/shaders.inc)
add_custom_command(OUTPUT ${shaders_inc}
                   COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} "-DSHADERS=${shaders}" -DOUTPUT=${shaders_inc}
                           -P ${embed}
                   DEPENDS ${shaders} ${embed} VERBATIM)
target_sources(opaline_render PRIVATE ${shaders_inc})
target_include_directories(opaline_render PRIVATE $<BUILD_INTERFACE:${CMAKE_CURRENT_BINARY_DIR}/gl>)

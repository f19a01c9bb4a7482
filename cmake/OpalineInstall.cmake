# Installation: binary, static libraries, their headers, the scene schema, and a CMake package, so
# that find_package(opaline) gives opaline::model, opaline::render, opaline::fit, opaline::datasets.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(OPALINE_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/opaline)

install(TARGETS opaline RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
# opaline_library() gives each its export name and the include folder include/opaline.
install(TARGETS opaline_model opaline_render opaline_fit opaline_datasets
        EXPORT opalineTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})

# Folder by folder, because installing by pattern would also make a folder for every one without headers.
file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}
     model/*.h render/*.h fit/*.h datasets_synthetic/*.h)
list(FILTER headers EXCLUDE REGEX "/cmd/|/glad/")
foreach(header IN LISTS headers)
  cmake_path(GET header PARENT_PATH folder)
  install(FILES ${header} DESTINATION include/opaline/${folder})
endforeach()

install(FILES render/scene/scene.schema.json validate/suites/suite.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/opaline)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

install(EXPORT opalineTargets NAMESPACE opaline:: DESTINATION ${OPALINE_PACKAGE_DIR})
configure_package_config_file(cmake/opalineConfig.cmake.in opalineConfig.cmake
                              INSTALL_DESTINATION ${OPALINE_PACKAGE_DIR})
# Before 1.0 a minor version may break its callers.
write_basic_package_version_file(opalineConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/opalineConfig.cmake ${PROJECT_BINARY_DIR}/opalineConfigVersion.cmake
        DESTINATION ${OPALINE_PACKAGE_DIR})

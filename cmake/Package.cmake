# Installation, and the package that authors of nodes build against: find_package(weft) gives
# weft::runtime (how nodes are written) and weft::types (Samples, Image and the other data).
include(CMakePackageConfigHelpers)
set(weft_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/weft)

foreach(name graph runtime types)
    set_target_properties(weft_${name} PROPERTIES EXPORT_NAME ${name} VERSION ${PROJECT_VERSION}
                          SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
                          INSTALL_RPATH "$ORIGIN")
    target_include_directories(weft_${name} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/weft>)
    add_library(weft::${name} ALIAS weft_${name})
endforeach()
target_compile_features(weft_graph PUBLIC cxx_std_20)

install(TARGETS weft_graph weft_runtime weft_types EXPORT weft-targets)
install(TARGETS weft)
install(EXPORT weft-targets NAMESPACE weft:: DESTINATION ${weft_cmake_dir})
install(DIRECTORY graph runtime DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/weft FILES_MATCHING PATTERN "*.h")
# Families' data types lie under their own names: #include "samples/samples.h".
install(DIRECTORY nodes/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/weft FILES_MATCHING PATTERN "*.h"
        PATTERN "*_kernel*.h" EXCLUDE)
install(DIRECTORY graphs DESTINATION ${CMAKE_INSTALL_DATADIR}/weft)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/weft-config-version.cmake COMPATIBILITY SameMinorVersion)
file(WRITE ${CMAKE_BINARY_DIR}/weft-config.cmake "include(CMakeFindDependencyMacro)
find_dependency(Threads)
include(\${CMAKE_CURRENT_LIST_DIR}/weft-targets.cmake)
")
install(FILES ${CMAKE_BINARY_DIR}/weft-config.cmake ${CMAKE_BINARY_DIR}/weft-config-version.cmake
        DESTINATION ${weft_cmake_dir})

# The packages Weft stands on; docs/dependencies.md says why each.
find_package(PkgConfig REQUIRED)
find_package(fmt REQUIRED)
find_package(TBB REQUIRED)
find_package(PNG REQUIRED)
find_package(Threads REQUIRED)
find_package(RapidJSON REQUIRED)
find_package(CLI11 REQUIRED)
set(CMAKE_MESSAGE_LOG_LEVEL_SAVED ${CMAKE_MESSAGE_LOG_LEVEL})
set(CMAKE_MESSAGE_LOG_LEVEL WARNING)  # Debian's Imath tells at length that PyImath is not there
find_package(Imath CONFIG REQUIRED)
find_package(OpenEXR CONFIG REQUIRED)
find_package(OpenImageIO CONFIG REQUIRED)
set(CMAKE_MESSAGE_LOG_LEVEL ${CMAKE_MESSAGE_LOG_LEVEL_SAVED})
# Debian's OpenImageIO names an OpenCV folder that it does not depend on.
get_target_property(weft_oiio_include OpenImageIO::OpenImageIO INTERFACE_INCLUDE_DIRECTORIES)
list(FILTER weft_oiio_include EXCLUDE REGEX opencv)
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES
                      INTERFACE_INCLUDE_DIRECTORIES "${weft_oiio_include}")
pkg_check_modules(OCIO REQUIRED IMPORTED_TARGET OpenColorIO)  # its CMake file is put in the wrong folder
pkg_check_modules(DEFLATE REQUIRED IMPORTED_TARGET libdeflate)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)

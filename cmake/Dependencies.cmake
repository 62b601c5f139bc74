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
set(CMAKE_MESSAGE_LOG_LEVEL ${CMAKE_MESSAGE_LOG_LEVEL_SAVED})
pkg_check_modules(OCIO REQUIRED IMPORTED_TARGET OpenColorIO)  # its CMake file is put in the wrong folder
# Debian's CMake file of OpenImageIO wants its tools (and so Qt) installed, and a folder of OpenCV's.
pkg_check_modules(OIIO REQUIRED IMPORTED_TARGET OpenImageIO)
pkg_check_modules(DEFLATE REQUIRED IMPORTED_TARGET libdeflate)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)
find_package(embree 3.13 CONFIG REQUIRED)
find_package(TinyGLTF CONFIG REQUIRED)
find_package(tinyobjloader CONFIG REQUIRED)

# What the module of image files leans on; who uses the library does not need it to build.
# OpenImageIO's targets list an include directory that Debian does not ship (opencv4): link the library alone.
find_path(TAUT_OIIO_INCLUDE OpenImageIO/imageio.h REQUIRED)
find_library(TAUT_OIIO_LIBRARY OpenImageIO REQUIRED)
find_library(TAUT_OIIO_UTIL_LIBRARY OpenImageIO_Util REQUIRED)
find_path(TAUT_IMATH_INCLUDE ImathVec.h PATH_SUFFIXES Imath REQUIRED)
taut_wrap(taut_openimageio INCLUDE "${TAUT_OIIO_INCLUDE};${TAUT_IMATH_INCLUDE}" LIBRARIES "${TAUT_OIIO_LIBRARY};${TAUT_OIIO_UTIL_LIBRARY}")

# OpenColorIO, which OpenImageIO leans on, so that it is there wherever that is; Debian 12 ships no CMake files for it.
find_path(TAUT_OCIO_INCLUDE OpenColorIO/OpenColorIO.h)
find_library(TAUT_OCIO_LIBRARY OpenColorIO)
if(NOT TAUT_OCIO_INCLUDE OR NOT TAUT_OCIO_LIBRARY)
    message(FATAL_ERROR "OpenColorIO: found none, expected version 2.1 or later with its headers (Debian: libopencolorio-dev)")
endif()
taut_wrap(taut_opencolorio INCLUDE "${TAUT_OCIO_INCLUDE}" LIBRARIES "${TAUT_OCIO_LIBRARY}")

# What the module of image files leans on; who uses the library does not need it to build.
# OpenImageIO's targets list an include directory that Debian does not ship (opencv4): link the library alone.
find_path(TAUT_OIIO_INCLUDE OpenImageIO/imageio.h REQUIRED)
find_library(TAUT_OIIO_LIBRARY OpenImageIO REQUIRED)
find_library(TAUT_OIIO_UTIL_LIBRARY OpenImageIO_Util REQUIRED)
find_path(TAUT_IMATH_INCLUDE ImathVec.h PATH_SUFFIXES Imath REQUIRED)
taut_wrap(taut_openimageio INCLUDE "${TAUT_OIIO_INCLUDE};${TAUT_IMATH_INCLUDE}" LIBRARIES "${TAUT_OIIO_LIBRARY};${TAUT_OIIO_UTIL_LIBRARY}")

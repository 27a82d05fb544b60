# Finds what taut leans on, in Debian 12's packages or 13's; where their CMake files are broken the library is found by hand and
# wrapped in an interface target, so that nothing of the trouble leaks into the rest of the build. Included by the build and, after
# installation, by tautConfig.cmake, which says which Embree the library was built with.

find_package(glm REQUIRED)
find_package(TBB REQUIRED)
find_package(tomlplusplus REQUIRED)
find_path(TAUT_XXHASH_INCLUDE xxhash.h REQUIRED) # its header alone
find_package(nlohmann_json REQUIRED)
find_package(OpenMesh REQUIRED)
foreach(version 3.13 4) # in Debian 12, in Debian 13
    if(NOT embree_FOUND AND (NOT TAUT_EMBREE OR version MATCHES "^${TAUT_EMBREE}"))
        find_package(embree ${version} QUIET)
    endif()
endforeach()
if(NOT embree_FOUND)
    message(FATAL_ERROR "Embree: found none, expected version 3.13 or 4, the one that taut is built with (Debian: libembree-dev)")
endif()
set(TAUT_EMBREE ${EMBREE_VERSION_MAJOR})

# OpenSubdiv's CMake config names a missing static library.
find_path(TAUT_OSD_INCLUDE opensubdiv/far/topologyRefiner.h REQUIRED)
find_library(TAUT_OSD_CPU_LIBRARY osdCPU REQUIRED)

function(taut_wrap name)
    cmake_parse_arguments(ARG "" "" "INCLUDE;LIBRARIES" ${ARGN})
    if(NOT TARGET ${name})
        add_library(${name} INTERFACE IMPORTED GLOBAL)
        set_target_properties(${name} PROPERTIES INTERFACE_LINK_LIBRARIES "${ARG_LIBRARIES}" INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${ARG_INCLUDE}" INTERFACE_INCLUDE_DIRECTORIES "${ARG_INCLUDE}")
    endif()
endfunction()

taut_wrap(taut_opensubdiv INCLUDE "${TAUT_OSD_INCLUDE}" LIBRARIES "${TAUT_OSD_CPU_LIBRARY}")
taut_wrap(taut_openmesh INCLUDE "" LIBRARIES "OpenMeshCore")
taut_wrap(taut_embree INCLUDE "" LIBRARIES "embree")
set_target_properties(taut_embree PROPERTIES INTERFACE_COMPILE_DEFINITIONS TAUT_EMBREE=${TAUT_EMBREE})

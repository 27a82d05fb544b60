# Installs a build to a scratch prefix and uses it from there, as another project would:
#   cmake -D BUILD=build/release -D SCRATCH=folder -D CONSUMER=tests/consumer -D COMPILER=c++ [-D FLAGS=...] -P install_test.cmake
foreach(argument BUILD SCRATCH CONSUMER COMPILER)
    if(NOT ${argument})
        message(FATAL_ERROR "-D ${argument}=... is missing")
    endif()
endforeach()

set(prefix "${SCRATCH}/prefix")
file(REMOVE_RECURSE "${SCRATCH}")

function(run what)
    execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(NOT result EQUAL 0)
        message(FATAL_ERROR "${what} failed (${result}):\n${output}")
    endif()
    set(output "${output}" PARENT_SCOPE)
endfunction()

run("installing" "${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${prefix}")
foreach(file include/taut/microsurface/ggx.h include/taut/render/frame_render.h)
    if(NOT EXISTS "${prefix}/${file}")
        message(FATAL_ERROR "${file} was not installed")
    endif()
endforeach()

run("configuring the consumer" "${CMAKE_COMMAND}" -S "${CONSUMER}" -B "${SCRATCH}/build" "-DCMAKE_PREFIX_PATH=${prefix}"
    "-DCMAKE_CXX_COMPILER=${COMPILER}" "-DCMAKE_CXX_FLAGS=${FLAGS}" -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
file(STRINGS "${SCRATCH}/build/CMakeCache.txt" found REGEX "^taut_DIR:")
if(NOT found MATCHES "${prefix}")
    message(FATAL_ERROR "the consumer found another taut: ${found}")
endif()
run("building the consumer" "${CMAKE_COMMAND}" --build "${SCRATCH}/build")
run("the consumer" "${SCRATCH}/build/consumer")
message(STATUS "${output}")

if(EXISTS "${prefix}/bin/taut")
    run("the installed command" "${prefix}/bin/taut" --version)
    message(STATUS "${output}")
endif()

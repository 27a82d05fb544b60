# CMake finds the package by its folder, compiles what uses it and says so: configures this project once more, without tests and programs.
#   cmake -D SOURCE=... -D SCRATCH=... -D COMPILER=... -P find_test.cmake
foreach(folder "${SOURCE}/tests/oidn" "${SCRATCH}/none")
    file(REMOVE_RECURSE "${SCRATCH}")
    execute_process(COMMAND ${CMAKE_COMMAND} -S "${SOURCE}" -B "${SCRATCH}" -G Ninja -D CMAKE_CXX_COMPILER=${COMPILER}
            -D CMAKE_EXPORT_COMPILE_COMMANDS=ON -D TAUT_BUILD_TESTS=OFF -D TAUT_BUILD_APPS=OFF -D OpenImageDenoise_DIR=${folder}
        RESULT_VARIABLE code OUTPUT_VARIABLE said ERROR_VARIABLE said)
    if(NOT code EQUAL 0)
        message(FATAL_ERROR "configuring failed:\n${said}")
    endif()
    file(READ "${SCRATCH}/compile_commands.json" commands)
    string(FIND "${commands}" "denoise_oidn.cpp" compiled)
    string(FIND "${commands}" "-DTAUT_OPEN_IMAGE_DENOISE" defined)
    if(folder MATCHES "/none$")
        if(NOT compiled EQUAL -1 OR NOT defined EQUAL -1)
            message(FATAL_ERROR "without the package denoise_oidn.cpp is compiled all the same")
        endif()
    elseif(compiled EQUAL -1 OR defined EQUAL -1)
        message(FATAL_ERROR "with the package in ${folder} denoise_oidn.cpp is not compiled")
    endif()
endforeach()

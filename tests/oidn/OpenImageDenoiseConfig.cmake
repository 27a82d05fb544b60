# The stand-in as CMake finds the library: the target OpenImageDenoise, as that of its releases.
if(NOT TARGET OpenImageDenoise)
    add_library(OpenImageDenoise STATIC "${CMAKE_CURRENT_LIST_DIR}/oidn.cpp")
    target_include_directories(OpenImageDenoise PUBLIC "${CMAKE_CURRENT_LIST_DIR}")
    target_compile_features(OpenImageDenoise PUBLIC cxx_std_20)
    set_target_properties(OpenImageDenoise PROPERTIES POSITION_INDEPENDENT_CODE ON EXCLUDE_FROM_ALL ON)
endif()

# Sources of one folder are compiled together, so many at a time: what they all include, mostly the standard library, is read and
# instantiated once. Sources with compile options of their own, or SKIP_UNITY_BUILD_INCLUSION, are compiled alone. So names in unnamed
# namespaces are to be one folder's.
#
#   taut_unity(target most)
function(taut_unity target most)
    if(NOT TAUT_UNITY)
        return()
    endif()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
    # A member whose type is the source's own is taken for one of a header.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
    get_target_property(sources ${target} SOURCES)
    foreach(source ${sources})
        cmake_path(IS_PREFIX PROJECT_SOURCE_DIR "${source}" NORMALIZE ours)
        if(NOT ours OR NOT source MATCHES "[.]cpp$")
            continue()
        endif()
        get_source_file_property(alone "${source}" SKIP_UNITY_BUILD_INCLUSION)
        if(alone)
            continue() # nor does it move others to another group
        endif()
        cmake_path(RELATIVE_PATH source BASE_DIRECTORY "${PROJECT_SOURCE_DIR}" OUTPUT_VARIABLE folder)
        cmake_path(GET folder PARENT_PATH folder)
        string(MAKE_C_IDENTIFIER "${folder}" folder)
        math(EXPR group "${count_${folder}} + 0" OUTPUT_FORMAT DECIMAL)
        math(EXPR "count_${folder}" "${group} + 1")
        math(EXPR group "${group} / ${most}")
        set_property(SOURCE "${source}" PROPERTY UNITY_GROUP "${folder}_${group}")
    endforeach()
endfunction()

# What is installed: the headers named here, which are a promise, and those that they include. All others are the library's own.

set(TAUT_PUBLIC_ROOTS
    base/error.h base/frame_set.h base/vec.h
    microsurface/conventions.h microsurface/general_transform.h microsurface/ggx.h microsurface/random_walk.h microsurface/transform.h
    mesh/mesh.h mesh/shapes.h mesh/subdivide.h mesh/topology.h mesh/triangulate.h mesh/weld.h
    deform/animation.h deform/deformer.h deform/point_source.h deform/rig.h deform/skinning.h deform/surface_motion.h
    bsdf/bsdf.h bsdf/metals.h
    formats/gltf.h formats/point_cache.h formats/point_files.h formats/read_mesh.h formats/write_mesh.h
    scene/check_scene.h scene/load_scene.h scene/object_surface.h scene/scene.h
    export/gloss_export.h export/write_gloss.h
    plan/plan.h
    render/denoise.h render/frame_render.h render/image_file.h render/memory_use.h render/render_scene.h)

# Sets `out` to the paths below `source`, sorted.
function(taut_public_headers source out)
    set(waiting ${TAUT_PUBLIC_ROOTS})
    list(TRANSFORM waiting PREPEND taut/)
    set(found "")
    while(waiting)
        list(POP_FRONT waiting header)
        list(APPEND found ${header})
        file(STRINGS "${source}/${header}" lines REGEX "^#include \"taut/")
        foreach(line ${lines})
            string(REGEX REPLACE "^#include \"(taut/[^\"]+)\".*" "\\1" included "${line}")
            if(NOT included IN_LIST found AND NOT included IN_LIST waiting)
                list(APPEND waiting ${included})
            endif()
        endforeach()
    endwhile()
    list(SORT found)
    set(${out} ${found} PARENT_SCOPE)
endfunction()

#pragma once
/// What a frame's samples are told apart by: the light groups of what sends light, and the ids of what is seen (film_layers.h).

#include "taut/render/film_layers.h"
#include "taut/render/image_file.h"
#include "taut/render/render_scene.h"

#include <string>
#include <vector>

namespace taut {

/// Names of a scene's light groups: "emission" and "environment", then those of its lights in their order: the given one, or the name of
/// the light's kind. What shines by itself, a mesh that emits or an unlit colour, is of the object's group, else of "emission".
std::vector<std::string> lightGroupNames(const Scene &scene);

/// The layers with the names of the scene's light groups, where these are asked for.
FilmLayers layersOf(FilmLayers asked, const Scene &scene);

/// By what samples find their groups and ids; empty where they are not asked for.
struct LayerTables {
    std::size_t groups = 0;                  ///< how many
    Index environment = 0;                   ///< its group
    std::vector<Index> entries;              ///< [light table] group
    std::vector<std::vector<Index>> objects; ///< [objects][slots] group of what they emit
    bool hasIds = false;
    std::vector<std::uint32_t> objectIds, materialIds; ///< [objects], [materials and one more, for what has none]
};

/// For a scene at a frame.
LayerTables layerTables(const RenderScene &scene, const FilmLayers &layers);

/// Names that mattes go by: of objects as a scene has them, of materials likewise (several of one name are one matte); what has none is
/// "object 3", "material 2", counted from 0.
std::string matteName(const Scene &scene, Index object);
std::string materialMatteName(const Scene &scene, Index material);

/// Cryptomatte's metadata of an image with these layers: cryptomatte/<7 hex>/name, hash, conversion, manifest.
Metadata matteMetadata(const Scene &scene, const FilmLayers &layers);

} // namespace taut

#pragma once
/// The lights of a scene brought to a frame.

#include "taut/render/lights.h"
#include "taut/scene/scene.h"

namespace taut {

/// Fills the table from the scene's environment and lights and from what emits among `objects`, which stand where the frame wants them.
/// What the choice between lights is made by is kept where no light, emitter or camera has moved or changed since the table was filled;
/// returns whether it was.
bool placeLights(const Scene &scene, std::span<const RenderObject> objects, const DMat4 &worldFromRender, const DMat4 &renderFromWorld,
                 LightTable &table);

} // namespace taut

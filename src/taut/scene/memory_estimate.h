#pragma once
/// What an object will take once it is a surface that is rendered or exported, estimated from its mesh before any of it is made: an upper
/// bound for common meshes, measured (docs/limits.md).

#include "taut/scene/scene.h"

namespace taut {

/// Bytes of an object at a level of subdivision: its surface, what moves it, its BVH, and what it takes while they are built.
double objectBytes(const Object &object, const RenderSettings &render, int level);

/// Counts an object, all but the subdivision that a plan has yet to choose. Throws LimitError that names it.
void chargeObject(Budget &budget, const Object &object, const RenderSettings &render);

/// Counts what objects, lights and materials of a scene ask for together.
void chargeScene(const Scene &scene);

/// The finest level up to `most` that fits into what is left of a budget (null: `most`), at least 1.
int levelWithin(const Budget *budget, const Object &object, const RenderSettings &render, int most);

} // namespace taut

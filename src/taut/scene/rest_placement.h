#pragma once
/// What an object's gloss is measured against, and whether its placement ever leaves that shape (docs/pipeline.md, "The rest state").

#include "taut/scene/scene.h"

namespace taut {

/// Linear part of the rest placement: constant scale and shear of the object's placement, of its node and of its skeleton. Symmetric and
/// positive: rotation and mirroring change no shape and are left out. Directions that the placement flattens have its greatest scale;
/// where it leaves nothing, this is the identity.
Mat3 restFromObject(const Object &object);

/// True where every placement that the object is given, at any time, is its rest shape turned, moved or mirrored: then its gloss is the
/// rest gloss. What the matrices say decides, not which channels there are: a rotation under a constant non-uniform scale is a
/// deformation, and two scales that undo each other are none. A motion of more than 4096 keys that may change the shape counts as one that
/// does: what follows a deformation is right for every motion.
bool isRigid(const Object &object);
/// Placements of nodes that isRigid() evaluates.
double placementsToCompare(const Object &object);

/// The skin that moves the object's mesh; null: none.
const Skin *skinOf(const Object &object);

} // namespace taut

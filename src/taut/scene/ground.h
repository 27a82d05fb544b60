#pragma once
/// The stage of a bare file: a mesh or glTF file that is rendered without a scene file stands on a ground, in a neutral studio, framed; a
/// scene file where it asks for that.
///
/// The ground is a matt grey disc that fades into the backdrop, so that no edge is seen. It lies at the lowest point that the surfaces
/// reach at the frames that are rendered, and is there from above alone: a camera below it looks through. What the file or the command
/// line says itself stays: a camera, lights, an environment, which way is up.

#include "taut/scene/scene.h"

#include <optional>

namespace taut {

/// Frames that are looked at, evenly spread, the first and the last among them; all where there are no more.
inline constexpr std::size_t kMostFramesLookedAt = 64;

struct Ground {
    bool yUp = false;      ///< it is a mesh whose file says nothing of up, and stands with y up (upright.h)
    double height = 0;     ///< world z
    DVec2 centre{0};       ///< world x, y
    double radius = 1;     ///< where it has faded away
    double seenRadius = 1; ///< of a sphere about what stands on it
    DVec3 position{0};     ///< of a camera that frames all that is seen at these frames, with room around it
    DVec3 lookAt{0};
};

/// None where the scene is to have none (RenderSettings::ground), or nothing is seen of it. Throws as motionAtFrame() does.
std::optional<Ground> groundOf(const Scene &scene);

/// Stands a scene on the ground that it is to have, and warns where that turns it: what everything does that makes pictures of a scene.
/// Throws as groundOf().
std::optional<Ground> standOnGround(Scene &scene, Warnings &warnings);

/// Turns the mesh where y is up, adds the ground as the last object, with its materials, and puts the neutral studio and the framed camera
/// in the place of what nobody asked for.
void standOn(const Ground &ground, Scene &scene);

/// Makes a ground as wide as the camera that the scene has now asks for: it reaches beyond the camera.
void widen(const Scene &scene, Ground &ground);

} // namespace taut

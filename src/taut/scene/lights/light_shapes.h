#pragma once
/// The table of lights that are no mesh and no sky. A new kind is a file beside this one and its line in both lists below; scene
/// files, glTF, the plan and renders ask the file. It holds
///   struct DiskLight      what a scene says of it, world space, and
///       kName             its `type` in scene files, and in glTF where KHR_lights_punctual has it
///       read(keys)        its keys there; words for them: LightKeys of load_lights.cpp
///       fault()           what keys, each in range, may get wrong together, if they may
///       outline()         as it is seen, for the plan; without it: a light that reaches everywhere alike
///   struct PlacedDisk     what a frame makes of it, render space, trivially copyable, compared by ==, and
///       importance(..)    irradiance that it could cause at a receiver, unoccluded, up to a common factor; the receiver's cosine is
///                         left out where it has bounds(); zero only where it can send nothing
///       sample(..)        a sample, the choice between lights left out
///       bounds(..)        for the light tree, where it has an outline
///       meet(..), hitPdf(..)  where a ray meets it, and the density, times that of its choice, with which sample() returns the
///                         direction of a hit; without them: a light that rays can't meet
///   PlacedDisk place(const DiskLight &, const DMat4 &renderFromWorld)

#include "taut/scene/lights/directional_light.h"
#include "taut/scene/lights/point_light.h"
#include "taut/scene/lights/quad_light.h"
#include "taut/scene/lights/sphere_light.h"
#include "taut/scene/lights/spot_light.h"

#include <variant>

namespace taut {

/// In the order of their names in messages; the first is what scene files mean where they name none.
using LightShape = std::variant<QuadLight, SphereLight, DirectionalLight, PointLight, SpotLight>;

/// Calls f(shape) with each kind's default.
template <class F, std::size_t... kKinds> void forEachLightShape(const F &f, std::index_sequence<kKinds...>) {
    (f(std::variant_alternative_t<kKinds, LightShape>()), ...);
}
template <class F> void forEachLightShape(const F &f) {
    forEachLightShape(f, std::make_index_sequence<std::variant_size_v<LightShape>>());
}

/// A light that is not a mesh (mesh lights are objects with emission). World space.
struct Light {
    Vec3 radiance{1}; ///< or what its kind says that it is
    LightShape shape;
    bool cameraVisible = false; ///< seen directly by camera rays, where rays can meet it
    Index group = kNone;        ///< into Scene::lightGroups; none: that of its kind, by its name
};

} // namespace taut

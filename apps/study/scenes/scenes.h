#pragma once
/// Parts that scenes of charts and benches are made of.

#include "taut/mesh/shapes.h"
#include "taut/scene/scene.h"

#include <memory>

namespace taut::chart {

/// An object of a mesh with one of the scene's materials.
Object objectOf(Mesh mesh, Index material = 0);

/// Metal without colour, by its alphas along and across the tangent.
Material brushedMetal(float alphaX, float alphaY);

/// From 0 at frame 1 on, evenly.
Keyed<double> ramp(double to, double lastFrame);

/// A deformer along `axis` with `axis2` its second axis; twist and bend between -reach and reach.
DeformerKeys deformer(DeformerType type, const Keyed<double> &amount, int axis, int axis2, double reach = 2, double wavelength = 0.65);
DeformerKeys stretchBy(const Keyed<DVec3> &factor);

/// A torus twisted about x and waved along y.
Object twistedTorus(Mesh torus, double twist, double wave);

/// A square picture of one object under a quad light and a dim sky, seen from above at an angle.
Scene studyScene(Object object, const Material &material, int size);

/// A torus seen from above at an angle; with a second material also 20 x 20 m of ground at the height `ground`. Without light.
Scene torusScene(Mesh torus, double ground, std::vector<Material> materials, int size, int maxEvents);
/// A square of 4 m^2 three metres above, facing down.
Light lampAbove();

} // namespace taut::chart

#include "taut/deform/orientation.h"

#include "taut/base/parallel.h"
#include "taut/deform/skinning.h"
#include "taut/deform/surface_motion.h"

namespace taut {

void orientationOfPoints(const MotionState &motion, const SkinWeights &skin, Orientation &out) {
    const std::size_t count = motion.control.size();
    OrientationGatherer gatherer(motion.mirrored, motion.turnsVary(skin), count, out);
    const int placed = motion.placedSide();
    if (motion.turnsVary(skin))
        parallelFor(count, kVertexGrain, [&](std::size_t v) {
            const Affine map = blendedTransform(skin, v, motion.joints, motion.carrier);
            int side = orientationOf(DMat3(linearOf(map))) * placed;
            DVec3 x(transformPoint(map, motion.control[v]));
            for (const Deformer &deformer : motion.deformers) {
                const DeformedPoint image = deform(deformer, x);
                side *= orientationOf(image.jacobian);
                x = image.position;
            }
            gatherer.set(v, side);
        });
    gatherer.finish();
}

} // namespace taut

#include "study/scenes/plan_scenes.h"

#include "study/scenes/scenes.h"

namespace taut::chart {

namespace {

DeformerKeys rising(DeformerType type, double to, int axis, int axis2) {
    return deformer(type, ramp(to, 3), axis, axis2, 1, 1.3);
}

DeformerKeys stretchTo(const DVec3 &factor) {
    Keyed<DVec3> keyed;
    keyed.keys = {{1, DVec3(1)}, {3, factor}};
    return stretchBy(keyed);
}

/// One object over a dim sky, a lamp above: seen at frame 3, planned over frames 1 to 3.
PlanScene sceneOf(const std::string &name, Object object, const Material &material, int size) {
    PlanScene plan;
    plan.name = name;
    plan.frame = 3;
    plan.scene = studyScene(std::move(object), material, size);
    plan.scene.render.boxFilter = false;
    plan.scene.render.frames = {1, 2, 3};
    return plan;
}

} // namespace

std::vector<PlanScene> planScenes(int size) {
    std::vector<PlanScene> scenes;
    const auto add = [&](const std::string &name, Mesh mesh, const std::vector<DeformerKeys> &deformers, const Material &material) {
        Object object = objectOf(std::move(mesh));
        object.deformers = deformers;
        scenes.push_back(sceneOf(name, std::move(object), material, size));
        return &scenes.back();
    };
    const auto plate = [] { return makeGrid(24, 24, 1.6F); };
    const auto torus = [] { return makeTorus(64, 32, 0.7F, 0.3F); };
    const auto ball = [] { return makeSphere(64, 32, 0.8F); };
    PlanScene *rigid = add("rigid torus", torus(), {}, brushedMetal(0.1F, 0.3F));
    rigid->scene.objects[0].placement.rotation.keys = {{1, DVec3(0)}, {3, DVec3(0, 0.4, 0.8)}};
    add("uniform stretch of a plate", plate(), {stretchTo({2, 1, 1})}, brushedMetal(0.1F, 0.3F));
    add("scaled sphere", ball(), {stretchTo({1.3, 1.3, 1.3})}, brushedMetal(0.2F, 0.2F));
    add("barely stretched torus", torus(), {stretchTo({1.001, 1, 1})}, brushedMetal(0.2F, 0.2F));
    add("sheared plate", plate(), {rising(DeformerType::Shear, 1.2, 0, 1)}, brushedMetal(0.05F, 0.25F));
    add("sheared torus", torus(), {rising(DeformerType::Shear, 0.8, 0, 2)}, brushedMetal(0.1F, 0.4F));
    add("twisted plate", plate(), {rising(DeformerType::Twist, 0.8, 0, 2)}, brushedMetal(0.15F, 0.15F));
    add("bent plate", plate(), {rising(DeformerType::Bend, 0.9, 0, 2)}, brushedMetal(0.1F, 0.3F));
    add("rough wave", plate(), {rising(DeformerType::Wave, 0.15, 0, 2)}, brushedMetal(0.5F, 0.5F));
    add("very rough torus", torus(), {stretchTo({1.5, 1, 0.8})}, brushedMetal(0.9F, 0.9F));
    add("smooth twisted torus", torus(), {rising(DeformerType::Twist, 0.7, 2, 0)}, brushedMetal(0.02F, 0.04F));
    Material glass;
    glass.type = BsdfType::Dielectric;
    glass.alphaX.value = glass.alphaY.value = 0.3F;
    add("glass ball", ball(), {stretchTo({1, 1, 0.7})}, glass);
    Material coated;
    coated.type = BsdfType::Coated;
    coated.color.value = Vec3(0.6F, 0.2F, 0.1F);
    coated.alphaX.value = coated.alphaY.value = 0.1F;
    add("coated bent plate", plate(), {rising(DeformerType::Bend, 0.5, 0, 2)}, coated);
    Material diffuse;
    diffuse.color.value = Vec3(0.6F);
    add("diffuse twisted torus", torus(), {rising(DeformerType::Twist, 0.7, 2, 0)}, diffuse);
    PlanScene *leaning = add("leaning block face", plate(), {rising(DeformerType::Shear, 0.6, 0, 2)}, brushedMetal(0.2F, 0.4F));
    leaning->scene.objects[0].lean = true;
    PlanScene *subdivided =
        add("subdivided sheared torus", makeTorus(16, 8, 0.7F, 0.3F), {rising(DeformerType::Shear, 0.6, 0, 2)}, brushedMetal(0.15F, 0.3F));
    subdivided->scene.objects[0].subdivision.level = 2;
    PlanScene *refined =
        add("torus of a planned level", makeTorus(16, 8, 0.7F, 0.3F), {rising(DeformerType::Twist, 0.4, 2, 0)}, brushedMetal(0.3F, 0.4F));
    refined->scene.objects[0].planLevel = true;
    refined->scene.objects[0].subdivision.level = kUnplannedLevel;
    return scenes;
}

} // namespace taut::chart

#pragma once
/// A relief of crossed waves over a plate, twice: as real facets, and as the normal map of a flat one.

#include "taut/mesh/shapes.h"
#include "taut/scene/scene.h"

namespace taut::chart {

/// Slopes up to `steep`; `waves` waves along each side of the plate [-1, 1]^2.
struct Relief {
    int waves = 4;
    float steep = 0.25F;
};

/// The map, n x n texels.
inline Texture reliefNormals(const Relief &relief, int n) {
    std::vector<float> texels;
    const auto angle = [&](int i) {
        return 2 * kPi * static_cast<float>(relief.waves) * (static_cast<float>(i) + 0.5F) / static_cast<float>(n);
    };
    for (int row = 0; row < n; ++row)
        for (int column = 0; column < n; ++column) {
            const float u = angle(column);
            const float v = angle(n - 1 - row);
            // h = -steep / k sin u sin v, s = -grad h
            const Vec2 slope = relief.steep * Vec2(std::cos(u) * std::sin(v), std::sin(u) * std::cos(v));
            const Vec3 normal = glm::normalize(Vec3(slope, 1));
            for (int c = 0; c < 3; ++c) texels.push_back(0.5F * normal[c] + 0.5F);
        }
    Texture texture;
    texture.name = "relief";
    texture.width = texture.height = n;
    texture.texels = std::move(texels);
    return texture;
}

/// The facets, 2 n^2 triangles; u = (x + 1) / 2.
inline Mesh reliefMesh(const Relief &relief, int n) {
    Mesh mesh = makeGrid(n, n, 2);
    const float k = kPi * static_cast<float>(relief.waves);
    for (Vec3 &p : mesh.positions) p.z = -relief.steep / k * std::sin(k * (p.x + 1)) * std::sin(k * (p.y + 1));
    mesh.normals.clear();
    mesh.cornerNormals.clear();
    mesh.name = "relief";
    return mesh;
}

/// A white mirror of this alpha on `mesh` under the studio's lights, seen from above, single scattering and no light from facet to facet.
/// Deformers carry the space above along.
inline Scene reliefScene(Mesh mesh, std::vector<DeformerKeys> deformers, float alpha, int size) {
    Scene scene;
    Object object;
    object.name = mesh.name;
    object.mesh = std::make_shared<const Mesh>(std::move(mesh));
    object.materials = {0};
    object.deformers = std::move(deformers);
    object.lean = !object.deformers.empty();
    object.mapTangents = true;
    scene.objects = {std::move(object)};
    Material material;
    material.name = "white mirror";
    material.type = BsdfType::Conductor;
    material.alphaX.value = material.alphaY.value = alpha;
    material.multiscatter = Multiscatter::Off;
    scene.materials = {material};
    scene.environment = studioEnvironment();
    scene.render.width = scene.render.height = size;
    scene.render.boxFilter = true;
    scene.render.maxEvents = 1;
    scene.camera.position = DVec3(0, 0, 4);
    scene.camera.up = DVec3(0, 1, 0);
    scene.camera.orthoHeight = 1.2;
    return scene;
}
/// The flat plate with the map.
inline Scene mappedReliefScene(const Relief &relief, std::vector<DeformerKeys> deformers, float alpha, int size) {
    Scene scene = reliefScene(makeGrid(16, 16, 2), std::move(deformers), alpha, size);
    scene.textures = {reliefNormals(relief, 1024)};
    scene.materials[0].slopes = {SlopeMap::Kind::Normal, 0, 1};
    return scene;
}

} // namespace taut::chart

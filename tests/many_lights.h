#pragma once
/// Scenes of many lights, and the light of each alone by quadrature.

#include "direction_bins.h"
#include "render_fixtures.h"

namespace taut::test {

/// Lights of a scene whose world is render space, at frame 1.
class Lit {
  public:
    explicit Lit(Scene scene) : scene_(std::move(scene)), ready_(scene_, false) {
        StageTimes times;
        ready_.setFrame(1, times);
    }
    [[nodiscard]] const LightTable &table() const { return ready_.lights(); }

  private:
    Scene scene_;
    RenderScene ready_;
};

inline Scene emptyScene() {
    Scene scene;
    scene.materials = {Material{}};
    scene.camera.position = DVec3(0);
    scene.camera.lookAt = DVec3(0, 0, -1);
    scene.camera.up = DVec3(0, 1, 0);
    return scene;
}

inline Vec3 randomPoint(Uniform &random, float size) {
    const float x = random.number() - 0.5F;
    const float y = random.number() - 0.5F;
    return size * Vec3(x, y, random.number() - 0.5F);
}
inline Vec3 randomDirection(Uniform &random) {
    return squareToSphere(random.pair());
}

/// Triangles of different sizes within a cube of side `size`; every `gap`th has no area.
inline Mesh randomTriangles(Uniform &random, int count, float size, int gap = 0) {
    Mesh mesh;
    for (int i = 0; i < count; ++i) {
        const Vec3 centre = randomPoint(random, size);
        const float edge = 0.02F + 0.3F * random.number();
        for (int k = 0; k < 3; ++k) {
            mesh.cornerPositions.push_back(static_cast<Index>(mesh.positions.size()));
            mesh.positions.push_back(gap > 0 && i % gap == 0 ? centre : centre + randomPoint(random, edge));
        }
        mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
    }
    return mesh;
}

inline Object emitter(Mesh mesh, float radiance, bool twoSided) {
    Object object = makeObject(std::move(mesh));
    object.smooth = false;
    object.emission.value = Vec3(radiance);
    object.emissionTwoSided = twoSided;
    return object;
}

inline Light randomLight(Uniform &random, int i) {
    const DVec3 at(randomPoint(random, 4));
    const double radius = 0.02 + 0.1 * static_cast<double>(random.number());
    const DVec3 u = 0.3 * DVec3(randomDirection(random));
    const DVec3 v = 0.3 * DVec3(randomDirection(random));
    const DVec3 direction(randomDirection(random));
    const double outerAngle = 0.3 + 0.9 * static_cast<double>(random.number());
    const LightShape shapes[] = {QuadLight{at, u, v, i % 8 == 0}, SphereLight{at, radius}, PointLight{at},
                                 SpotLight{at, direction, 0.5 * outerAngle, outerAngle}};
    return {Vec3(std::exp(3 * random.number())), shapes[i % 4], i % 3 == 0};
}

/// Quads, spheres, points, spots and triangles of two meshes; with a map and a sun where asked for.
inline Scene manyLights(int lights, int triangles, bool everywhere) {
    Uniform random(7);
    Scene scene = emptyScene();
    for (int i = 0; i < lights; ++i) scene.lights.push_back(randomLight(random, i));
    if (triangles > 0) {
        scene.objects.push_back(emitter(randomTriangles(random, triangles, 3, 7), 5, false));
        scene.objects.push_back(emitter(randomTriangles(random, triangles / 2, 1), 2, true));
    }
    if (!everywhere) return scene;
    scene.lights.push_back({Vec3(1), DirectionalLight()});
    scene.environment = studioEnvironment();
    return scene;
}

inline std::vector<LightPart> allChoices(const LightTable &table) {
    std::vector<LightPart> all = table.parts;
    for (const Index entry : table.everywhere) all.push_back({entry, 0});
    return all;
}

struct Corners {
    DVec3 a, b, c;
};
inline Corners cornersOf(const LightEntry &entry, Index triangle, float time = 0) {
    const auto &mesh = std::get<MeshEmitter>(entry.shape);
    const Index3 &t = mesh.triangles[triangle];
    return {DVec3(emitterPosition(mesh, t.x, time)), DVec3(emitterPosition(mesh, t.y, time)), DVec3(emitterPosition(mesh, t.z, time))};
}

/// Irradiance from a small piece of surface on a receiver whose normal is n.
inline double fromPiece(const DVec3 &point, const DVec3 &n, const DVec3 &at, const DVec3 &areaNormal, bool twoSided) {
    const DVec3 d = at - point;
    const double distance2 = glm::dot(d, d);
    const double facing = -glm::dot(areaNormal, d);
    return std::max(0.0, glm::dot(n, d)) * (twoSided ? std::fabs(facing) : std::max(0.0, facing)) / (distance2 * distance2);
}

inline double fromTriangle(const DVec3 &point, const DVec3 &n, const Corners &t, bool twoSided, int depth) {
    const DVec3 areaNormal = 0.5 * glm::cross(t.b - t.a, t.c - t.a);
    const DVec3 centre = (t.a + t.b + t.c) / 3.0;
    const double size = std::max(glm::length(t.b - t.a), std::max(glm::length(t.c - t.b), glm::length(t.a - t.c)));
    if (depth == 0 || size < 0.02 * glm::length(centre - point)) return fromPiece(point, n, centre, areaNormal, twoSided);
    const DVec3 ab = 0.5 * (t.a + t.b);
    const DVec3 bc = 0.5 * (t.b + t.c);
    const DVec3 ca = 0.5 * (t.c + t.a);
    double sum = 0;
    for (const Corners &quarter : {Corners{t.a, ab, ca}, {ab, t.b, bc}, {ca, bc, t.c}, {ab, bc, ca}})
        sum += fromTriangle(point, n, quarter, twoSided, depth - 1);
    return sum;
}

/// Irradiance of one light alone, in double.
inline double irradiance(const LightTable &table, const LightPart &part, const Vec3 &at, const Vec3 &normal) {
    const LightEntry &e = table.entries[part.entry];
    const DVec3 point(at);
    const DVec3 n(normal);
    const auto brightness = static_cast<double>(e.radiance.x);
    if (const auto *mesh = std::get_if<MeshEmitter>(&e.shape))
        return brightness * fromTriangle(point, n, cornersOf(e, part.triangle), mesh->twoSided, 8);
    if (const auto *quad = std::get_if<PlacedQuad>(&e.shape)) {
        const DVec3 o(quad->corner);
        const DVec3 u(quad->u);
        const DVec3 v(quad->v);
        return brightness * (fromTriangle(point, n, {o, o + u, o + v}, quad->twoSided, 9) +
                             fromTriangle(point, n, {o + u + v, o + v, o + u}, quad->twoSided, 9));
    }
    if (const auto *sphere = std::get_if<PlacedSphere>(&e.shape)) {
        const DVec3 toLight = DVec3(sphere->centre) - point;
        const double distance = glm::length(toLight);
        const double cap = 1 - std::sqrt(1 - sqr(static_cast<double>(sphere->radius) / distance));
        const DVec3 axis = toLight / distance;
        const DVec3 s = glm::normalize(glm::cross(axis, std::fabs(axis.x) < 0.6 ? DVec3(1, 0, 0) : DVec3(0, 1, 0)));
        const DVec3 t = glm::cross(axis, s);
        double sum = 0;
        constexpr int kN = 100;
        for (int i = 0; i < kN; ++i)
            for (int j = 0; j < kN; ++j) {
                const double z = 1 - cap * (i + 0.5) / kN;
                const double phi = 2 * kPiD * (j + 0.5) / kN;
                const double r = std::sqrt(1 - z * z);
                sum += std::max(0.0, glm::dot(n, axis * z + s * (r * std::cos(phi)) + t * (r * std::sin(phi))));
            }
        return brightness * sum * 2 * kPiD * cap / (kN * kN);
    }
    const auto *spot = std::get_if<PlacedSpot>(&e.shape);
    const DVec3 toLight = DVec3(spot != nullptr ? spot->position : std::get<PlacedPoint>(e.shape).position) - point;
    const double distance = glm::length(toLight);
    double fade = 1;
    if (spot != nullptr) {
        const double cosine = -glm::dot(toLight, DVec3(spot->direction)) / distance;
        fade = sqr(
            std::clamp((cosine - static_cast<double>(spot->cosOuter)) / static_cast<double>(spot->cosInner - spot->cosOuter), 0.0, 1.0));
    }
    return brightness * fade * std::max(0.0, glm::dot(n, toLight)) / (distance * distance * distance);
}

/// Mean and its standard error.
struct Estimate {
    double mean = 0, error = 0, variance = 0;
};
template <class Draw> Estimate estimate(int count, const Draw &draw) {
    double sum = 0;
    double squares = 0;
    for (int i = 0; i < count; ++i) {
        const double x = draw();
        sum += x;
        squares += x * x;
    }
    Estimate e;
    e.mean = sum / count;
    e.variance = squares / count - e.mean * e.mean;
    e.error = std::sqrt(e.variance / count);
    return e;
}

inline double received(const LightSample &s, const Vec3 &normal) {
    return s.pdf > 0 ? static_cast<double>(s.radiance.x * std::max(0.0F, glm::dot(normal, s.direction)) / s.pdf) : 0.0;
}

/// A surface there that any light may reach, or one of a random normal, in turn.
inline Receiver receiverOf(const Vec3 &point, Uniform &random, int turn) {
    return {point, turn % 2 == 0 ? Vec3(0) : randomDirection(random)};
}

/// At a surface whose normal is that, chosen by what `at` knows.
inline Estimate sampledIrradiance(const LightTable &table, const Receiver &at, const Vec3 &normal, Uniform &random, int count) {
    return estimate(count, [&] {
        const float time = random.number();
        const float choose = random.number();
        return received(sampleLight(table, at, time, choose, random.pair()), normal);
    });
}

/// Inside the crowd, at its edge, and far away.
inline std::vector<Vec3> somePoints(Uniform &random, int each) {
    std::vector<Vec3> points;
    for (const float size : {1.0F, 4.0F, 100.0F})
        for (int i = 0; i < each; ++i) points.push_back(randomPoint(random, size));
    return points;
}

} // namespace taut::test

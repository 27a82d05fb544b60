/// The renderer against what must hold exactly: rigid motions, rest states, equivalent materials, furnaces, thread counts.

#include "catch.h"
#include "render_fixtures.h"

#include <tbb/global_control.h>

using namespace taut;
using namespace taut::test;

namespace {

/// Directional albedo of isotropic GGX, F = 1, single scattering, by midpoint quadrature of the mirror lobe in double.
double isotropicAlbedo(double alpha, double cosine) {
    const double a2 = alpha * alpha;
    const auto lambda = [&](double z) { return 0.5 * (std::sqrt(1 + a2 * (1 - z * z) / (z * z)) - 1); };
    const DVec3 wo(std::sqrt(1 - cosine * cosine), 0, cosine);
    constexpr int kN = 400;
    double sum = 0;
    for (int i = 0; i < kN; ++i)
        for (int j = 0; j < kN; ++j) {
            // Micro-normals by the NDF: slopes tan^2 = a2 u / (1 - u).
            const double u = (i + 0.5) / kN;
            const double phi = 6.283185307179586 * (j + 0.5) / kN;
            const double t2 = a2 * u / (1 - u);
            const double z = 1 / std::sqrt(1 + t2);
            const double r = std::sqrt(t2) * z;
            const DVec3 m(r * std::cos(phi), r * std::sin(phi), z);
            const double om = glm::dot(wo, m);
            const DVec3 wi = 2 * om * m - wo;
            if (om <= 0 || wi.z <= 0) continue;
            sum += om / (cosine * z * (1 + lambda(cosine) + lambda(wi.z))); // G2 <wo,m> / (wo.z m.z)
        }
    return sum / (kN * kN);
}

/// The object moved rigidly by the same rotation and translation as the camera and the light.
Scene movedRigidly(Scene scene, const DVec3 &angles, const DVec3 &translation) {
    Placement placement;
    placement.rotation = angles;
    placement.translation = translation;
    const DMat4 motion = placementAt(placement, 1);
    const auto point = [&](const DVec3 &p) { return DVec3(motion * glm::dvec4(p, 1)); };
    const auto vector = [&](const DVec3 &v) { return DMat3(motion) * v; };
    for (Object &object : scene.objects) {
        object.placement.rotation = angles;
        object.placement.translation = translation;
    }
    scene.camera.position = point(scene.camera.position.first());
    scene.camera.lookAt = point(scene.camera.lookAt.first());
    scene.camera.up = vector(scene.camera.up.first());
    for (Light &light : scene.lights) {
        auto &quad = std::get<QuadLight>(light.shape);
        quad = {point(quad.corner), vector(quad.u), vector(quad.v), quad.twoSided};
    }
    return scene;
}

} // namespace

TEST_CASE("A rigid motion of mesh, light and camera leaves the image as it is", "[render][rigid]") {
    for (const bool deformed : {false, true}) {
        Object torus = makeObject(makeTorus(64, 32, 0.8F, 0.3F));
        if (deformed) torus.deformers = {shearDeformer(0.7, 0, 2)};
        const Scene still = smallScene(torus, ggxMaterial(0.1F, 0.4F, 0.5F));
        const std::vector<float> reference = renderImage(still, 1, 16);
        for (const auto &[angles, translation] :
             {std::pair(DVec3(0.3, -1.1, 2.0), DVec3(5.5, -3.25, 100)), std::pair(DVec3(2.5, 0.2, -0.7), DVec3(-1e-3, 7, 0.5))}) {
            const std::vector<float> moved = renderImage(movedRigidly(still, angles, translation), 1, 16);
            INFO("deformed " << deformed << ", greatest difference " << greatestDifference(reference, moved));
            CHECK(greatestDifference(reference, moved) < 1e-5F);
        }
    }
}

TEST_CASE("A constant scale is a placement: it changes no alpha", "[render][rest]") {
    const auto microsurface = [](const DVec3 &scale, const DVec3 &cameraScale) {
        Scene scene = smallScene(makeObject(makeTorus(48, 24, 0.8F, 0.3F)), ggxMaterial(0.1F, 0.4F));
        scene.lights.clear();
        scene.objects[0].placement.scale = scale;
        scene.objects[0].deformers = {stretchDeformer(DVec3(1 + 1e-9))}; // keeps the object from the rigid short cut
        scene.camera.position = scene.camera.position.first() * cameraScale;
        return renderImage(scene, 1, 4, {"m", "stretch"});
    };
    // Every stretch is 1, under uneven constant scales too.
    for (const DVec3 &scale : {DVec3(0.01), DVec3(100), DVec3(-1, 1, 1), DVec3(1, 3, 0.5)}) {
        const std::vector<float> image = microsurface(scale, scale);
        for (std::size_t p = 0; p < image.size(); p += 9)
            if (image[p + 4] != 0) {
                CHECK(image[p + 7] == Approx(1).epsilon(1e-4));
                CHECK(image[p + 8] == Approx(1).epsilon(1e-4));
            }
    }
}

TEST_CASE("A keyed uniform stretch by 2 halves alpha where lambda = 1 and leaves it where lambda = 2", "[render][rest]") {
    for (const bool byScale : {false, true})
        for (const float poisson : {0.0F, -1.0F}) { // nu = -1: the normal stretches as the surface does
            Material material = ggxMaterial(0.2F, 0.2F);
            material.poisson = poisson;
            Object torus = makeObject(makeTorus(48, 24, 0.4F, 0.15F));
            if (byScale) {
                torus.placement.scale.keys = {{1, DVec3(1)}, {2, DVec3(2)}};
            } else {
                torus.deformers = {stretchDeformer(DVec3(1))};
                torus.deformers[0].factor.keys = {{1, DVec3(1)}, {2, DVec3(2)}};
            }
            const Scene scene = smallScene(torus, material, 24);
            for (const auto &[frame, expected] : {std::pair(1.0, 0.2F), std::pair(2.0, poisson == 0 ? 0.1F : 0.2F)}) {
                const std::vector<float> image = renderImage(scene, frame, 2, {"alpha"});
                int seen = 0;
                for (std::size_t p = 0; p < image.size(); p += 7) {
                    if (image[p + 4] == 0) continue;
                    ++seen;
                    CHECK(image[p + 4] == Approx(expected).epsilon(1e-4));
                    CHECK(image[p + 5] == Approx(expected).epsilon(1e-4));
                }
                CHECK(seen > 20);
            }
        }
}

TEST_CASE("Stretch diag(2, 1) of alpha 0.2 is alpha (0.1, 0.2)", "[render][equivalence]") {
    Object stretched = makeObject(makeGrid(8, 8, 1));
    stretched.deformers = {stretchDeformer(DVec3(2, 1, 1))};
    Mesh wide = makeGrid(8, 8, 1);
    for (Vec3 &p : wide.positions) p.x *= 2;
    const std::vector<float> a = renderImage(smallScene(stretched, ggxMaterial(0.2F, 0.2F)), 1, 64);
    const std::vector<float> b = renderImage(smallScene(makeObject(wide), ggxMaterial(0.1F, 0.2F)), 1, 64);
    CHECK(greatestDifference(a, b) < 1e-4F);
    const std::vector<float> unchanged = renderImage(smallScene(makeObject(wide), ggxMaterial(0.2F, 0.2F)), 1, 64);
    CHECK(shareOver(a, unchanged, 0.05F) > 0.05); // and it is not the image with roughness held fixed
}

TEST_CASE("Pure shear looks like its (alpha_max, alpha_min, phi)", "[render][equivalence]") {
    const float shear = 1.2F;
    Object sheared = makeObject(makeGrid(8, 8, 1));
    sheared.deformers = {shearDeformer(static_cast<double>(shear))};
    Mesh slanted = makeGrid(8, 8, 1);
    for (Vec3 &p : slanted.positions) p.x += shear * p.y;
    const EquivalentAlpha e = equivalentAlpha(microTransform(1 / 0.2F, shear / 0.2F, 0, 1 / 0.2F));
    // Sampling knows M M^T and the normal only, not the parametrisation: the images are the same, not just their means.
    const std::vector<float> a = renderImage(smallScene(sheared, ggxMaterial(0.2F, 0.2F)), 1, 64);
    const std::vector<float> b = renderImage(smallScene(makeObject(slanted), ggxMaterial(e.max, e.min, e.phi)), 1, 64);
    CHECK(greatestDifference(a, b) < 1e-3F);
}

namespace {

/// A cylinder about z of radius 0.5 and height 1: u around, v along.
Mesh makeCylinder() {
    Mesh mesh = makeGrid(384, 96, 1);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const float angle = 2 * kPi * (mesh.positions[i].x + 0.5F);
        mesh.normals[i] = Vec3(std::cos(angle), std::sin(angle), 0);
        mesh.positions[i] = Vec3(0.5F * mesh.normals[i].x, 0.5F * mesh.normals[i].y, mesh.positions[i].y);
    }
    mesh.name = "cylinder";
    return mesh;
}

} // namespace

TEST_CASE("A curved surface looks as its analytic gradient says", "[render][equivalence]") {
    SECTION("a cylinder drawn out by 2 is a long one, smoother along") {
        Object stretched = makeObject(makeCylinder());
        stretched.deformers = {stretchDeformer(DVec3(1, 1, 2))};
        Mesh tall = makeCylinder();
        for (Vec3 &p : tall.positions) p.z *= 2;
        const std::vector<float> a = renderImage(smallScene(stretched, ggxMaterial(0.2F, 0.2F)), 1, 64);
        const std::vector<float> b = renderImage(smallScene(makeObject(tall), ggxMaterial(0.2F, 0.1F)), 1, 64);
        // Equal images but for what is interpolated between normals, which falls with the square of the mesh's step (the share over
        // 1e-3 is 4e-3 on a mesh four times coarser), and a path in a thousand that rounding of a vertex sends another way.
        CHECK(shareOver(a, b, 1e-3F) < 1e-3);
        const std::vector<float> unchanged = renderImage(smallScene(makeObject(tall), ggxMaterial(0.2F, 0.2F)), 1, 64);
        CHECK(shareOver(a, unchanged, 0.05F) > 0.02);
    }
    SECTION("a twisted cylinder is sheared by r dphi/dz everywhere") {
        DeformerKeys twist;
        twist.type = DeformerType::Twist;
        twist.lower = -0.5;
        twist.upper = 0.5;
        twist.amount = 2.0;
        Object twisted = makeObject(makeCylinder());
        twisted.deformers = {twist};
        const float shear = 0.5F * 2.0F;
        const EquivalentAlpha expected = equivalentAlpha(microTransform(1 / 0.2F, shear / 0.2F, 0, 1 / 0.2F));
        const std::vector<float> image = renderImage(smallScene(twisted, ggxMaterial(0.2F, 0.2F)), 1, 16, {"alpha"});
        int seen = 0;
        for (std::size_t p = 0; p < image.size(); p += 7) {
            if (image[p + 3] < 1 || image[p + 4] == 0) continue;
            ++seen;
            CHECK(image[p + 4] == Approx(expected.max).epsilon(2e-3));
            CHECK(image[p + 5] == Approx(expected.min).epsilon(2e-3));
        }
        CHECK(seen > 100);
    }
}

TEST_CASE("White furnace: a closed object with F = 1 loses what its microsurface's albedo says", "[render][furnace]") {
    for (const float alpha : {0.25F, 0.6F}) {
        Material single = ggxMaterial(alpha, alpha);
        single.multiscatter = Multiscatter::Off;
        Scene scene = smallScene(makeObject(makeSphere(256, 128, 0.8F)), single, 40);
        scene.lights.clear();
        scene.environment = constantEnvironment(Vec3(1));
        const std::vector<float> image = renderImage(scene, 1, 1024, {"shading_normal", "position"});
        const DVec3 eye = scene.camera.position.first();
        double measured = 0;
        double expected = 0;
        int count = 0;
        for (std::size_t p = 0; p < image.size(); p += 10) {
            if (image[p + 4] == 0 && image[p + 5] == 0 && image[p + 6] == 0) continue;
            const DVec3 n = glm::normalize(DVec3(image[p + 4], image[p + 5], image[p + 6]));
            const DVec3 wo = glm::normalize(eye - DVec3(image[p + 7], image[p + 8], image[p + 9]));
            const double cosine = glm::dot(n, wo);
            if (cosine < 0.4) continue; // inside the silhouette, where a pixel holds one slope
            measured += static_cast<double>(image[p]);
            expected += isotropicAlbedo(static_cast<double>(alpha), cosine);
            ++count;
        }
        INFO("alpha " << alpha << ", pixels " << count);
        CHECK(count > 100);
        CHECK(measured / count == Approx(expected / count).epsilon(2e-3));
    }
}

TEST_CASE("The same bits for one and two threads", "[render][determinism]") {
    Object torus = makeObject(makeTorus(64, 32, 0.8F, 0.3F));
    torus.deformers = {shearDeformer(0.7, 0, 2)};
    const Scene scene = smallScene(torus, ggxMaterial(0.1F, 0.4F));
    const auto withThreads = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return renderImage(scene, 1, 8, {"alpha", "position"});
    };
    const std::vector<float> one = withThreads(1);
    CHECK(one == withThreads(2));
    CHECK(one == withThreads(2));
}

TEST_CASE("A crop is a part of the whole", "[render][determinism]") {
    const Scene scene = smallScene(makeObject(makeTorus(32, 16, 0.8F, 0.3F)), ggxMaterial(0.1F, 0.4F));
    const std::vector<float> whole = renderImage(scene, 1, 8);
    RenderScene ready(scene, false);
    StageTimes times;
    ready.setFrame(1, times);
    FrameOptions options;
    options.spp = 8;
    options.seed = 1;
    options.window = {7, 5, 30, 41};
    const std::vector<float> part = renderFrame(ready, options).film.resolve();
    std::size_t i = 0;
    for (int y = 5; y < 41; ++y)
        for (int x = 7; x < 30; ++x)
            for (int c = 0; c < 4; ++c, ++i) REQUIRE(part[i] == whole[static_cast<std::size_t>((y * 48 + x) * 4 + c)]);
}

TEST_CASE("Light sampling and scattered rays agree: every light type gives the same image either way", "[render][mis]") {
    // A diffuse plane under a light: the closed form of a quad parallel to it, and sphere and mesh lights against a quad's.
    Material diffuse;
    diffuse.color.value = Vec3(1);
    Scene scene = smallScene(makeObject(makeGrid(1, 1, 0.02F)), diffuse, 8);
    scene.environment.reset();
    scene.camera.position = DVec3(0, -0.02, 0.02);
    scene.camera.fovY = 0.2;
    scene.render.maxEvents = 1;
    const auto centre = [&] {
        const std::vector<float> image = renderImage(scene, 1, 4096);
        return image[(4 * 8 + 4) * 4];
    };
    // Square of side 2 at height 1, centred above: form factor of a point (double the corner formula four times).
    scene.lights = {{Vec3(1), QuadLight{DVec3(-1, 1, 1), DVec3(2, 0, 0), DVec3(0, -2, 0)}}};
    const double corner = (2 / std::sqrt(2.0) * std::atan(1 / std::sqrt(2.0))) / (2 * 3.141592653589793);
    CHECK(centre() == Approx(4 * corner).epsilon(5e-3));
    // Sphere of radius 0.5 at height 2: (r / h)^2.
    scene.lights = {{Vec3(1), SphereLight{DVec3(0, 0, 2), 0.5}}};
    CHECK(centre() == Approx(0.0625).epsilon(5e-3));
    // Mesh emitter: the same square as a mesh facing down.
    scene.lights.clear();
    Mesh square = makeGrid(3, 3, 2);
    for (Vec3 &p : square.positions) p = Vec3(p.x, -p.y, 1);
    for (Vec3 &n : square.normals) n = Vec3(0, 0, -1);
    Object emitter = makeObject(square);
    emitter.emission.value = Vec3(1);
    scene.objects.push_back(emitter);
    CHECK(centre() == Approx(4 * corner).epsilon(5e-3));
    // Directional: irradiance E at 60 degrees gives E cos / pi.
    scene.objects.pop_back();
    scene.lights = {{Vec3(2), DirectionalLight{glm::normalize(DVec3(std::sqrt(3.0), 0, -1))}}};
    CHECK(centre() == Approx(2 * 0.5 / 3.14159265).epsilon(1e-3));
    scene.lights = {{Vec3(4), PointLight{DVec3(0, 0, 2)}}};
    CHECK(centre() == Approx(1 / 3.14159265).epsilon(1e-3));
}

TEST_CASE("Many lights together are the sum of each alone", "[render][mis]") {
    const Scene all = [] {
        Scene scene = smallScene(makeObject(makeTorus(48, 24, 0.7F, 0.3F)), ggxMaterial(0.15F, 0.3F), 20);
        scene.lights.push_back({Vec3(20), SphereLight{DVec3(0.8, -0.9, 0.9), 0.1}});
        scene.lights.push_back({Vec3(1), PointLight{DVec3(-1, -1, 0.6)}});
        scene.lights.push_back({Vec3(1), DirectionalLight{glm::normalize(DVec3(0.3, 0.5, -1))}});
        return scene;
    }();
    const auto mean = [](const Scene &scene) {
        const std::vector<float> image = renderImage(scene, 1, 1024);
        double sum = 0;
        for (std::size_t p = 0; p < image.size(); p += 4) sum += static_cast<double>(image[p]);
        return sum / (20 * 20);
    };
    double apart = 0;
    for (std::size_t only = 0; only <= all.lights.size(); ++only) { // the last is the environment
        Scene one = all;
        one.lights.clear();
        if (only < all.lights.size()) {
            one.lights = {all.lights[only]};
            one.environment.reset();
        }
        apart += mean(one);
    }
    CHECK(mean(all) == Approx(apart).epsilon(4e-3));
}

TEST_CASE("A glowing plate close to the ground lights it as its form factor says, however far the camera is", "[render][mis]") {
    // Rays that graze the plate end on it: one that starts off the ground and runs beside the one that was sampled enters it early.
    constexpr double kHeight = 0.02;
    constexpr double kAside = 0.6; // of the square [-0.5, 0.5]^2
    double truth = 0;
    constexpr int kN = 2000;
    for (int i = 0; i < kN; ++i)
        for (int j = 0; j < kN; ++j) {
            const double x = (i + 0.5) / kN - 0.5 - kAside;
            const double y = (j + 0.5) / kN - 0.5;
            truth += sqr(kHeight / (x * x + y * y + kHeight * kHeight)) / (kN * kN * 3.141592653589793);
        }
    Scene scene = smallScene(makeObject(makeGrid(1, 1, 4)), Material{}, 8);
    scene.materials[0].color.value = Vec3(1);
    scene.environment.reset();
    scene.lights.clear();
    scene.render.maxEvents = 1;
    Object plate = makeObject(makeGrid(8, 8, 1));
    plate.placement.translation = DVec3(-kAside, 0, kHeight);
    plate.placement.rotation = DVec3(3.141592653589793, 0, 0);
    plate.emission.value = Vec3(100);
    scene.objects.push_back(plate);
    scene.camera.lookAt = DVec3(0);
    for (const double distance : {0.5, 8.0}) {
        scene.camera.position = DVec3(0, -0.001 * distance, distance);
        scene.camera.fovY = 0.002 / distance;
        const std::vector<float> image = renderImage(scene, 1, 1024);
        double mean = 0;
        for (std::size_t p = 0; p < image.size(); p += 4) mean += static_cast<double>(image[p]) / 64;
        CHECK(mean == Approx(100 * truth).epsilon(0.01));
    }
}

TEST_CASE("Smooth glass in a furnace is invisible", "[render][furnace]") {
    Material glass;
    glass.type = BsdfType::Dielectric;
    glass.alphaX.value = 1e-3F;
    glass.alphaY.value = 1e-3F;
    Scene scene = smallScene(makeObject(makeSphere(128, 64, 0.8F)), glass, 24);
    scene.lights.clear();
    scene.environment = constantEnvironment(Vec3(1));
    scene.render.maxEvents = 64;
    const std::vector<float> image = renderImage(scene, 1, 256);
    double sum = 0;
    for (std::size_t p = 0; p < image.size(); p += 4) sum += static_cast<double>(image[p]);
    CHECK(sum / (24 * 24) == Approx(1).epsilon(3e-3));
}

TEST_CASE("Russian roulette keeps the mean: inside a glowing grey sphere light is a geometric series", "[render][furnace]") {
    constexpr double kAlbedo = 0.5;
    Material grey;
    grey.color.value = Vec3(static_cast<float>(kAlbedo));
    Scene scene = smallScene(makeObject(makeSphere(96, 48, 2)), grey, 16);
    scene.objects[0].emission.value = Vec3(1);
    scene.objects[0].emissionTwoSided = true;
    scene.lights.clear();
    scene.environment = constantEnvironment(Vec3(0));
    scene.camera.position = DVec3(0.3, -0.4, 0.2);
    for (const int events : {3, 5, 8, 20}) { // throughput falls below the roulette's quarter after the second
        scene.render.maxEvents = events;
        const std::vector<float> image = renderImage(scene, 1, 256);
        double sum = 0;
        for (std::size_t p = 0; p < image.size(); p += 4) sum += static_cast<double>(image[p]) / (16 * 16);
        CHECK(sum == Approx((1 - std::pow(kAlbedo, events + 1)) / (1 - kAlbedo)).epsilon(1e-3));
    }
}

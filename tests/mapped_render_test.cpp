/// Pictures of mapped surfaces: the furnace, motions that change nothing, and a million real facets beside the map.

#include "catch.h"
#include "render_fixtures.h"

#include "study/measures/image_error.h"
#include "study/scenes/relief.h"

#include "taut/export/gloss_export.h"
#include "taut/microsurface/mesostructure.h"
#include "taut/microsurface/random_walk.h"

#include <array>
#include <iostream>
#include <random>

using namespace taut;
using namespace taut::test;
using namespace taut::chart;

namespace {

Material mappedMaterial(float alphaX, float alphaY) {
    Material material = ggxMaterial(alphaX, alphaY);
    material.slopes = {SlopeMap::Kind::Normal, 0, 1};
    return material;
}

double relativeError(const std::vector<float> &image, const std::vector<float> &reference) {
    return sqr(chart::relativeRms(coloursOf(image), coloursOf(reference)));
}

/// A mapped white mirror of a sphere that fills the picture.
Scene furnace(Multiscatter treatment, float alpha) {
    Scene scene;
    Object sphere = makeObject(makeSphere(96, 48, 1));
    sphere.mapTangents = true;
    Material material = mappedMaterial(alpha, alpha);
    material.multiscatter = treatment;
    scene.materials = {material};
    scene.textures = {reliefNormals({8, 1}, 256)};
    scene.objects = {sphere};
    scene.environment = constantEnvironment(Vec3(1));
    scene.render.width = scene.render.height = 64;
    scene.render.boxFilter = true;
    scene.render.maxEvents = 1;
    scene.camera.position = DVec3(0, -3, 0);
    scene.camera.orthoHeight = 1.4; // every pixel is on the sphere
    return scene;
}

} // namespace

TEST_CASE("A mapped white mirror in a furnace reflects nearly all of the light, and never more", "[mapped_render]") {
    for (const Multiscatter treatment : {Multiscatter::Walk, Multiscatter::Compensation, Multiscatter::Auto})
        for (const float alpha : {0.1F, 0.4F}) {
            const std::vector<float> image = renderImage(furnace(treatment, alpha), 1, 256);
            double sum = 0;
            float least = 1;
            float greatest = 0;
            for (std::size_t i = 0; i < image.size(); i += 4) {
                sum += static_cast<double>(image[i]);
                least = std::min(least, image[i]);
                greatest = std::max(greatest, image[i]);
            }
            const double mean = sum / (static_cast<double>(image.size()) / 4);
            INFO("treatment " << static_cast<int>(treatment) << ", alpha " << alpha);
            CHECK(mean >= 0.97);
            CHECK(mean <= 1.0015); // the compensation's table
            if (treatment == Multiscatter::Walk) {
                CHECK(least > 0.9999F);
                CHECK(greatest < 1.0001F);
            }
            CHECK(least > 0.8F); // no black pixel: what is missing is noise of the compensation
        }
}

TEST_CASE("A mapped surface of any kind reflects no more than comes", "[mapped_render]") {
    for (const BsdfType type :
         {BsdfType::Diffuse, BsdfType::Coated, BsdfType::MetallicRoughness, BsdfType::Dielectric, BsdfType::ThinGlass}) {
        Scene scene = furnace(Multiscatter::Auto, 0.2F);
        scene.materials[0].type = type;
        scene.materials[0].clearcoat.value = 0.5F;
        scene.materials[0].transmission.value = type == BsdfType::MetallicRoughness ? 0.3F : 0.0F;
        scene.render.maxEvents = bsdfInfo(type).transmits ? 64 : 1;
        const std::vector<float> image = renderImage(scene, 1, 64);
        double sum = 0;
        float least = 1;
        for (std::size_t i = 0; i < image.size(); i += 4) {
            sum += static_cast<double>(image[i]);
            least = std::min(least, image[i]);
        }
        INFO("type " << bsdfInfo(type).name);
        CHECK(sum / (static_cast<double>(image.size()) / 4) <= 1.002);
        CHECK(sum / (static_cast<double>(image.size()) / 4) > 0.75); // some lose as much unmapped, seen at grazing angles
        CHECK(least > 0.2F);                                         // nothing is black
    }
}

TEST_CASE("Uniform scaling changes nothing of a mapped surface where the normal stretches along", "[mapped_render]") {
    const auto picture = [](float scale) {
        Object torus = makeObject(makeTorus(64, 32, 0.7F, 0.25F));
        torus.mapTangents = true;
        if (scale != 1) torus.deformers = {stretchDeformer(DVec3(scale))};
        Material material = mappedMaterial(0.1F, 0.3F);
        material.poisson = -1;
        Scene scene = smallScene(torus, material);
        scene.lights.clear();
        scene.environment = studioEnvironment();
        scene.textures = {reliefNormals({8, 0.6F}, 128)};
        scene.camera.position = DVec3(0.3, -2.2, 1.9) * static_cast<double>(scale);
        return renderImage(scene, 1, 16);
    };
    CHECK(shareOver(picture(1), picture(2), 2e-3F) < 5e-3); // the rounding of a direction may change what a ray meets
}

TEST_CASE("A rigid motion changes nothing of a mapped surface", "[mapped_render]") {
    const auto picture = [](double turn) {
        Object torus = makeObject(makeTorus(64, 32, 0.7F, 0.25F));
        torus.mapTangents = true;
        torus.placement.rotation.keys = {{1, DVec3(0)}, {3, DVec3(0, 0, turn)}};
        Scene scene = smallScene(torus, mappedMaterial(0.1F, 0.3F));
        scene.textures = {reliefNormals({8, 0.6F}, 128)};
        const auto turned = [&](const DVec3 &v) {
            return DVec3(std::cos(turn) * v.x - std::sin(turn) * v.y, std::sin(turn) * v.x + std::cos(turn) * v.y, v.z);
        };
        scene.camera.position = turned(DVec3(0.3, -2.2, 1.9));
        scene.lights = {{Vec3(6, 5, 4), QuadLight{turned(DVec3(-1.5, 1, 1.5)), turned(DVec3(0, 0, 1)), turned(DVec3(1.5, 0, 0)), true}}};
        return renderImage(scene, 3, 16);
    };
    CHECK(shareOver(picture(0), picture(0.7), 2e-3F) < 5e-3);
}

TEST_CASE("Roughening of 0 leaves the bits, and a strain beyond the yield roughens", "[mapped_render]") {
    const auto picture = [&](float roughening, float yield, bool lean) {
        Scene scene = reliefScene(makeGrid(8, 8, 2), {stretchDeformer(DVec3(1.5, 1, 1))}, 0.1F, 16);
        scene.objects[0].lean = lean;
        scene.materials[0].roughening = roughening;
        scene.materials[0].yield = yield;
        return renderImage(scene, 1, 4, {"alpha"});
    };
    CHECK(picture(0, 0, false) == picture(0, 0.3F, false));
    CHECK(picture(0.5F, 2, false)[4] == Approx(0.1F)); // beyond what it is strained: geometry alone
    // A = diag(1.5, 1): e1 = ln 1.5, e2 = 0, eps = 2/sqrt(3) ln 1.5; alpha along x is 0.1 / 1.5.
    const double added = 0.5 * (2 / std::sqrt(3.0) * std::log(1.5) - 0.1);
    for (const bool lean : {false, true}) {
        const std::vector<float> image = picture(0.5F, 0.1F, lean);
        CHECK(image[4] == Approx(std::sqrt(0.01 + added * added)).epsilon(1e-5));
        CHECK(image[5] == Approx(std::sqrt(0.01 / 2.25 + added * added)).epsilon(1e-5));
    }
}

TEST_CASE("A million real facets under stretch and shear look as the map does, and not as bent normals", "[mapped_render]") {
    const Relief waves;
    const Mesh relief = reliefMesh(waves, 724);
    REQUIRE(relief.faceCount() * 2 > 1000000);
    const std::vector<std::vector<DeformerKeys>> motions{
        {},
        {stretchDeformer(DVec3(1.8, 0.8, 1))},
        {stretchDeformer(DVec3(1.5, 1, 0.7))},
        {shearDeformer(0.6)},
        {stretchDeformer(DVec3(1.5, 1, 0.7)), shearDeformer(-0.6), shearDeformer(0.25, 0, 2)},
    };
    constexpr int kSpp = 256;
    constexpr float kAlpha = 0.2F;
    double beyondNoise[2] = {0, 0}; // of the map, of the bent normal
    for (std::size_t i = 0; i < motions.size(); ++i) {
        const auto real = [&](std::uint32_t seed) { return renderImage(reliefScene(relief, motions[i], kAlpha, 96), 1, kSpp, {}, seed); };
        const auto mapped = [&](FacetModel model) {
            Scene scene = mappedReliefScene(waves, motions[i], kAlpha, 96);
            scene.materials[0].facets = model;
            return renderImage(scene, 1, kSpp, {}, 3);
        };
        const std::vector<float> truth = real(1);
        const double noise = relativeError(real(2), truth);
        const double leans = relativeError(mapped(FacetModel::Leans), truth);
        const double bends = relativeError(mapped(FacetModel::Bends), truth);
        std::cout << "motion " << i << ": noise " << noise << ", map " << leans << ", bent normal " << bends << std::endl;
        INFO("motion " << i);
        CHECK(meanOf(truth) > 0.01);
        CHECK(leans < 1.4 * noise); // facets of the relief shade each other a little, which no map knows
        beyondNoise[0] += std::max(0.0, leans - noise);
        beyondNoise[1] += std::max(0.0, bends - noise);
    }
    CHECK(beyondNoise[1] > 5 * beyondNoise[0]);
}

namespace {

/// Slopes of a surface whose heights are Gaussian: random waves about 64 texels long, of standard deviation sigma along each axis.
std::vector<Vec2> gaussianSlopes(int n, double sigma) {
    constexpr int kWavesOfSurface = 64;
    std::vector<Vec2> slopes(static_cast<std::size_t>(n) * static_cast<std::size_t>(n), Vec2(0));
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<std::array<double, 4>> waves; // kx, ky, phase, slope
    double power = 0;
    for (int i = 0; i < kWavesOfSurface; ++i) {
        const double kx = std::round((unit(random) - 0.5) * 32);
        const double ky = std::round((unit(random) - 0.5) * 32);
        waves.push_back({kx, ky, 2 * kPi * unit(random), 1});
        power += 0.25 * (kx * kx + ky * ky);
    }
    const double scale = sigma / std::sqrt(power);
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            DVec2 sum(0);
            for (const auto &[kx, ky, phase, one] : waves)
                sum += DVec2(kx, ky) * (scale * std::cos(kTwoPi * (kx * x + ky * y) / n + phase));
            slopes[static_cast<std::size_t>(y) * static_cast<std::size_t>(n) + static_cast<std::size_t>(x)] = Vec2(sum);
        }
    return slopes;
}

/// Shares of micro-normals in cells of the disk of their slopes, brought to a common scale.
std::vector<double> histogram(const std::vector<Vec3> &normals, double scale) {
    constexpr int kCells = 16;
    std::vector<double> counts(kCells * kCells, 0);
    double sum = 0;
    for (const Vec3 &n : normals) {
        const auto cell = [&](float slope) {
            const double s = static_cast<double>(slope) / scale; // tanh-like: all slopes into (0, 1)
            return std::clamp(static_cast<int>((0.5 + 0.5 * s / std::sqrt(1 + s * s)) * kCells), 0, kCells - 1);
        };
        counts[static_cast<std::size_t>(cell(n.x / n.z) * kCells + cell(n.y / n.z))] += 1;
        sum += 1;
    }
    for (double &c : counts) c /= sum;
    return counts;
}

} // namespace

TEST_CASE("Moments of a million facets give their micro-normals within the fit's known error, deformed as at rest", "[mapped_render]") {
    constexpr int kSide = 1024;
    constexpr double kAlpha = 0.1;
    struct Fit {
        double ratio, variation;
    };
    walk::Random random(9);
    for (const Fit &fit : {Fit{0.25, 0.02}, {0.5, 0.06}, {1, 0.11}, {2, 0.15}, {4, 0.17}}) {
        const std::vector<Vec2> slopes = gaussianSlopes(kSide, fit.ratio * kAlpha);
        SlopeStatistics moments;
        DVec3 second(0);
        for (const Vec2 &s : slopes) second += DVec3(s.x * s.x, s.x * s.y, s.y * s.y) / static_cast<double>(slopes.size());
        moments.covariance = Vec3(second);
        for (const DMat3 &f :
             {surfaceDeformation({1, 0, 0, 1}), surfaceDeformation({1.8, 0, 0, 0.8}), surfaceDeformation({1, 0.9, 0, 1})}) {
            const auto rest = restBlock<double>(kAlpha, kAlpha, DVec2(1, 0));
            // A micro-normal of every facet, from a standard one, which is carried by M^-T; its area counts as the facet's share of the
            // plane.
            const auto normalOf = [&](const GeneralTransform &t) {
                const float r2 = random.uniform();
                const float phi = 2 * kPi * random.uniform();
                const float slope = std::sqrt(r2 / (1 - r2));
                const Vec3 standard(slope * std::cos(phi), slope * std::sin(phi), 1);
                return t.frame.fromLocal(t.micro.inverseTransposed(standard));
            };
            const auto all = mappedTransform(f, moments, rest);
            REQUIRE(all);
            std::vector<Vec3> found;
            std::vector<Vec3> expected;
            for (const Vec2 &s : slopes) {
                const auto facet = mappedTransform(f, {s, Vec3(0)}, rest);
                found.push_back(normalOf(*facet));
                expected.push_back(normalOf(*all));
            }
            const double scale = kAlpha * std::sqrt(1 + 2 * fit.ratio * fit.ratio);
            const auto a = histogram(found, scale);
            const auto b = histogram(expected, scale);
            double variation = 0;
            for (std::size_t i = 0; i < a.size(); ++i) variation += 0.5 * std::fabs(a[i] - b[i]);
            std::cout << "sigma / alpha " << fit.ratio << ": total variation " << variation << ", known " << fit.variation << std::endl;
            CHECK(variation < fit.variation + 0.02);
        }
    }
}

TEST_CASE("Moments at a sample a pixel are nearer to the far picture than the map at as many", "[mapped_render]") {
    constexpr float kAlpha = 0.3F;
    const auto picture = [&](TextureDetail detail, int spp, std::uint32_t seed) {
        Scene scene = mappedReliefScene({64, 0.25F}, {stretchDeformer(DVec3(1.8, 0.8, 1))}, kAlpha, 32);
        scene.materials[0].detail = detail;
        return renderImage(scene, 1, spp, {}, seed);
    };
    const std::vector<float> truth = picture(TextureDetail::Map, 4096, 1);
    const double map = relativeError(picture(TextureDetail::Map, 4, 2), truth);
    const double moments = relativeError(picture(TextureDetail::Moments, 4, 2), truth);
    const double fit = relativeError(picture(TextureDetail::Moments, 1024, 2), truth);
    std::cout << "far, 4 samples: map " << map << ", moments " << moments << ", their fit alone " << fit << std::endl;
    CHECK(moments < map);
    CHECK(std::sqrt(fit) < 0.15);
}

namespace {

/// A map of one texel: slopes (0.3, 0.1) everywhere.
Texture constantNormals() {
    const Vec3 n = 0.5F * glm::normalize(Vec3(0.3F, 0.1F, 1)) + Vec3(0.5F);
    Texture texture;
    texture.name = "constant";
    texture.texels = {n.x, n.y, n.z};
    return texture;
}

/// The slope of the facet that the camera sees in the middle of a plate.
Vec2 seenSlope(Object plate, bool fromBelow = false, double shutter = 0) {
    Scene scene = reliefScene(makeGrid(4, 4, 2), {}, 0.1F, 8);
    plate.materials = {0};
    scene.objects = {std::move(plate)};
    scene.textures = {constantNormals()};
    scene.materials[0].slopes = {SlopeMap::Kind::Normal, 0, 1};
    scene.render.shutter = shutter;
    if (fromBelow) scene.camera.position = DVec3(0, 0, -4);
    const std::vector<float> image = renderImage(scene, 1, 4, {"facet_normal"});
    const float *middle = &image[(4 * 8 + 4) * 7];
    return Vec2(middle[4], middle[5]) / middle[6];
}

Object plainPlate() {
    Object plate = makeObject(makeGrid(4, 4, 2));
    plate.mapTangents = true;
    return plate;
}

} // namespace

TEST_CASE("A map tilts limit surfaces, mirrored UVs, both sides and blurred motion as it tilts a plate", "[mapped_render]") {
    const auto isNear = [](const Vec2 &a, const Vec2 &b) { return glm::length(a - b) < 1e-4F; };
    CHECK(isNear(seenSlope(plainPlate()), {0.3F, 0.1F}));
    CHECK(isNear(seenSlope(plainPlate(), true), {0.3F, 0.1F})); // the same facet, its normal turned over
    Object smooth = plainPlate();
    smooth.subdivision.level = 2;
    CHECK(isNear(seenSlope(smooth), {0.3F, 0.1F}));
    Mesh mirrored = makeGrid(4, 4, 2);
    for (Vec2 &uv : mirrored.uvs) uv.x = -uv.x;
    for (const bool mapTangents : {false, true}) {
        Object plate = makeObject(mirrored);
        plate.mapTangents = mapTangents;
        CHECK(isNear(seenSlope(plate), {-0.3F, 0.1F}));
    }
    // s' = A^-T s.
    for (const double shutter : {0.0, 0.5}) {
        Object stretched = plainPlate();
        stretched.deformers = {stretchDeformer(DVec3(2, 1, 1)), shearDeformer(0.5)};
        CHECK(isNear(seenSlope(stretched, false, shutter), {0.15F, 0.1F - 0.5F * 0.15F}));
        stretched.follow = false; // the map as other renderers have it: in the frame of the deformed tangent
        const Vec2 held = seenSlope(stretched, false, shutter);
        CHECK(glm::length(held) == Approx(std::sqrt(0.1F)).epsilon(1e-4));
    }
}

TEST_CASE("An export's M is roughened as the hit's is", "[mapped_render]") {
    Scene scene = reliefScene(makeGrid(2, 2, 2), {stretchDeformer(DVec3(1.5, 1, 1))}, 0.1F, 8);
    scene.objects[0].lean = false;
    scene.materials[0].roughening = 0.5F;
    scene.materials[0].yield = 0.1F;
    GlossObject gloss;
    prepareGlossObject(scene, scene.objects[0], gloss);
    glossAtFrame(scene, 1, {}, gloss);
    const std::vector<float> image = renderImage(scene, 1, 4, {"alpha"});
    REQUIRE(!gloss.mesh.alpha.empty());
    for (const Vec3 &alpha : gloss.mesh.alpha) {
        CHECK(alpha.x == Approx(image[4]).epsilon(1e-5));
        CHECK(alpha.y == Approx(image[5]).epsilon(1e-5));
    }
}

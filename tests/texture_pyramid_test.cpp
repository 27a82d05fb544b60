/// Textures from afar: means over footprints, moments of slopes, and what a pixel's cone sees of a surface.

#include "catch.h"
#include "render_fixtures.h"

#include "taut/render/ray_cone.h"
#include "taut/scene/texture_pyramid.h"

#include <random>

using namespace taut;
using namespace taut::test;

namespace {

std::vector<float> randomTexels(int count) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(0, 1);
    std::vector<float> texels(static_cast<std::size_t>(count));
    for (float &t : texels) t = unit(random);
    return texels;
}

/// Mean of a channel over columns [x0, x1) and rows [y0, y1) of an image.
double meanOver(const std::vector<float> &texels, int width, int channels, int channel, int x0, int x1, int y0, int y1) {
    double sum = 0;
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) sum += static_cast<double>(texels[static_cast<std::size_t>((y * width + x) * channels + channel)]);
    return sum / ((x1 - x0) * (y1 - y0));
}

/// A checker of 0 and 1, a texel a field.
Texture checker(int side) {
    std::vector<float> texels;
    for (int i = 0; i < side * side; ++i) texels.insert(texels.end(), 3, static_cast<float>((i / side + i % side) % 2));
    Texture texture;
    texture.name = "checker";
    texture.width = texture.height = side;
    texture.texels = std::move(texels);
    return texture;
}

} // namespace

TEST_CASE("The last level of a pyramid is the mean, of images of any size", "[texture_pyramid]") {
    for (const auto &[width, height] : {std::pair(16, 16), {5, 3}, {7, 1}, {1, 12}, {1, 1}}) {
        const std::vector<float> texels = randomTexels(width * height * 2);
        const TexturePyramid pyramid(width, height, 2, texels);
        const std::vector<float> &last = pyramid.texelsOf(pyramid.levels() - 1);
        REQUIRE(last.size() == 2);
        INFO(width << " x " << height);
        for (int c = 0; c < 2; ++c)
            CHECK(last[static_cast<std::size_t>(c)] == Approx(meanOver(texels, width, 2, c, 0, width, 0, height)).epsilon(1e-5));
    }
}

TEST_CASE("A footprint on whole texels is their mean, square or long", "[texture_pyramid]") {
    constexpr int kSide = 16;
    const std::vector<float> texels = randomTexels(kSide * kSide);
    const TexturePyramid pyramid(kSide, kSide, 1, texels);
    const auto place = [](double column, double row) { return Vec2(column / kSide, 1 - row / kSide); };
    const float texel = 1.0F / kSide;
    // Columns 4 to 8, rows 8 to 12.
    const TexturePyramid::Values square = pyramid.mean({}, place(6, 10), {{4 * texel, 0}, {0, 4 * texel}});
    CHECK(square[0] == Approx(meanOver(texels, kSide, 1, 0, 4, 8, 8, 12)).epsilon(1e-5));
    CHECK(pyramid.levelOf({}, {{4 * texel, 0}, {0, 4 * texel}}) == Approx(2));
    // Eight texels of a row, and of a column: several lookups along the long axis, whichever it is called.
    const TexturePyramid::Values row = pyramid.mean({}, place(8, 3.5), {{8 * texel, 0}, {0, texel}});
    CHECK(row[0] == Approx(meanOver(texels, kSide, 1, 0, 4, 12, 3, 4)).epsilon(1e-5));
    const TexturePyramid::Values column = pyramid.mean({}, place(5.5, 8), {{texel, 0}, {0, 8 * texel}});
    CHECK(column[0] == Approx(meanOver(texels, kSide, 1, 0, 5, 6, 4, 12)).epsilon(1e-5));
    // A tile of half the size sees twice as many texels.
    TextureSampler tiled;
    setTextureTransform(tiled, Vec2(0), 0, Vec2(2));
    CHECK(pyramid.levelOf(tiled, {{4 * texel, 0}, {0, 4 * texel}}) == Approx(3));
    CHECK(pyramid.levelOf({}, {{0.5F * texel, 0}, {0, 0.5F * texel}}) == 0);
}

TEST_CASE("Levels of slopes hold their mean and covariance", "[texture_pyramid]") {
    Texture slopes;
    slopes.width = 2;
    slopes.height = 1;
    slopes.channels = 3;
    slopes.texels = {0.5F, 0.2F, 0, -0.3F, 0.4F, 0};
    const auto heights = slopePyramid(slopes, SlopeMap::Kind::Height);
    const std::vector<float> &m = heights->texelsOf(1);
    CHECK(m[0] == Approx(0.1));
    CHECK(m[1] == Approx(0.3));
    CHECK(m[2] - m[0] * m[0] == Approx(0.16));
    CHECK(m[3] - m[0] * m[1] == Approx(-0.04));
    CHECK(m[4] - m[1] * m[1] == Approx(0.01));
    CHECK(meanVariance(*heights, 1) == Approx(0.085));
    // A map of normals holds the same as normals.
    Texture normals = slopes;
    std::vector<float> texels;
    for (const Vec2 s : {Vec2(0.5F, 0.2F), Vec2(-0.3F, 0.4F)}) {
        const Vec3 n = 0.5F * glm::normalize(Vec3(s, 1)) + Vec3(0.5F);
        texels.insert(texels.end(), {n.x, n.y, n.z});
    }
    normals.texels = std::move(texels);
    const auto same = slopePyramid(normals, SlopeMap::Kind::Normal);
    for (std::size_t i = 0; i < 5; ++i) CHECK(same->texelsOf(1)[i] == Approx(m[i]).margin(1e-6));
}

TEST_CASE("A cone's footprint is its width across the view and longer along it, in texture coordinates", "[texture_pyramid]") {
    InterpolatedSurface p{};
    p.e1 = Vec3(2, 0, 0); // metres
    p.e2 = Vec3(0, 4, 0);
    const std::array<Vec2, 3> uvs{Vec2(0.5F, 0.5F), Vec2(1.5F, 0.5F), Vec2(0.5F, 1.5F)}; // a unit of u is 2 m, one of v 4 m
    const float angle = 1.1F;
    const UvFootprint seen = footprintOf(p, Vec3(std::sin(angle), 0, std::cos(angle)), 0.01F, uvs);
    CHECK(std::fabs(seen.major.x) == Approx(0.01 / std::cos(angle) / 2));
    CHECK(std::fabs(seen.major.y) < 1e-7F);
    CHECK(std::fabs(seen.minor.x) < 1e-7F);
    CHECK(std::fabs(seen.minor.y) == Approx(0.01 / 4));
    CameraState camera;
    camera.fovY = 0.5;
    CHECK(pixelCone(camera, 100).widthAt(3) == Approx(3 * 2 * std::tan(0.25) / 100));
    camera.orthoHeight = 2;
    CHECK(pixelCone(camera, 100).widthAt(3) == Approx(0.02));
    RayCone cone{0, 0.01F};
    cone.scatter(3, 0.2F); // a rough surface spreads what is seen by it
    CHECK(cone.widthAt(2) == Approx(0.03 + 2 * 0.21));
}

TEST_CASE("Colours and alpha finer than a pixel are their means where moments are taken, at one sample", "[texture_pyramid]") {
    const auto picture = [](TextureDetail detail) {
        Material material = ggxMaterial(0.3F, 0.3F);
        material.detail = detail;
        material.alphaX.texture = 0; // 0.3 times the checker
        material.color.texture = 0;
        material.type = BsdfType::MetallicRoughness;
        Scene scene = smallScene(makeObject(makeGrid(4, 4, 2)), material, 16);
        scene.textures = {checker(256)};
        scene.camera.position = DVec3(0, 0, 4);
        scene.camera.up = DVec3(0, 1, 0);
        scene.camera.orthoHeight = 1.2;
        return renderImage(scene, 1, 1, {"albedo", "alpha"});
    };
    float spread[2] = {0, 0};
    for (const TextureDetail detail : {TextureDetail::Moments, TextureDetail::Map}) {
        const std::vector<float> image = picture(detail);
        for (std::size_t i = 0; i < image.size(); i += 10) {
            float &greatest = spread[detail == TextureDetail::Map ? 1 : 0];
            greatest = std::max(greatest, std::fabs(image[i + 4] - 0.5F));
            if (detail == TextureDetail::Moments) CHECK(image[i + 8] == Approx(0.15).epsilon(1e-3)); // the lesser alpha
        }
    }
    CHECK(spread[0] < 1e-3F);
    CHECK(spread[1] > 0.3F);
}

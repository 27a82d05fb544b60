/// The denoiser: sums that are exact, pictures of made-up pixels where it can fail, and renders.

#include "catch.h"
#include "output_folder.h"
#include "render_fixtures.h"

#include "study/measures/image_error.h"

#include "taut/base/error.h"
#include "taut/render/denoise_frames.h"

#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <random>
#include <sstream>

using namespace taut;
using namespace taut::test;
using taut::chart::relativeMse;

namespace {

using Features = std::array<float, kDenoiseFeatures>;

/// A made-up pixel: what a sample sees there.
struct Seen {
    Vec3 colour{0};
    float noise = 0;  ///< of a sample, relative: uniform within
    bool hits = true; ///< a surface
    Features features{};
};

Features flat(float albedo = 0.5F) {
    Features f{};
    f[kNormal + 2] = 1;
    for (int c = 0; c < 3; ++c) f[static_cast<std::size_t>(kAlbedo + c)] = albedo;
    return f;
}

/// A film of made-up pixels. `share`: which of the samples it gets, [first, last).
Film filmOf(const Window &window, int spp, unsigned seed, const std::function<Seen(int x, int y)> &see, int first = 0, int last = -1) {
    Film film(window, {}, {}, denoiseBlockOf(spp, true));
    for (int y = window.y0; y < window.y1; ++y)
        for (int x = window.x0; x < window.x1; ++x) {
            const Seen seen = see(x, y);
            std::mt19937 random(seed * 7919U + static_cast<unsigned>(y * 1000 + x));
            std::uniform_real_distribution<float> uniform(-1, 1);
            for (int s = 0; s < spp; ++s) {
                const Vec3 radiance = seen.colour * (1 + seen.noise * uniform(random));
                if (s < first || (last >= 0 && s >= last)) continue;
                film.add(x, y, radiance, seen.hits ? 1.0F : 0.0F, nullptr);
                film.denoiseSums()->add(x, y, static_cast<std::uint32_t>(s), radiance, seen.hits);
            }
            FeatureMeans means;
            if (!seen.hits)
                means.addNothing(false, false);
            else if (means.addHit(0, 1))
                means.tell(seen.features.data(), true);
            film.denoiseSums()->tell(x, y, means.rounded(false));
        }
    return film;
}

float at(const Denoised &d, const Window &w, int x, int y, int c = 0) {
    return d.rgb[3 * static_cast<std::size_t>((y - w.y0) * w.width() + x - w.x0) + static_cast<std::size_t>(c)];
}

bool isWhole(const Denoised &d, const Window &w) {
    const auto pixels = static_cast<std::size_t>(w.width()) * static_cast<std::size_t>(w.height());
    bool whole = d.rgb.size() == 3 * pixels && d.error.size() == pixels;
    for (const float v : d.rgb) whole &= std::isfinite(v) && v >= 0;
    for (const float v : d.error) whole &= std::isfinite(v) && v >= 0;
    return whole;
}

std::vector<float> noisyOf(const Film &film) {
    const std::vector<float> values = film.resolve();
    std::vector<float> rgb;
    for (std::size_t i = 0; i < values.size(); i += 4)
        for (std::size_t c = 0; c < 3; ++c) rgb.push_back(values[i + c]);
    return rgb;
}

/// A lobe, long along one axis and narrow across it, askew; peak 200 on a ground of 0.1, HDR.
float lobe(int x, int y, double longWidth = 9, double shortWidth = 2.5) {
    const double u = (x - 24) * 0.8 + (y - 24) * 0.6;
    const double v = -(x - 24) * 0.6 + (y - 24) * 0.8;
    return static_cast<float>(0.1 + 200 * std::exp(-0.5 * (u * u / (longWidth * longWidth) + v * v / (shortWidth * shortWidth))));
}

/// Features of a flat plate whose lobe that is: the half vector moves with the pixel, and so much of it is one unit of the lobe.
Features plate(int x, int y) {
    Features f = flat(1);
    f[kHalfway] = 0.005F * static_cast<float>(x);
    f[kHalfway + 1] = 0.005F * static_cast<float>(y);
    const float w1 = 1 / (0.09F * 0.09F);
    const float w2 = 1 / (0.025F * 0.025F);
    f[kGloss] = w1 * 0.64F + w2 * 0.36F;
    f[kGloss + 1] = (w1 - w2) * 0.48F;
    f[kGloss + 3] = w1 * 0.36F + w2 * 0.64F;
    return f;
}

/// Long and short standard deviations of a picture's squares, and its sum.
std::array<double, 3> widths(const std::function<double(int, int)> &light, int size) {
    double sum = 0, plain = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    for (int v = 0; v < size; ++v)
        for (int u = 0; u < size; ++u) {
            const double l = light(u, v);
            plain += l;
            sum += l * l;
            x += l * l * u;
            y += l * l * v;
            xx += l * l * u * u;
            xy += l * l * u * v;
            yy += l * l * v * v;
        }
    xx = xx / sum - x * x / sum / sum;
    xy = xy / sum - x * y / sum / sum;
    yy = yy / sum - y * y / sum / sum;
    const double apart = std::hypot((xx - yy) / 2, xy);
    return {std::sqrt((xx + yy) / 2 + apart), std::sqrt((xx + yy) / 2 - apart), plain};
}

Film renderedFilm(const RenderScene &ready, int spp, int first, int count, const Window &window = {}, std::uint32_t seed = 1) {
    FrameOptions options;
    options.spp = count;
    options.firstSample = first;
    options.window = window;
    options.seed = seed;
    options.denoiseBlock = denoiseBlockOf(spp, true);
    return renderFrame(ready, options).film;
}

} // namespace

TEST_CASE("denoise: sums are the same for any split, and come back as they were saved", "[denoise]") {
    const Window window{3, 2, 11, 9};
    const auto see = [](int x, int y) {
        Seen seen{Vec3(static_cast<float>(x), 0.5F, 1e4F), 0.7F, (x + y) % 3 != 0, flat()};
        seen.features[kDepth] = static_cast<float>(y) - 5;
        return seen;
    };
    const Film whole = filmOf(window, 24, 1, see);
    Film parts = filmOf(window, 24, 1, see, 9, 24);
    parts.merge(filmOf(window, 24, 1, see, 0, 9));
    CHECK(parts == whole);
    Film upper = filmOf({3, 2, 11, 6}, 24, 1, see);
    upper.merge(filmOf({3, 6, 11, 9}, 24, 1, see));
    CHECK(upper == whole);
    CHECK(denoise(upper).rgb == denoise(whole).rgb);

    std::stringstream saved;
    whole.save(saved);
    CHECK(Film::load(saved) == whole);
    const std::string bytes = saved.str();
    for (const std::size_t size : {bytes.size() - 1, bytes.size() - 100, bytes.size() / 2}) {
        std::istringstream cut(bytes.substr(0, size));
        CHECK_THROWS_AS(Film::load(cut), InputError);
    }
    // A film that is not denoised is what it was: no sums, no trace in its file.
    Film plain(window, {});
    std::ostringstream plainBytes;
    plain.save(plainBytes);
    CHECK(plainBytes.str().find("denoise") == std::string::npos);
    CHECK_THROWS_AS(plain.merge(whole), InputError);
    CHECK_THROWS_AS(denoise(plain), InputError);
    Film otherBlocks(window, {}, {}, 5);
    CHECK_THROWS_AS(otherBlocks.merge(whole), InputError);
}

TEST_CASE("denoise: halves are dealt in blocks, neighbours begin with different ones, and both are as large", "[denoise]") {
    for (const int spp : {1, 2, 3, 4, 7, 16, 64}) {
        const DenoiseSums sums({0, 0, 2, 2}, denoiseBlockOf(spp, true));
        int second = 0;
        for (std::uint32_t s = 0; s < static_cast<std::uint32_t>(spp); ++s) {
            CHECK(sums.inSecondHalf(0, 0, s) != sums.inSecondHalf(1, 0, s));
            CHECK(sums.inSecondHalf(0, 0, s) == sums.inSecondHalf(1, 1, s));
            second += sums.inSecondHalf(0, 0, s) ? 1 : 0;
        }
        CHECK(second == spp / 2);
    }
}

TEST_CASE("denoise: pictures of any size, place and number of samples", "[denoise]") {
    const auto see = [](int x, int y) { return Seen{Vec3(1, 2, 3) * static_cast<float>(1 + (x + y) % 2), 0.5F, true, flat()}; };
    for (const Window &window : {Window{0, 0, 1, 1}, Window{5, 7, 6, 30}, Window{100, 3, 140, 4}, Window{17, 9, 50, 41}})
        for (const int spp : {1, 2, 3, 4, 9}) {
            const Denoised d = denoise(filmOf(window, spp, 3, see));
            CHECK(isWhole(d, window));
        }
    // Pixels that have no sample yet.
    const Window window{0, 0, 20, 20};
    Film film(window, {}, {}, 4);
    film.merge(filmOf({0, 0, 20, 10}, 8, 1, see));
    const Denoised d = denoise(film);
    CHECK(isWhole(d, window));
    CHECK(at(d, window, 5, 15) == 0);
    CHECK(denoise(Film({}, {}, {}, 1)).rgb.empty());
}

TEST_CASE("denoise: what has no noise stays as it is", "[denoise]") {
    const Window window{0, 0, 40, 30};
    const auto stays = [&](const std::function<Seen(int, int)> &see) {
        const Film film = filmOf(window, 8, 1, see);
        const Denoised d = denoise(film);
        const std::vector<float> before = noisyOf(film);
        for (std::size_t i = 0; i < before.size(); ++i)
            if (!(std::fabs(d.rgb[i] - before[i]) <= 1e-4F * before[i])) return false;
        return true;
    };
    CHECK(stays([](int, int) { return Seen{Vec3(0), 0, false, {}}; })); // nothing there
    CHECK(stays([](int, int) { return Seen{Vec3(0.3F), 0, true, flat()}; }));
    CHECK(stays([](int x, int y) { return Seen{Vec3(x % 7 == 3 && y % 5 == 2 ? 500.0F : 0.1F), 0, true, flat()}; })); // sparks
    CHECK(stays([](int x, int) { return Seen{Vec3(x < 20 ? 1.0F : 100.0F), 0, true, flat()}; }));
}

TEST_CASE("denoise: an edge against nothing bleeds neither way", "[denoise]") {
    const Window window{0, 0, 32, 32};
    const Denoised d = denoise(filmOf(window, 8, 2, [](int x, int) {
        return x < 16 ? Seen{Vec3(5), 0.9F, true, flat()} : Seen{Vec3(0), 0, false, {}};
    }));
    double inside = 0;
    for (int y = 0; y < 32; ++y) {
        for (int x = 16; x < 32; ++x) CHECK(at(d, window, x, y) < 1e-3F);
        inside += static_cast<double>(at(d, window, 15, y)) / 32;
    }
    CHECK(inside == Approx(5).epsilon(0.05));
}

TEST_CASE("denoise: one bright sample neither stays nor spreads", "[denoise]") {
    const Window window{0, 0, 33, 33};
    Film film = filmOf(window, 16, 5, [](int, int) { return Seen{Vec3(1), 0.5F, true, flat()}; });
    film.add(16, 16, Vec3(1e5F), 1, nullptr);
    film.denoiseSums()->add(16, 16, 0, Vec3(1e5F), true);
    const Denoised d = denoise(film);
    for (int y = 0; y < 33; ++y)
        for (int x = 0; x < 33; ++x) CHECK(at(d, window, x, y) == Approx(1).margin(0.25));
}

TEST_CASE("denoise: a bright highlight keeps its light and both its widths", "[denoise]") {
    const Window window{0, 0, 48, 48};
    const auto truth = widths([](int x, int y) { return static_cast<double>(lobe(x, y)); }, 48);
    for (const float noise : {0.3F, 0.9F}) {
        const Film film = filmOf(window, 16, 9, [&](int x, int y) { return Seen{Vec3(lobe(x, y)), noise, true, plate(x, y)}; });
        const Denoised d = denoise(film);
        const auto got = widths([&](int x, int y) { return static_cast<double>(at(d, window, x, y)); }, 48);
        for (std::size_t k = 0; k < 3; ++k) CHECK(got[k] == Approx(truth[k]).epsilon(0.03));
        std::vector<float> right;
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 48; ++x)
                for (int c = 0; c < 3; ++c) right.push_back(lobe(x, y));
        CHECK(relativeMse(d.rgb, right) <
              (noise < 0.5F ? 0.85 : 0.5) * relativeMse(noisyOf(film), right)); // little is to be gained beside that edge
    }
}

TEST_CASE("denoise: a render comes closer to many samples, and its light is kept", "[denoise]") {
    RenderScene ready(smallScene(shearedTorus(64, 32), ggxMaterial(0.1F, 0.4F)), false);
    ready.setFrame(2);
    FrameOptions many;
    many.spp = 1024;
    many.seed = 77;
    const std::vector<float> truth = noisyOf(renderFrame(ready, many).film);
    for (const int spp : {4, 16}) {
        const Film film = renderedFilm(ready, spp, 0, spp);
        const Denoised d = denoise(film);
        CHECK(relativeMse(d.rgb, truth) < 0.5 * relativeMse(noisyOf(film), truth));
        CHECK(chart::meanOf(d.rgb) == Approx(chart::meanOf(truth)).epsilon(0.03));
    }
}

TEST_CASE("denoise: the same bits for any threads and any split, and the picture beneath is the ordinary one", "[denoise]") {
    Scene scene = smallScene(shearedTorus(32, 16), ggxMaterial(0.05F, 0.3F), 40);
    RenderScene ready(scene, false);
    ready.setFrame(2);
    const Film whole = renderedFilm(ready, 6, 0, 6);
    const Denoised all = denoise(whole);
    {
        const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        CHECK(denoise(renderedFilm(ready, 6, 0, 6)).rgb == all.rgb);
    }
    Film split = renderedFilm(ready, 6, 4, 2);
    split.merge(renderedFilm(ready, 6, 0, 4));
    CHECK(split == whole);
    const Denoised merged = denoise(split);
    CHECK(merged.rgb == all.rgb);
    CHECK(merged.error == all.error);
    CHECK(noisyOf(whole) == noisyOf([&] {
              FrameOptions plain;
              plain.spp = 6;
              plain.seed = 1;
              return renderFrame(ready, plain).film;
          }()));

    // Stopped on the way, gone on with elsewhere.
    FrameOptions options;
    options.spp = 6;
    options.seed = 1;
    options.denoiseBlock = denoiseBlockOf(6, true);
    FrameRender begun(ready, options);
    begun.advance({2, 0});
    std::stringstream saved;
    begun.save(saved);
    FrameRender resumed(ready, options);
    resumed.restore(saved);
    resumed.advance();
    CHECK(resumed.filmAtRest() == whole);
    options.denoiseBlock = 0;
    FrameRender plain(ready, options);
    saved.seekg(0);
    CHECK_THROWS_AS(plain.restore(saved), InputError);
}

TEST_CASE("denoise: what pixels see is told alike by crops and shards, and an outline is covered as it is", "[denoise]") {
    Scene scene = smallScene(shearedTorus(64, 32), ggxMaterial(0.1F, 0.4F), 40);
    scene.environment.reset();
    RenderScene ready(scene, false);
    ready.setFrame(2);
    const Film whole = renderedFilm(ready, 4, 0, 4);
    const Window part{9, 3, 30, 26};
    const Film crop = renderedFilm(ready, 4, 2, 2, part);
    const Film many = renderedFilm(ready, 1024, 0, 1024);
    for (int y = part.y0; y < part.y1; ++y)
        for (int x = part.x0; x < part.x1; ++x) CHECK(crop.denoiseSums()->featuresAt(x, y) == whole.denoiseSums()->featuresAt(x, y));
    double probed = 0, sampled = 0;
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 40; ++x) {
            const PixelFeatures &f = whole.denoiseSums()->featuresAt(x, y);
            const double truth = many.sumAt(x, y, 3).value() / 1024;
            const double cover = static_cast<double>(f.covered) / static_cast<double>(PixelFeatures::kWhole);
            if (f.edge == 0) CHECK(std::fabs(cover - truth) < 0.01);
            if (f.edge == 0 || truth == 0 || truth == 1) continue;
            probed += std::pow(cover - truth, 2);
            sampled += std::pow(whole.sumAt(x, y, 3).value() / 4 - truth, 2);
        }
    CHECK(sampled > 0.1);
    CHECK(probed < 0.2 * sampled);
}

TEST_CASE("denoise: the motion of a surface is where its points were", "[denoise]") {
    Scene scene = smallScene(makeObject(makeGrid(8, 8, 4)), ggxMaterial(0.3F, 0.3F), 32);
    scene.camera.position = DVec3(0, 0, 4);
    scene.camera.up = DVec3(0, 1, 0);
    scene.camera.orthoHeight = 3.2; // ten pixels a metre
    DeformerKeys shear;
    shear.type = DeformerType::Shear;
    shear.axis = 0;
    shear.axis2 = 1;
    shear.amount.keys = {{1, 0.0}, {2, 0.5}};
    scene.objects[0].deformers = {shear};
    RenderScene ready(scene, true);
    ready.setFrame(1);
    const FrameBefore before(ready);
    ready.setFrame(2);
    FrameOptions options;
    options.spp = 4;
    options.denoiseBlock = 2;
    options.before = &before;
    const Film film = renderFrame(ready, options).film;
    const DenoisePixels p = denoisePixelsOf(film, film.window());
    for (const auto &[x, y] : {std::pair(16, 16), std::pair(16, 4), std::pair(10, 26)}) {
        const auto i = static_cast<std::size_t>(y * 32 + x);
        CHECK(p.moving[i] == 1);
        const double height = (16 - (y + 0.5)) / 10; // metres, upwards: x has moved by half of it
        CHECK(static_cast<double>(p.motion[0][i]) == Approx(-0.5 * height * 10).margin(0.3));
        CHECK(static_cast<double>(p.motion[1][i]) == Approx(0).margin(0.01));
    }
}

TEST_CASE("denoise: frames before lower the error of what stays, and leave no ghost of what moved", "[denoise]") {
    const Window window{0, 0, 48, 48};
    const auto truthAt = [](int frame, int x, int y) { return 1 + (std::abs(x - 6 * frame) < 4 && y > 20 ? 30.0F : 0.0F); };
    double alone = 0;
    double over = 0;
    double aloneGhost = 0;
    double overGhost = 0;
    FrameDenoiser frames(true);
    for (int frame = 1; frame <= 6; ++frame) {
        // A light that passes over a surface that stands still: motion says nothing of it.
        const Film film = filmOf(window, 4, static_cast<unsigned>(100 + frame), [&](int x, int y) {
            return Seen{Vec3(truthAt(frame, x, y)), 0.9F, true, flat()};
        });
        const Denoised one = denoise(film);
        const Denoised all = frames.next(film);
        if (frame < 3) continue;
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 48; ++x) {
                const double truth = static_cast<double>(truthAt(frame, x, y));
                const double e1 = std::pow(static_cast<double>(at(one, window, x, y)) - truth, 2);
                const double e2 = std::pow(static_cast<double>(at(all, window, x, y)) - truth, 2);
                (y > 16 ? aloneGhost : alone) += e1;
                (y > 16 ? overGhost : over) += e2;
            }
    }
    CHECK(over < 0.85 * alone);
    CHECK(overGhost < 1.02 * aloneGhost);
}

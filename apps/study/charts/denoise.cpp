/// taut chart denoise: pictures before and after the denoiser against 4,096 samples, at the same number of samples and at the same time;
/// widths of a highlight; flicker; time and memory. The environment variable TAUT_REFERENCES names a folder where the references of the
/// errors are kept for the next run; they take most of the time.

#include "study/charts.h"
#include "study/drawing/pictures.h"
#include "study/measures/flip.h"
#include "study/measures/image_error.h"
#include "study/measures/memory.h"
#include "study/measures/render_image.h"
#include "study/scenes/denoise_scenes.h"
#include "study/text.h"

#include "taut/base/stopwatch.h"
#include "taut/render/denoise_frames.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>

namespace taut::chart {

namespace {

constexpr int kReference = 4096;
constexpr std::uint32_t kReferenceSeed = 1000;
const std::vector<int> kSamples{4, 16, 64};

/// A picture by a number of samples, noisy and denoised; the least times of some runs.
struct Taken {
    Pixels noisy, denoised;
    double plain = 0;  ///< seconds of rendering for the noisy picture alone
    double kept = 0;   ///< with what denoising needs beside it
    double filter = 0; ///< seconds of denoising
};

Pixels coloursOf(const Film &film) {
    const std::vector<float> values = film.resolve(); // R G B A
    Pixels rgb;
    for (std::size_t i = 0; i < values.size(); i += 4)
        rgb.insert(rgb.end(), values.begin() + static_cast<std::ptrdiff_t>(i), values.begin() + static_cast<std::ptrdiff_t>(i) + 3);
    return rgb;
}

FrameOptions optionsOf(int spp, std::uint32_t seed, bool denoises) {
    FrameOptions options;
    options.spp = spp;
    options.seed = seed;
    if (denoises) options.denoiseBlock = denoiseBlockOf(spp, true);
    return options;
}

Taken take(const RenderScene &ready, int spp, int runs) {
    Taken taken;
    taken.plain = taken.kept = taken.filter = std::numeric_limits<double>::infinity();
    for (int run = 0; run < runs; ++run) {
        Stopwatch watch;
        renderFrame(ready, optionsOf(spp, 1, false));
        taken.plain = std::min(taken.plain, watch.lap());
        const FrameResult result = renderFrame(ready, optionsOf(spp, 1, true));
        taken.kept = std::min(taken.kept, watch.lap());
        taken.denoised = denoise(result.film).rgb;
        taken.filter = std::min(taken.filter, watch.lap());
        taken.noisy = coloursOf(result.film);
    }
    return taken;
}

/// The reference, or what an earlier run kept of it: floats, R G B, rows from the top.
Pixels referenceOf(const RenderScene &ready, const std::string &name) {
    const RenderSettings &render = ready.scene().render;
    const char *folder = std::getenv("TAUT_REFERENCES");
    const std::string path =
        folder == nullptr ? "" : printed("%s/%s_%dx%d_%d.raw", folder, fileNameOf(name).c_str(), render.width, render.height, kReference);
    Pixels truth(3 * static_cast<std::size_t>(render.width) * static_cast<std::size_t>(render.height));
    const auto bytes = static_cast<std::streamsize>(truth.size() * sizeof(float));
    if (folder != nullptr)
        if (std::ifstream in(path, std::ios::binary); in.read(reinterpret_cast<char *>(truth.data()), bytes)) return truth;
    truth = renderReady(ready, kReference, kReferenceSeed).values;
    if (folder != nullptr) std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char *>(truth.data()), bytes);
    return truth;
}

double meanFlip(const Pixels &image, const Pixels &reference, const RenderSettings &render) {
    return meanOf(flip(image, reference, render.width, render.height));
}

/// Errors of every scene, and the worst of them.
void addErrors(const ChartOptions &options, Chart &chart) {
    Table table{"errors",
                printed("relMSE and FLIP against %d samples: noisy, noisy in the time of the denoised one, denoised", kReference),
                {"scene", "pixels", "spp", "relMSE", "same time (spp)", "denoised", "of same time", "FLIP", "same time", "denoised"},
                {}};
    Panel panel = lines({"ratio",
                         "relMSE of the denoised picture over that of more samples in the same time",
                         "all threads",
                         {"samples a pixel", ""},
                         {"ratio of relMSE", ""},
                         {}});
    for (const DenoiseScene &entry : denoiseScenes()) {
        RenderScene ready(atWidth(entry.make(), entry.width * options.pick(1, 2)), false);
        ready.setFrame(entry.frame);
        const RenderSettings &render = ready.scene().render;
        const Pixels truth = referenceOf(ready, entry.name);
        std::vector<Pixels> strip;
        for (const int spp : kSamples) {
            const Taken taken = take(ready, spp, spp > 4 ? 1 : 3);
            const int same = std::max(spp, static_cast<int>(std::lround(spp * (taken.kept + taken.filter) / taken.plain)));
            const Pixels longer = coloursOf(renderFrame(ready, optionsOf(same, 1, false)).film);
            const double ratio = relativeMse(taken.denoised, truth) / relativeMse(longer, truth);
            table.rows.push_back({entry.name, printed("%d x %d", render.width, render.height), std::to_string(spp),
                                  printed("%.2e", relativeMse(taken.noisy, truth)), printed("%.2e (%d)", relativeMse(longer, truth), same),
                                  printed("%.2e", relativeMse(taken.denoised, truth)), printed("%.3f", ratio),
                                  printed("%.4f", meanFlip(taken.noisy, truth, render)), printed("%.4f", meanFlip(longer, truth, render)),
                                  printed("%.4f", meanFlip(taken.denoised, truth, render))});
            panel.points.push_back({entry.name, "", {static_cast<double>(spp)}, {ratio}});
            if (spp == kSamples.front()) strip = {taken.noisy, taken.denoised, truth};
        }
        chart.pictures.push_back(
            writeStrip(options.directory, "denoise_" + fileNameOf(entry.name),
                       entry.name + ": 4 samples a pixel, the same denoised, " + std::to_string(kReference) + " samples", strip,
                       render.width, exposureOf(truth), 2));
    }
    chart.panels.push_back(std::move(panel));
    chart.tables.push_back(std::move(table));
}

/// Standard deviations of a highlight along its long and its short axis, pixels: of luminance squared, which the lobe's tails do not reach.
struct Widths {
    double along = 0, across = 0;
    double light = 0; ///< sum of luminance
};
Widths widthsOf(const Pixels &image, int width) {
    double sum = 0;
    double x = 0;
    double y = 0;
    Widths widths;
    const auto each = [&](const auto &use) {
        for (std::size_t i = 0; i < image.size() / 3; ++i) {
            const double l = 0.2126 * static_cast<double>(image[3 * i]) + 0.7152 * static_cast<double>(image[3 * i + 1]) +
                             0.0722 * static_cast<double>(image[3 * i + 2]);
            use(l, static_cast<double>(i % static_cast<std::size_t>(width)), static_cast<double>(i / static_cast<std::size_t>(width)));
        }
    };
    each([&](double l, double u, double v) {
        widths.light += l;
        sum += l * l;
        x += l * l * u;
        y += l * l * v;
    });
    double xx = 0;
    double xy = 0;
    double yy = 0;
    each([&](double l, double u, double v) {
        xx += l * l * (u - x / sum) * (u - x / sum) / sum;
        xy += l * l * (u - x / sum) * (v - y / sum) / sum;
        yy += l * l * (v - y / sum) * (v - y / sum) / sum;
    });
    const double middle = (xx + yy) / 2;
    const double apart = std::hypot((xx - yy) / 2, xy);
    widths.along = std::sqrt(middle + apart);
    widths.across = std::sqrt(middle - apart);
    return widths;
}

void addHighlight(const ChartOptions &options, Chart &chart) {
    const int width = options.pick(96, 160);
    Table table{"highlight",
                "A highlight on a stretched, sheared anisotropic plate: widths along its axes in pixels, their ratios to the reference's, "
                "its light",
                {"picture", "long", "short", "long, ratio", "short, ratio", "light, ratio"},
                {}};
    RenderScene ready(highlightScene(width), false);
    ready.setFrame(1);
    const Pixels truth = renderReady(ready, kReference, kReferenceSeed).values;
    const Widths right = widthsOf(truth, width);
    const auto add = [&](const std::string &name, const Pixels &image) {
        const Widths w = widthsOf(image, width);
        table.rows.push_back({name, printed("%.3f", w.along), printed("%.3f", w.across), printed("%.4f", w.along / right.along),
                              printed("%.4f", w.across / right.across), printed("%.4f", w.light / right.light)});
    };
    add(std::to_string(kReference) + " samples", truth);
    std::vector<Pixels> strip;
    for (const int spp : kSamples) {
        const Taken taken = take(ready, spp, 1);
        add(std::to_string(spp) + " samples", taken.noisy);
        add(std::to_string(spp) + ", denoised", taken.denoised);
        if (strip.empty()) strip = {taken.noisy, taken.denoised, truth};
    }
    chart.pictures.push_back(writeStrip(options.directory, "denoise_highlight",
                                        "The highlight: 4 samples a pixel, the same denoised, the reference", strip, width,
                                        exposureOf(truth), 2));
    chart.tables.push_back(std::move(table));
}

/// Frames whose gloss, and highlight, moves: the error's change from frame to frame, relative to the mean light.
void addFlicker(const ChartOptions &options, Chart &chart) {
    constexpr int kFrames = 24;
    const int reference = options.pick(512, kReference);
    Table table{
        "flicker",
        printed("Flicker over %d frames: RMS change of the error from frame to frame over the mean light; relMSE of all frames; against "
                "%d samples",
                kFrames, reference),
        {"scene", "spp", "flicker, noisy", "each frame denoised", "over frames", "relMSE, noisy", "each frame", "over frames"},
        {}};
    for (const DenoiseScene &entry : movingScenes()) {
        RenderScene ready(atWidth(entry.make(), 96 * options.pick(1, 2)), true);
        std::vector<Pixels> truths;
        for (const int spp : {4, 16}) {
            FrameDenoiser alone(false);
            FrameDenoiser over(true);
            std::vector<Pixels> last(3);
            double flicker[3] = {0, 0, 0};
            double errors[3] = {0, 0, 0};
            double light = 0;
            std::optional<FrameBefore> before;
            for (int frame = 1; frame <= kFrames; ++frame) {
                if (frame > 1) before.emplace(ready);
                ready.setFrame(frame);
                const auto index = static_cast<std::size_t>(frame - 1);
                if (truths.size() <= index) truths.push_back(renderReady(ready, reference, frameSeed(kReferenceSeed, frame, false)).values);
                FrameOptions asked = optionsOf(spp, frameSeed(1, frame, false), true);
                asked.before = before ? &*before : nullptr;
                const Film film = renderFrame(ready, asked).film;
                const std::vector<Pixels> images{coloursOf(film), alone.next(film).rgb, over.next(film).rgb};
                light += meanOf(truths[index]) / kFrames;
                for (std::size_t k = 0; k < 3; ++k) {
                    errors[k] += relativeMse(images[k], truths[index]) / kFrames;
                    Pixels error = images[k];
                    double sum = 0;
                    for (std::size_t i = 0; i < error.size(); ++i) {
                        error[i] -= truths[index][i];
                        if (frame > 1) sum += static_cast<double>((error[i] - last[k][i]) * (error[i] - last[k][i]));
                    }
                    flicker[k] += sum / static_cast<double>(error.size()) / (kFrames - 1);
                    last[k] = std::move(error);
                }
            }
            table.rows.push_back({entry.name, std::to_string(spp), printed("%.4f", std::sqrt(flicker[0]) / light),
                                  printed("%.4f", std::sqrt(flicker[1]) / light), printed("%.4f", std::sqrt(flicker[2]) / light),
                                  printed("%.2e", errors[0]), printed("%.2e", errors[1]), printed("%.2e", errors[2])});
        }
    }
    chart.tables.push_back(std::move(table));
}

void addCosts(const ChartOptions &options, Chart &chart) {
    const int width = options.pick(384, 1024);
    Table table{"costs",
                printed("Time and memory a megapixel, all threads, at %d pixels wide", width),
                {"scene", "spp", "render, s", "with sums kept, s", "denoising, s", "film, MB", "with sums, MB", "while denoising, MB more"},
                {}};
    for (const DenoiseScene &entry : denoiseScenes()) {
        if (entry.name != "area light" && entry.name != "panel") continue;
        RenderScene ready(atWidth(entry.make(), width), false);
        ready.setFrame(entry.frame);
        const RenderSettings &render = ready.scene().render;
        const double megapixels = 1e-6 * render.width * render.height;
        const auto filmMegabytes = [&](bool denoises) {
            const double before = allocatedMegabytes();
            const Film film({0, 0, render.width, render.height}, {}, {}, denoises ? 2 : 0);
            return (allocatedMegabytes() - before) / megapixels;
        };
        const Taken taken = take(ready, 4, 3);
        const Film film = renderFrame(ready, optionsOf(4, 1, true)).film;
        resetPeak();
        const double before = peakMegabytes();
        denoise(film);
        const double more = (peakMegabytes() - before) / megapixels;
        table.rows.push_back({entry.name, "4", printed("%.2f", taken.plain / megapixels), printed("%.2f", taken.kept / megapixels),
                              printed("%.2f", taken.filter / megapixels), printed("%.0f", filmMegabytes(false)),
                              printed("%.0f", filmMegabytes(true)), printed("%.0f", more)});
    }
    chart.tables.push_back(std::move(table));
}

} // namespace

Chart measureDenoise(const ChartOptions &options) {
    Chart chart{
        "denoise", "Denoising",
        "Pictures before and after denoising, and noisy pictures that were given the time of the denoised one, against the same plan's "
        "at 4,096 samples with another seed.",
        "Below 1 the denoised picture is the better one in the same time."};
    addErrors(options, chart);
    addHighlight(options, chart);
    addFlicker(options, chart);
    addCosts(options, chart);
    return chart;
}

} // namespace taut::chart

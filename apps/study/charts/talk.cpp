/// The figures of the talk that the project began with (CEDEC 2023, after "Microsurface Transformations"), made by this code.

#include "study/charts.h"
#include "study/drawing/pictures.h"
#include "study/measures/image_error.h"
#include "study/measures/render_image.h"
#include "study/measures/timing.h"
#include "study/microsurface/micro_geometry.h"
#include "study/scenes/scenes.h"
#include "study/scenes/talk_ball.h"
#include "study/text.h"

namespace taut::chart {

namespace {

constexpr int kBall = 112; ///< pixels
constexpr float kBallAlpha = 0.5F;

using RenderBall = std::function<Pixels(int spp, std::uint32_t seed)>;
template <class Scatter> RenderBall ballOf(const Scatter &scatter, const Environment &sky) {
    return [scatter, &sky](int spp, std::uint32_t seed) { return renderBall(scatter, sky, kBall, spp, seed); };
}

/// A ball's relMSE against `truth`, timed with others.
Choice choiceOf(const std::string &series, const RenderBall &render, int spp, const Pixels &truth, bool isDefault = false) {
    return {series, std::to_string(spp) + " spp", isDefault,
            [&render, spp, &truth](std::uint32_t seed) { return relativeMse(render(spp, seed), truth); }};
}

Panel ballPanel(const std::string &name, const std::string &title, const std::string &conditions, const std::vector<Choice> &choices,
                int rounds) {
    Panel panel{name, title, conditions, {"time of the picture", "s"}, {"relMSE", ""}, timeChoices(choices, rounds, Threads::All)};
    panel.joined = true;
    std::stable_sort(panel.points.begin(), panel.points.end(), [](const Point &a, const Point &b) { return a.series < b.series; });
    return panel;
}

/// All normals against visible ones: equal time; and masking off against on.
void addSampling(Chart &chart, const Environment &sky, const ChartOptions &options) {
    const MicroTransform m = microTransformFromAlpha(kBallAlpha, kBallAlpha);
    const RenderBall all = ballOf(SampledBy<Reflected<DiskNormals>>{m}, sky);
    const RenderBall unmasked = ballOf(SampledBy<Reflected<DiskNormals>>{m, false}, sky);
    const RenderBall visible = ballOf(SampledBy<Reflected<HalfDiskNormals>>{m}, sky);
    const RenderBall ours = ballOf(SampledBy<RenderersChoice>{m}, sky);
    const Pixels truth = ours(options.pick(1024, 32768), 1000);
    const std::string allName = "all normals (NDF)";
    const std::string visibleName = "visible normals (Heitz 2018)";
    std::vector<Choice> choices;
    for (const int spp : {4, 16, 64}) {
        choices.push_back(choiceOf(allName, all, spp, truth));
        choices.push_back(choiceOf(visibleName, visible, spp, truth));
        choices.push_back(choiceOf("the renderer's choice", ours, spp, truth, spp == RenderSettings{}.spp));
    }
    choices.push_back(choiceOf("masking off", unmasked, 16, truth));
    Panel panel = ballPanel("sampling", "All normals, visible normals, and no masking",
                            "A ball of alpha " + digits(static_cast<double>(kBallAlpha)) + " in the studio, " + std::to_string(kBall) +
                                " x " + std::to_string(kBall) + " pixels, one bounce by sampling the surface alone; all threads.",
                            choices, options.pick(5, 25));
    const auto secondsOf16 = [&](const std::string &series) {
        return std::find_if(panel.points.begin(), panel.points.end(),
                            [&](const Point &p) { return p.series == series && p.label == "16 spp"; })
            ->x.value;
    };
    const int equal = std::max(1, static_cast<int>(16 * secondsOf16(allName) / secondsOf16(visibleName) + 0.5));
    const float exposure = exposureOf(truth);
    const Pixels with = all(16, 1);
    const Pixels without = unmasked(16, 1);
    chart.pictures.push_back(
        writeStrip(options.directory, "talk_sampling_picture",
                   "The same time: left all normals (16 samples a pixel), right visible normals (" + std::to_string(equal) + ").",
                   {with, visible(equal, 1)}, kBall, exposure, 2));
    chart.pictures.push_back(writeStrip(options.directory, "talk_masking_picture",
                                        "Left masking off, too bright (" + digits(meanOf(without) / meanOf(with)) +
                                            " times the light) and noisy; right on. All normals, 16 samples a pixel.",
                                        {without, with}, kBall, exposure, 2));
    chart.panels.push_back(std::move(panel));
}

/// Walter 2007 against M: two pictures with other random numbers differ by their noise alone.
void addWalter(Chart &chart, const Environment &sky, const ChartOptions &options) {
    const float alphaX = 0.4F;
    const float alphaY = 0.15F;
    const RenderBall walter = ballOf(WalterBy{alphaX, alphaY}, sky);
    const RenderBall transform = ballOf(TransformBy{microTransformFromAlpha(alphaX, alphaY)}, sky);
    const int spp = options.pick(256, 8192);
    const Pixels a = walter(spp, 1);
    const Pixels b = transform(spp, 2);
    chart.pictures.push_back(writeStrip(
        options.directory, "talk_walter_picture",
        "Alpha (0.4, 0.15). From left: Walter 2007; M; their difference, black within noise: " + digits(100 * relativeRms(a, b)) +
            " % RMS, where two pictures by M differ by " + digits(100 * relativeRms(transform(spp, 3), b)) + " %.",
        {a, b, difference(a, b, 1)}, kBall, exposureOf(b), 2));
    const Pixels truth = transform(4 * spp, 1000);
    std::vector<Choice> choices;
    for (const int each : {16, 64}) {
        choices.push_back(choiceOf("Walter 2007", walter, each, truth));
        choices.push_back(choiceOf("M, chain of Jacobians", transform, each, truth));
    }
    Panel panel =
        ballPanel("walter", "Walter 2007 and M",
                  "A ball of alpha (0.4, 0.15); all normals by either formulation, both with separable masking; against a picture of " +
                      std::to_string(4 * spp) + " samples.",
                  choices, options.pick(5, 25));
    panel.hasFront = false;
    chart.panels.push_back(std::move(panel));
}

constexpr int kRendered = 200; ///< pixels of pictures by the renderer

std::vector<float> pictureOf(Scene scene, Object object, const Material &metal, const DVec3 &eye, double fov) {
    scene.render.width = scene.render.height = kRendered;
    scene.materials = {metal};
    scene.objects.push_back(std::move(object));
    scene.camera.position = eye;
    scene.camera.fovY = fov;
    return renderImage(scene, makePlan(scene), 1, 64, 1).values;
}

/// One plate of alpha 0.1 deformed into three M, under a small lamp, by the renderer.
void addPlates(Chart &chart, const ChartOptions &options) {
    const struct {
        DVec3 stretch;
        double shear;
    } plates[] = {{{1, 3, 1}, 0}, {{1, 1, 1}, 2}, {{3, 1, 1}, 0}};
    std::vector<Pixels> images;
    for (const auto &plate : plates) {
        Object object = objectOf(makeGrid(8, 8, 8));
        object.deformers = {stretchBy(plate.stretch), deformer(DeformerType::Shear, plate.shear, 0, 1)};
        Material metal = brushedMetal(0.1F, 0.1F);
        metal.multiscatter = Multiscatter::Off;
        Scene scene;
        scene.render.maxEvents = 1;
        scene.camera.up = DVec3(0, 1, 0);
        scene.lights.push_back({Vec3(38), SphereLight{DVec3(0, 0, 0.9), 0.025}});
        scene.environment = constantEnvironment(Vec3(0.03F));
        images.push_back(pictureOf(std::move(scene), std::move(object), metal, DVec3(0, 0, 20), 0.1));
    }
    chart.pictures.push_back(writeStrip(options.directory, "talk_plates_picture",
                                        "A plate of alpha 0.1, M = [10 0; 0 10], deformed; the highlight of a small lamp. From left: M = "
                                        "[10 0; 0 30], [10 20; 0 10], [30 0; 0 10].",
                                        images, kRendered, exposureOf(images[1]), 1));
}

/// Alpha 1 with single scattering and with the walk, by the renderer.
void addRoughBall(Chart &chart, const Environment &sky, const ChartOptions &options) {
    std::vector<Pixels> images;
    for (const Multiscatter treatment : {Multiscatter::Off, Multiscatter::Walk}) {
        Material metal = brushedMetal(1, 1);
        metal.multiscatter = treatment;
        Scene scene;
        scene.environment = sky;
        scene.environment->cameraVisible = false;
        images.push_back(pictureOf(std::move(scene), objectOf(makeSphere(96, 48, 0.9F)), metal, DVec3(0, -4, 0), 0.5));
    }
    chart.pictures.push_back(writeStrip(options.directory, "talk_rough_picture",
                                        "Alpha 1: left single scattering, which loses light, right the walk, which has " +
                                            digits(meanOf(images[1]) / meanOf(images[0])) + " times as much.",
                                        images, kRendered, exposureOf(images[1]), 1));
}

/// The standard distribution: an even disk.
void addDisk(Chart &chart, const ChartOptions &options) {
    const Mesh mesh = makeGgxHeightfield(static_cast<std::size_t>(options.pick(1000000, 10000000)), 1);
    const NormalImage painted = paintNormals(mesh, microTransform(1, 0, 0, 1), 200);
    chart.pictures.push_back(writeStrip(options.directory, "talk_disk_picture",
                                        "Normals of the standard microsurface (alpha 1) on the disk (n.x, n.y): left counted on " +
                                            count(static_cast<double>(mesh.faceCount())) +
                                            " facets of a heightfield, right D cos = cos / pi, which fills it evenly.",
                                        {painted.rgb}, painted.width, 1));
}

} // namespace

Chart measureTalk(const ChartOptions &options) {
    Chart chart{"talk", "The talk's figures",
                "The pictures of the talk that this project began with, made by this code: all normals against visible ones, masking "
                "off against on, Walter 2007 against M, three plates, rough multiple scattering off and on, and the disk of the "
                "standard distribution. The truth of the balls is a picture of many more samples.",
                "Left is faster, down is less noise (relMSE: squared error over squared truth, a pixel at a time). Without masking "
                "more samples do not help: the picture is wrong.",
                "Visible normals with masking; Walter's formulas and M are the same surface, so that M costs nothing in the picture and "
                "follows deformations as well."};
    const Environment sky = studioEnvironment();
    addSampling(chart, sky, options);
    addWalter(chart, sky, options);
    addPlates(chart, options);
    addRoughBall(chart, sky, options);
    addDisk(chart, options);
    return chart;
}

} // namespace taut::chart

/// The figures of the talk that the project began with (CEDEC 2023, after "Microsurface Transformations"), made by this code.

#include "study/charts.h"
#include "study/render_image.h"
#include "study/talk_ball.h"
#include "study/text.h"
#include "study/timing.h"

#include "study/micro_geometry.h"
#include "taut/mesh/shapes.h"
#include "taut/render/image_file.h"

namespace taut::chart {

namespace {

constexpr int kBall = 112; ///< pixels
constexpr float kBallAlpha = 0.5F;

/// What a ball is rendered by, timed with others.
struct BallRun {
    std::string series;
    int spp;
    bool isDefault;
    std::function<Pixels(int spp, std::uint32_t seed)> render;
    Pixels last;
    std::vector<double> errors;
};

/// Runs all in turn, round by round: time and relMSE against `truth` of each.
std::vector<Point> timeBalls(std::vector<BallRun> &balls, const Pixels &truth, int rounds) {
    std::vector<std::function<void()>> runs;
    for (BallRun &ball : balls)
        runs.emplace_back([&ball, &truth] {
            ball.last = ball.render(ball.spp, static_cast<std::uint32_t>(ball.errors.size() + 1));
            ball.errors.push_back(relativeMse(ball.last, truth));
        });
    const std::vector<Measured> seconds = timeInterleaved(runs, rounds);
    std::vector<Point> points;
    for (std::size_t i = 0; i < balls.size(); ++i)
        points.push_back(
            {balls[i].series, std::to_string(balls[i].spp) + " spp", seconds[i], medianOf(balls[i].errors), balls[i].isDefault});
    return points;
}

template <class Scatter> auto ballOf(const Scatter &scatter, const Environment &sky) {
    return [scatter, &sky](int spp, std::uint32_t seed) { return renderBall(scatter, sky, kBall, spp, seed); };
}

Panel ballPanel(const std::string &name, const std::string &title) {
    Panel panel;
    panel.name = name;
    panel.title = title;
    panel.conditions = "A ball of alpha " + digits(static_cast<double>(kBallAlpha)) + " in the studio, " + std::to_string(kBall) + " x " +
                       std::to_string(kBall) + " pixels, one bounce by sampling the surface alone; all threads.";
    panel.x = {"time of the picture", "s"};
    panel.y = {"relMSE", ""};
    panel.joined = true;
    return panel;
}

double meanOf(const Pixels &image) {
    double sum = 0;
    for (const float value : image) sum += static_cast<double>(value);
    return sum;
}

/// All normals against visible ones: equal time; and masking off against on.
void addSampling(Chart &chart, const Environment &sky, const ChartOptions &options) {
    const bool quick = options.effort == Effort::Quick;
    const MicroTransform m = microTransformFromAlpha(kBallAlpha, kBallAlpha);
    const auto all = ballOf(SampledBy<Reflected<DiskNormals>>{m}, sky);
    const auto unmasked = ballOf(SampledBy<Reflected<DiskNormals>>{m, false}, sky);
    const auto visible = ballOf(SampledBy<Reflected<HalfDiskNormals>>{m}, sky);
    const auto ours = ballOf(SampledBy<RenderersChoice>{m}, sky);
    const Pixels truth = ours(quick ? 1024 : 32768, 1000);
    std::vector<BallRun> balls;
    for (const int spp : {4, 16, 64}) {
        balls.push_back({"all normals (NDF)", spp, false, all, {}, {}});
        balls.push_back({"visible normals (Heitz 2018)", spp, false, visible, {}, {}});
        balls.push_back({"the renderer's choice", spp, spp == RenderSettings{}.spp, ours, {}, {}});
    }
    balls.push_back({"masking off", 16, false, unmasked, {}, {}});
    std::vector<Point> points = timeBalls(balls, truth, quick ? 5 : 25);
    Panel panel = ballPanel("sampling", "All normals, visible normals, and no masking");
    panel.points = points;
    std::stable_sort(panel.points.begin(), panel.points.end(), [](const Point &a, const Point &b) { return a.series < b.series; });
    const auto secondsOf16 = [&](const std::string &series) {
        for (const Point &p : points)
            if (p.series == series && p.label == "16 spp") return p.x.value;
        return 1.0;
    };
    const int equal =
        std::max(1, static_cast<int>(16 * secondsOf16("all normals (NDF)") / secondsOf16("visible normals (Heitz 2018)") + 0.5));
    const float exposure = exposureOf(truth);
    chart.pictures.push_back(
        writeStrip(options.directory, "talk_sampling_picture",
                   "The same time: left all normals (16 samples a pixel), right visible normals (" + std::to_string(equal) + ").",
                   {all(16, 1), visible(equal, 1)}, kBall, exposure, 2));
    const Pixels without = unmasked(16, 1);
    const Pixels with = all(16, 1);
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
    const auto walter = ballOf(WalterBy{alphaX, alphaY}, sky);
    const auto transform = ballOf(TransformBy{microTransformFromAlpha(alphaX, alphaY)}, sky);
    const bool quick = options.effort == Effort::Quick;
    const int spp = quick ? 256 : 8192;
    const Pixels a = walter(spp, 1);
    const Pixels b = transform(spp, 2);
    const double apart = relativeRms(a, b);
    const double noise = relativeRms(transform(spp, 3), b);
    chart.pictures.push_back(
        writeStrip(options.directory, "talk_walter_picture",
                   "Alpha (0.4, 0.15). From left: Walter 2007; M; their difference, black within noise: " + digits(100 * apart) +
                       " % RMS, where two pictures by M differ by " + digits(100 * noise) + " %.",
                   {a, b, difference(a, b, 1)}, kBall, exposureOf(b), 2));
    Panel panel = ballPanel("walter", "Walter 2007 and M");
    panel.conditions =
        "A ball of alpha (0.4, 0.15); all normals by either formulation, both with separable masking; against a picture of " +
        std::to_string(4 * spp) + " samples.";
    panel.hasFront = false;
    const Pixels truth = transform(4 * spp, 1000);
    std::vector<BallRun> balls;
    for (const int each : {16, 64}) {
        balls.push_back({"Walter 2007", each, false, walter, {}, {}});
        balls.push_back({"M, chain of Jacobians", each, false, transform, {}, {}});
    }
    panel.points = timeBalls(balls, truth, quick ? 5 : 25);
    std::stable_sort(panel.points.begin(), panel.points.end(), [](const Point &p, const Point &q) { return p.series < q.series; });
    chart.panels.push_back(std::move(panel));
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
        DeformerKeys stretch;
        stretch.type = DeformerType::Stretch;
        stretch.factor = plate.stretch;
        object.deformers = {stretch, constantDeformer(DeformerType::Shear, plate.shear, 0, 1)};
        Material metal = brushedMetal(0.1F, 0.1F);
        metal.multiscatter = Multiscatter::Off;
        Scene scene;
        scene.render.width = scene.render.height = 200;
        scene.render.maxEvents = 1;
        scene.materials = {metal};
        scene.objects.push_back(std::move(object));
        scene.camera.position = DVec3(0, 0, 20);
        scene.camera.up = DVec3(0, 1, 0);
        scene.camera.fovY = 0.1;
        scene.lights.push_back({Vec3(38), SphereLight{DVec3(0, 0, 0.9), 0.025}});
        scene.environment = constantEnvironment(Vec3(0.03F));
        images.push_back(renderImage(scene, makePlan(scene), 1, 64, 1).values);
    }
    chart.pictures.push_back(writeStrip(
        options.directory, "talk_plates_picture",
        "A plate of alpha 0.1, M = [10 0; 0 10], deformed; the highlight of a small lamp. From left: M = [10 0; 0 30], [10 20; 0 "
        "10], [30 0; 0 10].",
        images, 200, exposureOf(images[1]), 1));
}

/// Alpha 1 with single scattering and with the walk, by the renderer.
void addRoughBall(Chart &chart, const Environment &sky, const ChartOptions &options) {
    std::vector<Pixels> images;
    for (const Multiscatter treatment : {Multiscatter::Off, Multiscatter::Walk}) {
        Material metal = brushedMetal(1, 1);
        metal.multiscatter = treatment;
        Scene scene;
        scene.render.width = scene.render.height = 200;
        scene.materials = {metal};
        scene.objects.push_back(objectOf(makeSphere(96, 48, 0.9F)));
        scene.camera.position = DVec3(0, -4, 0);
        scene.camera.fovY = 0.5;
        scene.environment = sky;
        scene.environment->cameraVisible = false;
        images.push_back(renderImage(scene, makePlan(scene), 1, 64, 1).values);
    }
    chart.pictures.push_back(writeStrip(options.directory, "talk_rough_picture",
                                        "Alpha 1: left single scattering, which loses light, right the walk, which has " +
                                            digits(meanOf(images[1]) / meanOf(images[0])) + " times as much.",
                                        images, 200, exposureOf(images[1]), 1));
}

/// The standard distribution: an even disk.
void addDisk(Chart &chart, const ChartOptions &options) {
    const Mesh mesh = makeGgxHeightfield(options.effort == Effort::Quick ? 1000000 : 10000000, 1);
    const NormalImage painted = paintNormals(mesh, microTransform(1, 0, 0, 1), 200);
    const std::filesystem::path file = options.directory / "talk_disk_picture.png";
    writeImage(file.string(), {{0, 0, painted.width, painted.height}, painted.width, painted.height, {"R", "G", "B"}, painted.rgb}, {});
    chart.pictures.push_back({"Normals of the standard microsurface (alpha 1) on the disk (n.x, n.y): left counted on " +
                                  count(static_cast<double>(mesh.faceCount())) +
                                  " facets of a heightfield, right D cos = cos / pi, which fills it evenly.",
                              file});
}

} // namespace

Chart measureTalk(const ChartOptions &options) {
    Chart chart;
    chart.name = "talk";
    chart.title = "The talk's figures";
    chart.compared = "The pictures of the talk that this project began with, made by this code: all normals against visible ones, masking "
                     "off against on, "
                     "Walter 2007 against M, three plates, rough multiple scattering off and on, and the disk of the standard "
                     "distribution. The truth of the "
                     "balls is a picture of many more samples.";
    chart.howToRead = "Left is faster, down is less noise (relMSE: squared error over squared truth, a pixel at a time). Without masking "
                      "more samples do not help: "
                      "the picture is wrong.";
    chart.choice = "Visible normals with masking; Walter's formulas and M are the same surface, so that M costs nothing in the picture and "
                   "follows deformations "
                   "as well.";
    const Environment sky = studioEnvironment();
    addSampling(chart, sky, options);
    addWalter(chart, sky, options);
    addPlates(chart, options);
    addRoughBall(chart, sky, options);
    addDisk(chart, options);
    return chart;
}

} // namespace taut::chart

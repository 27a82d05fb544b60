/// taut probe: numbers for one microsurface and one view, one JSON object on standard output. Documented in docs/probe.md.

#include "commands.h"
#include "json_text.h"
#include "lobe_picture.h"
#include "probe_arguments.h"

#include "study/microsurface/micro_geometry.h"
#include "taut/base/parallel.h"
#include "taut/base/sobol.h"
#include "taut/bsdf/bsdf.h"
#include "taut/render/image_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <iostream>

namespace taut::app {

namespace {

/// Insertion order, so that what was asked stands before what was found.
using Json = nlohmann::ordered_json;

/// The double of the fewest digits that name this float: 0.8 is printed as 0.8.
double digits(float x) {
    return std::isfinite(x) ? std::stod(fmt::format("{}", x + 0.0F)) : static_cast<double>(x); // no -0
}
Json array(const Vec3 &v) {
    return {digits(v.x), digits(v.y), digits(v.z)};
}

/// What scatters, and the frame that it does so in: wo and wi are asked for and answered in the space of --m.
struct Asked {
    Frame frame;
    Bsdf bsdf;
    explicit Asked(const ProbeArguments &arguments) {
        const GeneralTransform surface = surfaceOf(arguments);
        frame = surface.frame;
        bsdf = bsdfOf(arguments, surface.micro);
    }
    [[nodiscard]] bool tilted() const { return frame.n != Vec3(0, 0, 1); }
    [[nodiscard]] Vec3 toLocal(const Vec3 &w) const { return tilted() ? frame.toLocal(w) : w; }
    [[nodiscard]] Vec3 fromLocal(const Vec3 &w) const { return tilted() ? frame.fromLocal(w) : w; }
};

Json describe(const Asked &asked, const ProbeArguments &arguments, const Vec3 &wo) {
    const MicroTransform &m = asked.bsdf.micro;
    const EquivalentAlpha alpha = equivalentAlpha(m);
    Json result{{"m", {digits(m.a), digits(m.b), 0.0, digits(m.d), digits(m.p), digits(m.q)}},
                {"alpha_max", digits(alpha.max)},
                {"alpha_min", digits(alpha.min)},
                {"alpha_rotation", digits(alpha.phi * (180 / kPi))}};
    if (asked.tilted()) {
        const Frame &f = asked.frame;
        result["normal"] = array(f.n);
        result["frame_x"] = array(f.s);
        if (f.n.z > 0) result["slope"] = {digits(f.n.x / f.n.z), digits(f.n.y / f.n.z)};
    }
    result["mode"] = arguments.mode;
    result["wo"] = array(wo);
    return result;
}

/// Members on lines of their own, arrays of numbers on one.
int print(const Json &result) {
    std::string text;
    bool inside = false; // of an array of numbers, which ends at the next bracket
    const std::string dump = jsonText(result, 2);
    for (std::size_t i = 0; i < dump.size(); ++i) {
        if (dump[i] == '[') inside = dump.find_first_of("{[\"", i + 1) > dump.find(']', i);
        if (dump[i] == ']') inside = false;
        if (inside && (dump[i] == '\n' || dump[i] == ' ')) continue;
        text += dump[i];
        if (inside && dump[i] == ',') text += ' ';
    }
    std::cout << text << std::endl;
    return 0;
}

/// Mean and its standard error from independent parts.
struct Estimate {
    double mean = 0, error = 0;
};
Estimate estimate(const std::vector<double> &parts) {
    const auto n = static_cast<double>(parts.size());
    Estimate e;
    for (const double x : parts) e.mean += x / n;
    for (const double x : parts) e.error += sqr(x - e.mean);
    e.error = parts.size() > 1 ? std::sqrt(e.error / (n * (n - 1))) : std::numeric_limits<double>::quiet_NaN();
    return e;
}

/// Splits `samples` into parts, each a stratified set of its own: `take(part, count)` fills one. Their scatter is the error.
struct Parts {
    std::uint32_t count, each;
    explicit Parts(std::uint32_t samples) : count(std::min(samples, 256U)), each((samples + count - 1) / count) {}
    [[nodiscard]] std::uint32_t total() const { return count * each; }
};

int albedo(const ProbeArguments &arguments) {
    const Asked asked(arguments);
    const Bsdf &bsdf = asked.bsdf;
    const Vec3 view = directionOf(arguments.theta, arguments.phi, "--theta");
    const Vec3 wo = asked.toLocal(view);
    const Parts parts(arguments.samples);
    const bool walks = bsdf.multiscatter == Multiscatter::Walk;
    std::vector<double> energy(parts.count);
    std::vector<double> bounces(parts.count);
    const ScatteringPoint point(bsdf, wo);
    parallelFor(parts.count, 1, [&](std::size_t part) {
        const std::uint32_t seed = hash(arguments.seed, static_cast<std::uint32_t>(part));
        for (std::uint32_t i = 0; i < parts.each; ++i) {
            const Vec2 u = sobol2(i, seed);
            if (walks) {
                walk::Random random(hash(i, seed) ^ (std::uint64_t{seed} << 32U));
                const walk::Exit exit = walk::sample(bsdf.micro, wo, SchlickInterface{bsdf.f0}, u, random);
                energy[part] += static_cast<double>(exit.throughput.x);
                bounces[part] += exit.bounces;
            } else if (const auto s = point.sample(u, sobol1(i, hash(seed, 1)))) {
                energy[part] += static_cast<double>(s->weight.x);
            }
        }
        energy[part] /= parts.each;
        bounces[part] /= parts.each;
    });
    Json result = describe(asked, arguments, view);
    const Estimate e = estimate(energy);
    result["albedo"] = e.mean;
    result["standard_error"] = e.error;
    if (walks) {
        const Estimate b = estimate(bounces);
        result["mean_bounces"] = b.mean;
        result["mean_bounces_standard_error"] = b.error;
    }
    result["samples"] = parts.total();
    return print(result);
}

int pdf(const ProbeArguments &arguments) {
    const Asked asked(arguments);
    const Bsdf &bsdf = asked.bsdf;
    const Vec3 view = directionOf(arguments.theta, arguments.phi, "--theta");
    const Vec3 wo = asked.toLocal(view);
    const Vec3 light = directionOf(arguments.thetaIn, arguments.phiIn, "--theta-in");
    const Vec3 wi = asked.toLocal(light);
    const MicroTransform &m = bsdf.micro;
    const ScatteringPoint point(bsdf, wo);
    Json result = describe(asked, arguments, view);
    const Vec3 h = wo + wi;
    const bool reflects = wi.z > 0 && glm::dot(h, h) > 0;
    const float density = reflects ? ggx::distribution(m, h) : 0.0F;
    const float lengthO = ggx::stretchedLength(m, wo);
    const float area = ggx::visibleArea(m, wo, lengthO);
    const float maskingO = ggx::masking(m, wo);
    const float maskingI = ggx::masking(m, wi);
    float both = 0;
    if (wi.z > 0)
        both = wo.z > 0 ? 4 * wo.z * wi.z * ggx::visibility(wo.z, lengthO, wi.z, ggx::stretchedLength(m, wi), bsdf.correlated)
                        : maskingO * maskingI;
    result["wi"] = array(light);
    result["wm"] = reflects ? array(asked.fromLocal(glm::normalize(h))) : Json(nullptr);
    result["D"] = digits(density);
    result["G1"] = digits(maskingO);
    result["G1_in"] = digits(maskingI);
    result["G2"] = digits(both);
    const float visiblePdf = density / (2 * area);
    if (bsdf.multiscatter == Multiscatter::Walk) {
        const Parts parts(arguments.samples);
        std::vector<double> f(parts.count);
        parallelFor(parts.count, 1, [&](std::size_t part) {
            const std::uint32_t seed = hash(arguments.seed, static_cast<std::uint32_t>(part));
            for (std::uint32_t i = 0; i < parts.each; ++i)
                f[part] += static_cast<double>(point.evaluate(wi, walk::numbersOf(hash(i, seed))).fCos.x) / (parts.each * static_cast<double>(wi.z));
        });
        const Estimate e = wi.z > 0 ? estimate(f) : Estimate{};
        const float used = point.evaluate(wi).pdf;
        const float single = wi.z > 0 ? walk::evaluateSingle(m, wo, wi, SchlickInterface{bsdf.f0}).x / wi.z : 0.0F;
        result["f"] = e.mean;
        result["standard_error"] = e.error;
        result["f_single"] = digits(single);
        result["pdf"] = digits(used);
        result["weight"] = used > 0 ? e.mean * static_cast<double>(wi.z / used) : 0.0;
        result["samples"] = parts.total();
    } else {
        const BsdfEval e = point.evaluate(wi);
        result["f"] = wi.z > 0 ? digits(e.fCos.x / wi.z) : 0.0;
        result["pdf"] = digits(visiblePdf);
        result["weight"] = visiblePdf > 0 ? digits(e.fCos.x / visiblePdf) : 0.0;
        result["sampler_pdf"] = digits(e.pdf);
    }
    return print(result);
}

int sample(const ProbeArguments &arguments) {
    const Asked asked(arguments);
    const Bsdf &bsdf = asked.bsdf;
    const Vec3 view = directionOf(arguments.theta, arguments.phi, "--theta");
    const Vec3 wo = asked.toLocal(view);
    const ScatteringPoint point(bsdf, wo);
    Json result = describe(asked, arguments, view);
    Json samples = Json::array();
    for (std::uint32_t i = 0; i < arguments.samples; ++i) {
        const auto s = point.sample(sobol2(i, arguments.seed), sobol1(i, hash(arguments.seed, 1)), hash(i, arguments.seed));
        if (s)
            samples.push_back({{"wi", array(asked.fromLocal(s->wi))}, {"pdf", digits(s->pdf)}, {"weight", digits(s->weight.x)}});
        else
            samples.push_back({{"wi", nullptr}, {"pdf", 0.0}, {"weight", 0.0}});
    }
    result["samples"] = samples;
    return print(result);
}

constexpr const char *kMapping = "latlong: column = phi / 360 * width, row = theta / 180 * height; theta from the normal (z, top row), "
                                 "phi from the tangent (x) towards y";

int lobe(const ProbeArguments &arguments) {
    constexpr std::array<std::string_view, 2> kQuantities{"fcos", "pdf"};
    if (std::find(kQuantities.begin(), kQuantities.end(), arguments.quantity) == kQuantities.end())
        failUnknownName({"--quantity"}, arguments.quantity, kQuantities);
    if (!arguments.output.empty() && !isImagePath(arguments.output))
        failInput({"--output"}, quoted(arguments.output), "a name in .exr or .png");
    const Asked asked(arguments);
    const Vec3 view = directionOf(arguments.theta, arguments.phi, "--theta");
    const LobePicture picture =
        lobePicture(asked.bsdf, asked.frame, {view, arguments.width, arguments.samples, arguments.seed, arguments.quantity == "pdf"});
    const auto &[width, height, values, peak, integral] = picture;
    const auto columns = static_cast<std::size_t>(width);
    Json result = describe(asked, arguments, view);
    result["quantity"] = arguments.quantity;
    result["width"] = width;
    result["height"] = height;
    result["integral"] = integral;
    result["max"] = digits(values[peak]);
    result["max_wi"] = array(lobeDirection(static_cast<double>(peak % columns) + 0.5, static_cast<double>(peak / columns) + 0.5, width));
    if (!arguments.output.empty()) {
        const bool png = arguments.output.ends_with(".png");
        // PNG holds [0, 1] only: its greatest value becomes white unless a scale is asked for.
        const float fitted = png && values[peak] > 0 ? 1 / values[peak] : 1.0F;
        const float scale = arguments.scale > 0 ? static_cast<float>(arguments.scale) : fitted;
        Image image{{0, 0, width, height}, width, height, {"R", "G", "B"}, {}};
        for (const float v : values) image.values.insert(image.values.end(), 3, v * scale);
        writeImage(arguments.output, image,
                   {{"taut:mapping", kMapping},
                    {"taut:quantity", arguments.quantity},
                    {"taut:scale", fmt::format("{:.9g}", scale)},
                    {"taut:m", result["m"].dump()},
                    {"taut:wo", result["wo"].dump()},
                    {"taut:mode", arguments.mode}});
        result["scale"] = digits(scale);
        result["output"] = arguments.output;
    }
    return print(result);
}

/// Counted normals of a deformed heightfield beside D_M n.z.
int microGeometry(const ProbeArguments &arguments) {
    if (!arguments.output.empty() && !isImagePath(arguments.output))
        failInput({"--output"}, quoted(arguments.output), "a name in .exr or .png");
    const MicroTransform m = microsurfaceOf(arguments);
    Mesh mesh = makeGgxHeightfield(arguments.facets, arguments.seed);
    deformPositions(mesh, deformersOf(m));
    const NormalHistogram counted = countNormals(mesh, arguments.bins);
    const NormalHistogram expected = expectedNormals(m, arguments.bins);
    Json result{{"m", {digits(m.a), digits(m.b), 0.0, digits(m.d), digits(m.p), digits(m.q)}},
                {"facets", mesh.faceCount()},
                {"bins", arguments.bins},
                {"total_variation", totalVariation(counted, expected)}};
    if (!arguments.output.empty()) {
        const NormalImage picture = paintNormals(mesh, m, arguments.width / 2);
        Image image{{0, 0, picture.width, picture.height}, picture.width, picture.height, {"R", "G", "B"}, picture.rgb};
        writeImage(arguments.output, image,
                   {{"taut:mapping", "left: normals counted by projected area, right: D_M cos; disk of (n.x, n.y), n.y up"},
                    {"taut:m", result["m"].dump()},
                    {"taut:scale", fmt::format("{:.9g}", picture.scale)}});
        result["scale"] = picture.scale;
        result["output"] = arguments.output;
    }
    return print(result);
}

using Question = int (*)(const ProbeArguments &);

/// Adds one question; its arguments live as long as the parser.
std::pair<CLI::App *, std::shared_ptr<ProbeArguments>> addQuestion(CLI::App &probe, Run &run, const char *name, const char *what,
                                                                   Question question) {
    auto arguments = std::make_shared<ProbeArguments>();
    CLI::App *command = probe.add_subcommand(name, what);
    addMicrosurfaceArguments(*command, *arguments);
    command->add_flag("--json", arguments->json, "One JSON object on standard output: always so");
    command->callback([&run, arguments, question] { run = [arguments, question] { return question(*arguments); }; });
    return {command, arguments};
}

} // namespace

void addProbe(CLI::App &parent, Run &run) {
    CLI::App *probe = parent.add_subcommand("probe", "Numbers for one microsurface, as JSON");
    {
        const auto [command, arguments] = addQuestion(*probe, run, "albedo", "Share of the light that is reflected", albedo);
        addViewArguments(*command, *arguments);
        addScatteringArguments(*command, *arguments, 1U << 20U, "Number of samples");
    }
    {
        const auto [command, arguments] =
            addQuestion(*probe, run, "pdf", "D, G1, G2, f, pdf and weight for a view and a light direction", pdf);
        addViewArguments(*command, *arguments);
        command->add_option("--theta-in", arguments->thetaIn, "Light: degrees from the normal (default: 0)");
        command->add_option("--phi-in", arguments->phiIn, "Light: degrees from the tangent (default: 0)");
        addScatteringArguments(*command, *arguments, 1U << 16U, "Walks, in mode walk");
    }
    {
        const auto [command, arguments] = addQuestion(*probe, run, "sample", "Sampled directions with their weights", sample);
        addViewArguments(*command, *arguments);
        addScatteringArguments(*command, *arguments, 16, "Number of samples");
    }
    {
        const auto [command, arguments] = addQuestion(*probe, run, "lobe", "The lobe over all light directions, as an image", lobe);
        addViewArguments(*command, *arguments);
        addScatteringArguments(*command, *arguments, 16, "Samples per pixel");
        command->add_option("-o,--output", arguments->output, "Latitude-longitude image, .exr or .png");
        command->add_option("--quantity", arguments->quantity, "fcos (the BSDF times the cosine) or pdf (default: fcos)");
        command->add_option("--width", arguments->width, "Pixels; half as many high (default: 512)")->check(CLI::Range(2, 16384));
        command->add_option("--scale", arguments->scale, "Factor of the image's values (default: 1; PNG: white at the maximum)");
    }
    {
        const auto [command, arguments] =
            addQuestion(*probe, run, "microgeometry", "A GGX heightfield deformed by M, its normals counted", microGeometry);
        command->add_option("--facets", arguments->facets, "About this many triangles (default: 1000000)")
            ->check(CLI::Range(10000, 20000000));
        command->add_option("--bins", arguments->bins, "Cells across the disk (default: 32)")->check(CLI::Range(2, 512));
        command->add_option("--seed", arguments->seed, "Of all random numbers (default: 1)");
        command->add_option("-o,--output", arguments->output, "Picture: counted (left) and D_M cos (right), .exr or .png");
        command->add_option("--width", arguments->width, "Pixels of the picture; half as many high (default: 512)")
            ->check(CLI::Range(2, 4096));
    }
}

} // namespace taut::app

#include "probe_arguments.h"

#include "taut/base/error.h"

#include <fmt/format.h>

#include <array>

namespace taut::app {

namespace {

void checkFinite(const std::vector<double> &values, const char *option) {
    for (const double v : values)
        if (!std::isfinite(v)) failInput({option}, fmt::format("{}", v), "finite numbers");
}

/// Sine and cosine of whole quarter turns come out exact.
double cosineOfDegrees(double degrees) {
    const double c = std::cos(radians(degrees));
    return std::fabs(c) < 1e-15 ? 0.0 : c;
}

} // namespace

void addMicrosurfaceArguments(CLI::App &command, ProbeArguments &arguments) {
    command.add_option("--m", arguments.m, "The transform [a b p; c d q; 0 0 1] as a,b,c,d[,p,q], or any 3x3 by rows, nine numbers")
        ->delimiter(',')
        ->allow_extra_args(false);
    command.add_option("--alpha", arguments.alpha, "GGX alpha: one number or ax,ay; instead of --m")
        ->delimiter(',')
        ->allow_extra_args(false);
    command.add_option("--rotation", arguments.rotation, "With --alpha: of its x axis from the tangent, degrees");
    command.add_option("--slope", arguments.slope, "With --alpha: sx,sy of a mapped facet at rest")
        ->delimiter(',')
        ->allow_extra_args(false);
    command
        .add_option("--deform", arguments.deform,
                    "With --alpha: the mesh's deformation [a b p; c d q; 0 0 lambda] as a,b,c,d[,p,q[,lambda]]")
        ->delimiter(',')
        ->allow_extra_args(false);
    command.add_option("--roughening", arguments.roughening, "With --deform: alpha per unit of strain beyond the yield (default: 0)");
    command.add_option("--yield", arguments.yield, "With --roughening: a strain (default: 0)");
}

void addViewArguments(CLI::App &command, ProbeArguments &arguments) {
    command.add_option("--theta", arguments.theta, "View: degrees from the normal (default: 0)");
    command.add_option("--phi", arguments.phi, "View: degrees from the tangent (default: 0)");
}

void addScatteringArguments(CLI::App &command, ProbeArguments &arguments, std::uint32_t samples, const std::string &what) {
    arguments.samples = samples;
    command.add_option("--mode", arguments.mode, "separable, correlated or walk (default: correlated)");
    command.add_option("--f0", arguments.f0, "Schlick's reflectance at normal incidence (default: 1)");
    command.add_option("--samples,--spp", arguments.samples, fmt::format("{} (default: {})", what, samples))
        ->check(CLI::Range(1U, 1U << 30U));
    command.add_option("--seed", arguments.seed, "Of all random numbers (default: 1)");
}

namespace {

/// A 3x3 matrix by rows.
GeneralTransform generalOf(const std::vector<double> &m) {
    const auto general = generalTransform({m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]});
    if (!general) failInput({"--m"}, "a singular matrix", "one that can be inverted");
    return *general;
}

/// --alpha with --slope and --deform.
GeneralTransform facetOf(const ProbeArguments &arguments, const BasicBlock<double> &rest) {
    const std::vector<double> &slope = arguments.slope;
    const std::vector<double> &d = arguments.deform;
    if (!slope.empty() && slope.size() != 2) failInput({"--slope"}, fmt::format("{} numbers", slope.size()), "sx,sy");
    if (!d.empty() && d.size() != 4 && d.size() != 6 && d.size() != 7)
        failInput({"--deform"}, fmt::format("{} numbers", d.size()), "a,b,c,d or a,b,c,d,p,q or a,b,c,d,p,q,lambda");
    const DVec2 lean = d.size() > 4 ? DVec2(d[4], d[5]) : DVec2(0);
    const double lambda = d.size() > 6 ? d[6] : 1;
    if (!(lambda > 0)) failInput({"--deform"}, fmt::format("a lambda of {}", lambda), "more than 0");
    const BasicBlock<double> a = d.empty() ? BasicBlock<double>{} : BasicBlock<double>{d[0], d[1], d[2], d[3]};
    const SlopeStatistics slopes{slope.empty() ? Vec2(0) : Vec2(DVec2(slope[0], slope[1])), Vec3(0)};
    auto facet = mappedTransform(surfaceDeformation(a, lean, lambda), slopes, rest);
    if (!facet) failInput({"--deform"}, "a singular matrix", "a d - b c other than 0");
    const Vector2<double> sigma = singularValues<double>(a.a, a.b, a.c, a.d);
    facet->micro = roughened(facet->micro, addedAlpha(equivalentStrain(sigma.x, sigma.y), arguments.roughening, arguments.yield));
    return *facet;
}

} // namespace

GeneralTransform surfaceOf(const ProbeArguments &arguments) {
    const std::vector<double> &m = arguments.m;
    const std::vector<double> &alpha = arguments.alpha;
    if (m.empty() == alpha.empty()) failInput({"probe"}, m.empty() ? "neither --m nor --alpha" : "both --m and --alpha", "one of them");
    checkFinite(m, "--m");
    checkFinite(alpha, "--alpha");
    checkFinite({arguments.rotation}, "--rotation");
    checkFinite(arguments.slope, "--slope");
    checkFinite(arguments.deform, "--deform");
    for (const auto &[value, option] : {std::pair(arguments.roughening, "--roughening"), std::pair(arguments.yield, "--yield")})
        if (!(value >= 0) || !std::isfinite(value)) failInput({option}, fmt::format("{}", value), "a number, at least 0");
    const bool facet = !arguments.slope.empty() || !arguments.deform.empty();
    const auto single = [](double v) { return static_cast<float>(v); };
    if (!m.empty()) {
        if (facet) failInput({arguments.slope.empty() ? "--deform" : "--slope"}, "it beside --m", "it with --alpha");
        if (m.size() == 9) return generalOf(m);
        if (m.size() != 4 && m.size() != 6) failInput({"--m"}, fmt::format("{} numbers", m.size()), "a,b,c,d or a,b,c,d,p,q or nine");
        if (m[0] * m[3] - m[1] * m[2] == 0) failInput({"--m"}, "a singular matrix", "a d - b c other than 0");
        const bool leans = m.size() == 6;
        return {{},
                microTransform(single(m[0]), single(m[1]), single(m[2]), single(m[3]), leans ? single(m[4]) : 0, leans ? single(m[5]) : 0)};
    }
    if (alpha.size() > 2) failInput({"--alpha"}, fmt::format("{} numbers", alpha.size()), "one or two");
    for (const double a : alpha)
        if (!(a > 0)) failInput({"--alpha"}, fmt::format("{}", a), "more than 0");
    const double rotation = radians(arguments.rotation);
    if (facet) return facetOf(arguments, restBlock<double>(alpha.front(), alpha.back(), DVec2(std::cos(rotation), std::sin(rotation))));
    return {{}, microTransformFromAlpha(single(alpha.front()), single(alpha.back()), single(rotation))};
}

MicroTransform microsurfaceOf(const ProbeArguments &arguments) {
    const GeneralTransform surface = surfaceOf(arguments);
    if (surface.frame.n != Vec3(0, 0, 1)) failInput({"--m"}, "a microsurface whose normal is not z", "one that is upright, or leans");
    return surface.micro;
}

Bsdf bsdfOf(const ProbeArguments &arguments, const MicroTransform &micro) {
    constexpr std::array<std::string_view, 3> kModes{"separable", "correlated", "walk"};
    if (std::find(kModes.begin(), kModes.end(), arguments.mode) == kModes.end()) failUnknownName({"--mode"}, arguments.mode, kModes);
    if (!(arguments.f0 >= 0 && arguments.f0 <= 1)) failInput({"--f0"}, fmt::format("{}", arguments.f0), "a number in [0, 1]");
    Bsdf bsdf;
    bsdf.type = BsdfType::Conductor;
    bsdf.f0 = Vec3(static_cast<float>(arguments.f0));
    bsdf.micro = micro;
    bsdf.correlated = arguments.mode != "separable";
    if (arguments.mode == "walk") bsdf.multiscatter = Multiscatter::Walk;
    return bsdf;
}

Vec3 directionOf(double theta, double phi, const char *option) {
    if (!(theta >= 0 && theta <= 180)) failInput({option}, fmt::format("{}", theta), "degrees in [0, 180]");
    if (!std::isfinite(phi)) failInput({option}, fmt::format("an azimuth of {}", phi), "finite degrees");
    const double sine = cosineOfDegrees(theta - 90);
    return {static_cast<float>(sine * cosineOfDegrees(phi)), static_cast<float>(sine * cosineOfDegrees(phi - 90)),
            static_cast<float>(cosineOfDegrees(theta))};
}

} // namespace taut::app

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
    command.add_option("--m", arguments.m, "The transform [a b p; c d q; 0 0 1] as a,b,c,d[,p,q]")->delimiter(',')->allow_extra_args(false);
    command.add_option("--alpha", arguments.alpha, "GGX alpha: one number or ax,ay; instead of --m")
        ->delimiter(',')
        ->allow_extra_args(false);
    command.add_option("--rotation", arguments.rotation, "With --alpha: of its x axis from the tangent, degrees");
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

MicroTransform microsurfaceOf(const ProbeArguments &arguments) {
    const std::vector<double> &m = arguments.m;
    const std::vector<double> &alpha = arguments.alpha;
    if (m.empty() == alpha.empty()) failInput({"probe"}, m.empty() ? "neither --m nor --alpha" : "both --m and --alpha", "one of them");
    checkFinite(m, "--m");
    checkFinite(alpha, "--alpha");
    checkFinite({arguments.rotation}, "--rotation");
    const auto single = [](double v) { return static_cast<float>(v); };
    if (!m.empty()) {
        if (m.size() != 4 && m.size() != 6) failInput({"--m"}, fmt::format("{} numbers", m.size()), "a,b,c,d or a,b,c,d,p,q");
        if (m[0] * m[3] - m[1] * m[2] == 0) failInput({"--m"}, "a singular matrix", "a d - b c other than 0");
        const bool leans = m.size() == 6;
        return microTransform(single(m[0]), single(m[1]), single(m[2]), single(m[3]), leans ? single(m[4]) : 0, leans ? single(m[5]) : 0);
    }
    if (alpha.size() > 2) failInput({"--alpha"}, fmt::format("{} numbers", alpha.size()), "one or two");
    for (const double a : alpha)
        if (!(a > 0)) failInput({"--alpha"}, fmt::format("{}", a), "more than 0");
    return microTransformFromAlpha(single(alpha.front()), single(alpha.back()), single(radians(arguments.rotation)));
}

Bsdf bsdfOf(const ProbeArguments &arguments) {
    constexpr std::array<std::string_view, 3> kModes{"separable", "correlated", "walk"};
    if (std::find(kModes.begin(), kModes.end(), arguments.mode) == kModes.end()) failUnknownName({"--mode"}, arguments.mode, kModes);
    if (!(arguments.f0 >= 0 && arguments.f0 <= 1)) failInput({"--f0"}, fmt::format("{}", arguments.f0), "a number in [0, 1]");
    Bsdf bsdf;
    bsdf.type = BsdfType::Conductor;
    bsdf.f0 = Vec3(static_cast<float>(arguments.f0));
    bsdf.micro = microsurfaceOf(arguments);
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

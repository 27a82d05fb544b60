/// taut_tables. Writes src/taut/microsurface/energy_table.h to standard output: the least-squares fits of the single-scattering albedo of the
/// transformed GGX microsurface and of its mean, in the coordinates of energy_compensation.h. With --check the errors of the
/// compiled-in table at fresh points instead. About a minute.

#include "study/microsurface/energy_fit.h"

#include <cstdio>
#include <cstring>

using namespace taut;

namespace {

void print(const char *name, const char *size, const std::vector<double> &values) {
    std::printf("inline constexpr std::array<float, %s> %s{{", size, name);
    for (std::size_t i = 0; i < values.size(); ++i) std::printf("%s%.5eF,", i % 9 == 0 ? "\n    " : " ", values[i]);
    std::printf("\n}};\n");
}

void check() {
    std::mt19937 random(77);
    double square = 0;
    double greatest = 0;
    std::vector<double> errors;
    constexpr int kPoints = 20000;
    for (int i = 0; i < kPoints; ++i) {
        const tables::Surface s = tables::randomSurface(random, 0.02F, 2, 20);
        const Vec3 w = tables::randomDirection(random, s);
        const double truth = tables::albedo(s.transform(), w, 4096);
        const double error = static_cast<double>(energy::singleScatterAlbedo(s.transform(), w)) - truth;
        errors.push_back(std::fabs(error));
        square += error * error;
        if (std::fabs(error) > greatest) {
            greatest = std::fabs(error);
            std::printf("alpha %g %g, z %g, azimuth %g: %g, found %+g\n", static_cast<double>(s.rougher), static_cast<double>(s.smoother),
                        static_cast<double>(w.z), static_cast<double>(std::atan2(w.y, w.x)), truth, error);
        }
    }
    std::sort(errors.begin(), errors.end());
    std::printf("albedo: rms %g, 99 %% %g, 99.9 %% %g, max %g\n", std::sqrt(square / kPoints), errors[kPoints * 99 / 100],
                errors[kPoints * 999 / 1000], greatest);
}

} // namespace

int main(int argc, char **argv) {
    if (argc > 1 && std::strcmp(argv[1], "--check") == 0) {
        check();
        return 0;
    }
    std::printf("#pragma once\n"
                "/// Chebyshev coefficients for energy_compensation.h. Written by taut_tables; not to be edited.\n\n"
                "#include <array>\n#include <cstddef>\n\nnamespace taut::energy::table {\n\n// clang-format off\n");
    namespace t = energy::table;
    std::printf("inline constexpr std::size_t kElevation = %zu;     ///< of the elevation\n", t::kElevation);
    std::printf("inline constexpr std::size_t kAlong = %zu;         ///< of the roughness along\n", t::kAlong);
    std::printf("inline constexpr std::size_t kAcross = %zu;        ///< of the roughness across\n", t::kAcross);
    std::printf("inline constexpr std::size_t kAverageDegree = %zu; ///< of both roughnesses, for the mean\n\n", t::kAverageDegree);
    std::printf("/// [elevation][along][correlation: constant, linear][across].\n");
    const std::vector<double> albedo = tables::fitAlbedo(40000, 4096);
    print("kAlbedo", "kElevation * kAlong * 2 * kAcross", albedo);
    std::printf("\n/// [rougher][smoother].\n");
    print("kAverage", "kAverageDegree * kAverageDegree", tables::fitAverage(albedo, 4000, 4096));
    std::printf("// clang-format on\n\n} // namespace taut::energy::table\n");
    return 0;
}

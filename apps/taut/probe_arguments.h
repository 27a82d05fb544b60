#pragma once
/// Arguments that the questions of `taut probe` share: the microsurface, directions, what scatters.

#include "taut/bsdf/bsdf_types.h"
#include "taut/microsurface/mesostructure.h"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace taut::app {

/// As typed. Angles in degrees.
struct ProbeArguments {
    std::vector<double> m;
    std::vector<double> alpha;
    double rotation = 0;
    std::vector<double> slope;  ///< of a mapped facet, with
    std::vector<double> deform; ///< a, b, c, d [, p, q [, lambda]]: F of the mesh
    double roughening = 0, yield = 0;
    double theta = 0, phi = 0;
    double thetaIn = 0, phiIn = 0;
    std::string mode = "correlated";
    double f0 = 1;
    std::uint32_t samples = 0;
    std::uint32_t seed = 1;
    std::string quantity = "fcos";
    std::string output;
    int width = 512;
    double scale = 0;
    std::size_t facets = 1000000;
    int bins = 32;
    bool json = true; ///< always: nothing else is printed
};

/// --m, --alpha, --rotation, --slope, --deform, --roughening and --yield.
void addMicrosurfaceArguments(CLI::App &command, ProbeArguments &arguments);
/// --theta, --phi.
void addViewArguments(CLI::App &command, ProbeArguments &arguments);
/// --mode, --f0, --samples (`what` says of what), --seed.
void addScatteringArguments(CLI::App &command, ProbeArguments &arguments, std::uint32_t samples, const std::string &what);

/// The transform that --m or --alpha, --slope and --deform name, in the frame of its normal. Throws InputError where there is none, or not
/// one alone.
GeneralTransform surfaceOf(const ProbeArguments &arguments);
/// For what counts normals about z: throws InputError where the surface is tilted.
MicroTransform microsurfaceOf(const ProbeArguments &arguments);
/// A reflector of Schlick's reflectance on that microsurface. Throws InputError.
Bsdf bsdfOf(const ProbeArguments &arguments, const MicroTransform &micro);
/// Unit, local: theta from z, phi from x towards y; degrees. Throws InputError naming `option` outside [0, 180].
Vec3 directionOf(double theta, double phi, const char *option);

} // namespace taut::app

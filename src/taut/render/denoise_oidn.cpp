#include "taut/render/denoise_oidn.h"

#include "taut/base/error.h"

#include <OpenImageDenoise/oidn.hpp>

#include <algorithm>
#include <limits>

namespace taut {

namespace {

/// Variance of the means of features up to which the library is told that they have no noise: what probes leave at outlines.
constexpr float kCleanNoise = 0.01F;

/// Channels side by side, held at what the library takes: albedo is at most 1. A pixel without a sample in one half, or with one that is
/// not believed, is given the mean.
std::vector<float> interleaved(const DenoisePixels &pixels, const std::array<Plane, 3> &planes, const Plane *share, float most) {
    std::vector<float> values(3 * pixels.count());
    for (std::size_t i = 0; i < pixels.count(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            values[3 * i + c] = std::min(most, share != nullptr && (*share)[i] == 0 ? pixels.mean[c][i] : planes[c][i]);
    return values;
}

bool areClean(const DenoisePixels &pixels) {
    bool clean = true;
    for (const Plane &noise : pixels.featureNoise)
        clean &= std::all_of(noise.begin(), noise.end(), [](float variance) { return variance <= kCleanNoise; });
    return clean;
}

/// The first error since the last call, of this thread.
void throwErrors(oidn::DeviceRef &device) {
    const char *message = nullptr;
    if (device.getError(message) != oidn::Error::None)
        throw RunError(std::string("Open Image Denoise: ") + (message != nullptr ? message : "an unknown error"));
}

void put(oidn::DeviceRef &device, oidn::FilterRef &filter, const char *name, const std::vector<float> &values, std::size_t width,
         std::size_t height, std::vector<oidn::BufferRef> &buffers) {
    oidn::BufferRef buffer = device.newBuffer(values.size() * sizeof(float));
    buffer.write(0, values.size() * sizeof(float), values.data());
    filter.setImage(name, buffer, oidn::Format::Float3, width, height);
    buffers.push_back(buffer);
}

} // namespace

Regressed openImageDenoise(const DenoisePixels &pixels) {
    Regressed out;
    out.known.assign(pixels.count(), 1);
    const auto width = static_cast<std::size_t>(pixels.width);
    const auto height = static_cast<std::size_t>(pixels.height);
    oidn::DeviceRef device = oidn::newDevice(oidn::DeviceType::CPU);
    throwErrors(device);              // none can be made
    device.set("setAffinity", false); // the threads' places are TBB's to choose
    device.commit();
    const bool clean = areClean(pixels);
    for (int half = 0; half < 2; ++half) {
        oidn::FilterRef filter = device.newFilter("RT");
        std::vector<oidn::BufferRef> buffers;
        std::vector<float> result(3 * pixels.count());
        put(device, filter, "color", interleaved(pixels, pixels.half[half], &pixels.share[half], std::numeric_limits<float>::max()), width,
            height, buffers);
        put(device, filter, "albedo", interleaved(pixels, pixels.albedo, nullptr, 1), width, height, buffers);
        put(device, filter, "normal", interleaved(pixels, pixels.normal, nullptr, 1), width, height, buffers);
        put(device, filter, "output", result, width, height, buffers);
        filter.set("hdr", true);
        filter.set("cleanAux", clean);
        filter.commit();
        filter.execute();
        throwErrors(device);
        buffers.back().read(0, result.size() * sizeof(float), result.data());
        for (std::size_t c = 0; c < 3; ++c) {
            Plane &plane = out.half[half][c];
            plane.assign(pixels.stored(), 0);
            for (std::size_t i = 0; i < pixels.count(); ++i) plane[i] = std::max(0.0F, result[3 * i + c]);
        }
    }
    return out;
}

} // namespace taut

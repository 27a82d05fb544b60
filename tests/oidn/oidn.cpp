/// The stand-in's filter and its rules.

#include "OpenImageDenoise/oidn.hpp"

#include <algorithm>
#include <cmath>

namespace oidn::standin {

World &world() {
    static World w;
    return w;
}

namespace {

constexpr std::size_t kPixel = 3 * sizeof(float);

std::size_t pixelStrideOf(const Picture &p) {
    return p.pixelStride != 0 ? p.pixelStride : kPixel;
}
std::size_t rowStrideOf(const Picture &p) {
    return p.rowStride != 0 ? p.rowStride : p.width * pixelStrideOf(p);
}
float *at(const Picture &p, std::size_t x, std::size_t y) {
    return reinterpret_cast<float *>(p.buffer->bytes.data() + p.offset + y * rowStrideOf(p) + x * pixelStrideOf(p));
}

std::vector<float> valuesOf(const Picture &p) {
    std::vector<float> values;
    for (std::size_t y = 0; y < p.height; ++y)
        for (std::size_t x = 0; x < p.width; ++x) values.insert(values.end(), at(p, x, y), at(p, x, y) + 3);
    return values;
}

bool areWithin(const std::vector<float> &values, float lower, float upper) {
    return std::all_of(values.begin(), values.end(), [&](float v) { return v >= lower && v <= upper; });
}

} // namespace

void setImage(Filter *filter, const std::string &name, const Picture &picture) {
    if (filter == nullptr || !picture.buffer) return world().fail(Error::InvalidArgument, "invalid handle");
    if (name != "color" && name != "albedo" && name != "normal" && name != "output")
        return world().fail(Error::InvalidArgument, "unknown filter image: " + name);
    if (picture.format != Format::Float3) return world().fail(Error::InvalidArgument, "unsupported image format: " + name);
    const std::size_t last = picture.offset + (picture.height - 1) * rowStrideOf(picture) + (picture.width - 1) * pixelStrideOf(picture);
    if (picture.width == 0 || picture.height == 0 || last + kPixel > picture.buffer->bytes.size())
        return world().fail(Error::InvalidArgument, "buffer region is out of range: " + name);
    filter->images[name] = picture;
    filter->committed = false;
}

void commit(Filter *filter) {
    if (filter == nullptr) return world().fail(Error::InvalidArgument, "invalid handle");
    const auto &images = filter->images;
    if (images.count("color") == 0) return world().fail(Error::InvalidOperation, "input image is not specified");
    if (images.count("output") == 0) return world().fail(Error::InvalidOperation, "output image is not specified");
    if (images.count("normal") != 0 && images.count("albedo") == 0)
        return world().fail(Error::InvalidOperation, "unsupported combination of input features");
    const Picture &color = images.at("color");
    for (const auto &[name, image] : images)
        if (image.width != color.width || image.height != color.height)
            return world().fail(Error::InvalidOperation, "image size mismatch: " + name);
    filter->committed = true;
}

void execute(Filter *filter) {
    if (filter == nullptr) return world().fail(Error::InvalidArgument, "invalid handle");
    if (!filter->committed) return world().fail(Error::InvalidOperation, "changes to the filter are not committed");
    const Picture &color = filter->images.at("color");
    const auto affinity = filter->device->parameters.find("setAffinity");
    Execution execution{color.width,
                        color.height,
                        filter->parameters["hdr"],
                        filter->parameters["cleanAux"],
                        affinity == filter->device->parameters.end() || affinity->second,
                        {}};
    for (const auto &[name, image] : filter->images)
        if (name != "output") execution.images[name] = valuesOf(image);
    const auto &images = execution.images;
    if (!areWithin(images.at("color"), 0, execution.hdr ? 3.4e38F : 1.0F)) world().fail(Error::InvalidArgument, "color beyond its range");
    if (images.count("albedo") != 0 && !areWithin(images.at("albedo"), 0, 1)) world().fail(Error::InvalidArgument, "albedo beyond [0, 1]");
    if (images.count("normal") != 0 && !areWithin(images.at("normal"), -1, 1))
        world().fail(Error::InvalidArgument, "normal beyond [-1, 1]");
    const Picture &output = filter->images.at("output");
    const std::vector<float> &from = images.at("color");
    for (std::size_t y = 0; y < color.height; ++y)
        for (std::size_t x = 0; x < color.width; ++x)
            for (std::size_t c = 0; c < 3; ++c) {
                float sum = 0;
                float count = 0;
                for (std::size_t v = y > 0 ? y - 1 : 0; v < std::min(color.height, y + 2); ++v)
                    for (std::size_t u = x > 0 ? x - 1 : 0; u < std::min(color.width, x + 2); ++u, ++count)
                        sum += from[3 * (v * color.width + u) + c];
                at(output, x, y)[c] = sum / count;
            }
    world().executions.push_back(std::move(execution));
}

} // namespace oidn::standin

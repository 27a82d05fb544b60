#include "study/measures/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace taut::chart {

namespace {

using Color = std::array<double, 3>;

// Section 4 of the paper.
constexpr double kColourExponent = 0.7; // q_c
constexpr double kColourKnee = 0.4;     // p_c, a share of the greatest difference
constexpr double kErrorAtKnee = 0.95;   // p_t
constexpr double kFeatureExponent = 0.5;
constexpr double kFeatureWidth = 0.082; // degrees

/// Linear Rec. 709 to XYZ, rows; white is (1, 1, 1) in RGB.
constexpr double kXyz[3][3] = {{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
                               {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                               {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}};
/// Its inverse.
constexpr double kRgb[3][3] = {{3.241003232976358, -1.537398969488785, -0.498615881996363},
                               {-0.969224252202516, 1.875929983695176, 0.041554226340085},
                               {0.055639419851975, -0.204011206123910, 1.057148977187533}};

Color times(const double (&m)[3][3], const Color &c) {
    Color out{};
    for (std::size_t i = 0; i < 3; ++i) out[i] = m[i][0] * c[0] + m[i][1] * c[1] + m[i][2] * c[2];
    return out;
}

/// XYZ over that of white.
Color relativeXyz(const Color &rgb) {
    static const Color white = times(kXyz, {1, 1, 1});
    const Color xyz = times(kXyz, rgb);
    return {xyz[0] / white[0], xyz[1] / white[1], xyz[2] / white[2]};
}

Color rgbOf(const Color &relative) {
    static const Color white = times(kXyz, {1, 1, 1});
    return times(kRgb, {relative[0] * white[0], relative[1] * white[1], relative[2] * white[2]});
}

/// Y Cx Cz, linear in XYZ.
Color opponentOf(const Color &rgb) {
    const Color r = relativeXyz(rgb);
    return {116 * r[1] - 16, 500 * (r[0] - r[1]), 200 * (r[1] - r[2])};
}

Color rgbOfOpponent(const Color &c) {
    const double y = (c[0] + 16) / 116;
    return rgbOf({y + c[1] / 500, y, y - c[2] / 200});
}

/// CIELAB, its colours less far apart where it is dark (Hunt).
Color labOf(const Color &rgb) {
    const Color r = relativeXyz(rgb);
    constexpr double kDelta = 6.0 / 29;
    const auto f = [](double t) { return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29; };
    const double lightness = 116 * f(r[1]) - 16;
    const double hunt = 0.01 * lightness;
    return {lightness, hunt * 500 * (f(r[0]) - f(r[1])), hunt * 200 * (f(r[1]) - f(r[2]))};
}

double hyab(const Color &a, const Color &b) {
    return std::fabs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

struct Plane {
    int width, height;
    std::vector<double> values;
    /// Beyond the edges the edge goes on.
    [[nodiscard]] double at(int x, int y) const {
        const int column = std::clamp(x, 0, width - 1);
        const int row = std::clamp(y, 0, height - 1);
        return values[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)];
    }
};

using Kernel = std::vector<double>; // [2 r + 1]

Plane filtered(const Plane &in, const Kernel &alongX, const Kernel &alongY) {
    const auto pass = [](const Plane &from, const Kernel &kernel, int dx, int dy) {
        Plane out{from.width, from.height, std::vector<double>(from.values.size())};
        const int radius = static_cast<int>(kernel.size()) / 2;
        for (int y = 0; y < from.height; ++y)
            for (int x = 0; x < from.width; ++x) {
                double sum = 0;
                for (int k = -radius; k <= radius; ++k)
                    sum += kernel[static_cast<std::size_t>(k + radius)] * from.at(x + k * dx, y + k * dy);
                out.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(from.width) + static_cast<std::size_t>(x)] = sum;
            }
        return out;
    };
    return pass(pass(in, alongX, 1, 0), alongY, 0, 1);
}

template <class F> Kernel kernelOf(int radius, const F &f) {
    Kernel kernel;
    for (int k = -radius; k <= radius; ++k) kernel.push_back(f(k));
    return kernel;
}

Kernel normalised(Kernel kernel) {
    double sum = 0;
    for (const double w : kernel) sum += w;
    for (double &w : kernel) w /= sum;
    return kernel;
}

/// Negative weights sum to -1 and positive ones to 1.
Kernel balanced(Kernel kernel) {
    double above = 0;
    double below = 0;
    for (const double w : kernel) (w > 0 ? above : below) += w;
    for (double &w : kernel) w /= w > 0 ? above : -below;
    return kernel;
}

/// What the eye's contrast sensitivity leaves of a channel: a sum of at most two Gaussians a sqrt(pi / b) exp(-pi^2 x^2 / b), normalised.
Plane seen(const Plane &channel, const std::array<double, 4> &csf, double pixelsADegree) {
    constexpr double kPi = std::numbers::pi;
    constexpr double kWidest = 0.04; // b of the widest
    const int radius = static_cast<int>(std::ceil(3 * std::sqrt(kWidest / (2 * kPi * kPi)) * pixelsADegree));
    const auto gaussian = [&](double b) {
        return kernelOf(radius, [&](int k) { return std::exp(-kPi * kPi * (k / pixelsADegree) * (k / pixelsADegree) / b); });
    };
    const auto weightOf = [&](double a, double b, const Kernel &kernel) {
        double sum = 0;
        for (const double w : kernel) sum += w;
        return a * std::sqrt(kPi / b) * sum * sum; // of the two-dimensional kernel
    };
    const auto [a1, b1, a2, b2] = csf;
    const Kernel first = gaussian(b1);
    const double w1 = weightOf(a1, b1, first);
    Plane out = filtered(channel, normalised(first), normalised(first));
    if (a2 == 0) return out;
    const Kernel second = gaussian(b2);
    const double w2 = weightOf(a2, b2, second);
    const Plane other = filtered(channel, normalised(second), normalised(second));
    for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] = (w1 * out.values[i] + w2 * other.values[i]) / (w1 + w2);
    return out;
}

/// How strong edges and points are.
struct Features {
    std::vector<double> edges, points;
};

Features featuresOf(const Plane &grey, double pixelsADegree) {
    const double sigma = 0.5 * kFeatureWidth * pixelsADegree;
    const int radius = static_cast<int>(std::ceil(3 * sigma));
    const auto gaussian = [&](double x) { return std::exp(-x * x / (2 * sigma * sigma)); };
    const Kernel smooth = normalised(kernelOf(radius, [&](int k) { return gaussian(k); }));
    const Kernel edge = balanced(kernelOf(radius, [&](int k) { return -k * gaussian(k); }));
    const Kernel point = balanced(kernelOf(radius, [&](int k) { return (k * k / (sigma * sigma) - 1) * gaussian(k); }));
    const auto strength = [&](const Kernel &kernel) {
        const Plane x = filtered(grey, kernel, smooth);
        const Plane y = filtered(grey, smooth, kernel);
        std::vector<double> lengths(x.values.size());
        for (std::size_t i = 0; i < lengths.size(); ++i) lengths[i] = std::hypot(x.values[i], y.values[i]);
        return lengths;
    };
    return {strength(edge), strength(point)};
}

/// What is looked at of a picture: its colours as they are seen, and its features.
struct SeenPicture {
    std::vector<Color> labs;
    Features features;
};

SeenPicture pictureOf(std::span<const float> rgb, int width, int height, double pixelsADegree) {
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    std::array<Plane, 3> channels;
    for (Plane &plane : channels) plane = {width, height, std::vector<double>(pixels)};
    Plane grey{width, height, std::vector<double>(pixels)};
    const auto held = [](float v) { return std::clamp(static_cast<double>(v), 0.0, 1.0); };
    for (std::size_t i = 0; i < pixels; ++i) {
        const Color c = opponentOf({held(rgb[3 * i]), held(rgb[3 * i + 1]), held(rgb[3 * i + 2])});
        for (std::size_t k = 0; k < 3; ++k) channels[k].values[i] = c[k];
        grey.values[i] = (c[0] + 16) / 116;
    }
    static constexpr std::array<std::array<double, 4>, 3> kCsf{{{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};
    for (std::size_t k = 0; k < 3; ++k) channels[k] = seen(channels[k], kCsf[k], pixelsADegree);
    SeenPicture picture;
    picture.labs.reserve(pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        Color c = rgbOfOpponent({channels[0].values[i], channels[1].values[i], channels[2].values[i]});
        for (double &v : c) v = std::clamp(v, 0.0, 1.0);
        picture.labs.push_back(labOf(c));
    }
    picture.features = featuresOf(grey, pixelsADegree);
    return picture;
}

/// Small differences take nearly all of the range.
double redistributed(double difference) {
    static const double greatest = std::pow(hyab(labOf({0, 1, 0}), labOf({0, 0, 1})), kColourExponent);
    const double knee = kColourKnee * greatest;
    const double power = std::pow(difference, kColourExponent);
    return power < knee ? kErrorAtKnee / knee * power : kErrorAtKnee + (power - knee) / (greatest - knee) * (1 - kErrorAtKnee);
}

} // namespace

std::vector<float> flip(std::span<const float> image, std::span<const float> reference, int width, int height, double pixelsADegree) {
    const SeenPicture a = pictureOf(image, width, height, pixelsADegree);
    const SeenPicture b = pictureOf(reference, width, height, pixelsADegree);
    std::vector<float> out;
    out.reserve(a.labs.size());
    for (std::size_t i = 0; i < a.labs.size(); ++i) {
        const double colour = redistributed(hyab(a.labs[i], b.labs[i]));
        const double edge = std::fabs(a.features.edges[i] - b.features.edges[i]);
        const double point = std::fabs(a.features.points[i] - b.features.points[i]);
        const double feature = std::pow(std::max(edge, point) / std::numbers::sqrt2, kFeatureExponent);
        out.push_back(static_cast<float>(std::pow(colour, 1 - feature)));
    }
    return out;
}

} // namespace taut::chart

#include "taut/export/gloss_mesh.h"

namespace taut {

namespace {

template <class V> const float *floatsOf(const std::vector<V> &values, int component = 0) {
    return values.empty() ? nullptr : &values.front()[component];
}

/// (M M^T)^-1 of M = [a b; 0 d]: xx, xy, yy, with `side` turning the y axis over.
DVec3 slopeTensor(const Vec3 &m, float side) {
    const double a = 1 / static_cast<double>(m.x);
    const double d = 1 / static_cast<double>(m.z);
    const double b = -static_cast<double>(m.y) * a * d; // M^-1 = [1/a, b; 0, 1/d]
    return {a * a, a * b * static_cast<double>(side), b * b + d * d};
}

} // namespace

std::vector<VertexAttribute> vertexAttributes(const GlossMesh &mesh) {
    std::vector<VertexAttribute> out{
        {"tangent", 3, 4, floatsOf(mesh.tangents)},
        {"tangent_sign", 1, 4, floatsOf(mesh.tangents, 3)},
        {"Pref", 3, 3, floatsOf(mesh.restPositions)},
        {"M", 3, 3, floatsOf(mesh.m)},
        {"M_p", 1, 2, floatsOf(mesh.lean)},
        {"M_q", 1, 2, floatsOf(mesh.lean, 1)},
        {"ds", 3, 3, floatsOf(mesh.ds)},
        {"dt", 3, 3, floatsOf(mesh.dt)},
        {"stretch_max", 1, 3, floatsOf(mesh.stretch)},
        {"stretch_min", 1, 3, floatsOf(mesh.stretch, 1)},
        {"det", 1, 3, floatsOf(mesh.stretch, 2)},
        {"stretch_dir", 3, 3, floatsOf(mesh.stretchDirection)},
        {"alpha_max", 1, 3, floatsOf(mesh.alpha)},
        {"alpha_min", 1, 3, floatsOf(mesh.alpha, 1)},
        {"phi", 1, 3, floatsOf(mesh.alpha, 2)},
        {"alpha_dir", 3, 3, floatsOf(mesh.alphaDirection)},
    };
    if (mesh.convention == nullptr) return out;
    const std::string prefix = std::string(mesh.convention->name) + "_";
    int component = 0;
    for (const std::string_view parameter : {mesh.convention->roughness, mesh.convention->anisotropy, mesh.convention->rotation}) {
        if (!parameter.empty()) out.push_back({prefix + std::string(parameter), 1, 3, floatsOf(mesh.conventionValues, component)});
        ++component;
    }
    return out;
}

std::string componentName(const VertexAttribute &attribute, int component) {
    return attribute.name + '_' + "xyzw"[component];
}

std::vector<VertexColumn> vertexColumns(const GlossMesh &mesh) {
    std::vector<VertexColumn> columns;
    const auto add = [&](std::initializer_list<const char *> names, std::size_t stride, const float *data) {
        for (const char *name : names) columns.push_back({name, stride, data++});
    };
    add({"x", "y", "z"}, 3, floatsOf(mesh.positions));
    add({"nx", "ny", "nz"}, 3, floatsOf(mesh.normals));
    if (!mesh.uvs.empty()) add({"s", "t"}, 2, floatsOf(mesh.uvs));
    for (const VertexAttribute &attribute : vertexAttributes(mesh))
        for (int c = 0; c < attribute.width; ++c) columns.push_back({componentName(attribute, c), attribute.stride, attribute.data + c});
    return columns;
}

std::vector<MeanGloss> meanGloss(const GlossMesh &mesh) {
    std::vector<DVec3> sums(mesh.materials.size(), DVec3(0));
    std::vector<std::size_t> counts(mesh.materials.size(), 0);
    const auto forEachCorner = [&](const auto &f) {
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                const Index v = mesh.triangles[t][k];
                f(mesh.triangleMaterials[t], slopeTensor(mesh.m[v], mesh.tangents[v].w));
            }
    };
    forEachCorner([&](Index material, const DVec3 &tensor) {
        sums[material] += tensor;
        ++counts[material];
    });
    std::vector<MeanGloss> out(mesh.materials.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
        if (counts[i] == 0) continue;
        const DVec3 &t = sums[i] /= static_cast<double>(counts[i]);
        const double middle = 0.5 * (t.x + t.z);
        const double radius = std::hypot(0.5 * (t.x - t.z), t.y);
        const double max = std::sqrt(middle + radius);
        // The determinant over the larger eigenvalue: the smaller one without cancellation.
        const double min = std::sqrt(std::fmax(0.0, t.x * t.z - t.y * t.y)) / max;
        out[i].alpha = {static_cast<float>(max), static_cast<float>(min), static_cast<float>(0.5 * std::atan2(2 * t.y, t.x - t.z))};
    }
    forEachCorner([&](Index material, const DVec3 &tensor) {
        const DVec3 d = glm::abs(tensor - sums[material]);
        const double difference = std::fmax(d.x, std::fmax(d.y, d.z)) / sqr(static_cast<double>(out[material].alpha.max));
        out[material].spread = std::fmax(out[material].spread, static_cast<float>(difference));
    });
    return out;
}

} // namespace taut

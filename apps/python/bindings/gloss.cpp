/// Gloss of points that somebody else moves: what `taut export` computes at the vertices, brought to the rows of the caller's arrays.

#include "mesh_arrays.h"

#include "taut/base/error.h"
#include "taut/base/parallel.h"
#include "taut/export/gloss_export.h"
#include "taut/scene/check_scene.h"
#include "taut/scene/material_presets.h"
#include "taut/scene/ranges.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <limits>
#include <mutex>

namespace taut::python {

namespace {

constexpr std::size_t kGrain = 8192;
constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

/// What the surface is made of, as taut.Gloss takes it.
struct GlossMaterialOptions {
    float rotation, poisson, roughening, yield;
};

/// Arrays of one frame, a row each.
struct GlossRows {
    explicit GlossRows(std::size_t rows)
        : m(newRows<float>(rows, 5)), alphaMax(newRows<float>(rows, 0)), alphaMin(newRows<float>(rows, 0)), phi(newRows<float>(rows, 0)),
          tangent(newRows<float>(rows, 3)), stretch(newRows<float>(rows, 2)) {}
    Array<float> m, alphaMax, alphaMin, phi, tangent, stretch;
};

class PointGloss {
  public:
    /// `alphas` is [1, 2], or [points, 2].
    PointGloss(const MeshArrays &arrays, const Array<float> &alphas, const GlossMaterialOptions &material, const std::string &gradient,
               bool perCorner) {
        const std::span<const Vec2> restAlphas = rowsOf<Vec2>(alphas);
        scene_.materials.push_back(toMaterial(restAlphas.front(), material));
        Object &object = scene_.objects.emplace_back();
        object.name = "gloss";
        object.mesh = meshOf(object.name, arrays);
        object.materials = {0};
        object.gradient = toEstimator(gradient);
        points_ = std::make_shared<CurrentPoints>(object.mesh->positions.size());
        object.points = points_;
        const py::gil_scoped_release unlocked;
        check(scene_);
        prepareGlossObject(scene_, object, gloss_);
        if (restAlphas.size() > 1) setRestAlphas(restAlphas);
        perCorner ? findCorners() : findPoints();
    }

    /// M, alphaMax, alphaMin, phi, tangent, stretch of the rows where the points are at `deformed`, which is read in place.
    py::tuple at(const Array<float> &deformed) {
        GlossRows out(rows_.size());
        float *m = out.m.mutable_data();
        float *alphaMax = out.alphaMax.mutable_data();
        float *alphaMin = out.alphaMin.mutable_data();
        float *phi = out.phi.mutable_data();
        float *tangent = out.tangent.mutable_data();
        float *stretch = out.stretch.mutable_data();
        {
            const std::span<const Vec3> positions = rowsOf<Vec3>(deformed);
            const py::gil_scoped_release unlocked;
            const std::lock_guard<std::mutex> alone(busy_);
            points_->set(positions);
            glossAtFrame(scene_, 1, {}, gloss_);
            const GlossMesh &mesh = gloss_.mesh;
            parallelFor(rows_.size(), kGrain, [&](std::size_t row) {
                const Index v = rows_[row];
                const bool known = v != kNone;
                const auto put = [&](float *to, std::initializer_list<float> values) {
                    for (const float value : values) *to++ = known ? value : kNothing;
                };
                const Index from = known ? v : 0;
                put(m + 5 * row, {mesh.m[from].x, mesh.m[from].y, mesh.m[from].z, mesh.lean[from].x, mesh.lean[from].y});
                put(alphaMax + row, {mesh.alpha[from].x});
                put(alphaMin + row, {mesh.alpha[from].y});
                put(phi + row, {mesh.alpha[from].z});
                put(tangent + 3 * row, {mesh.tangents[from].x, mesh.tangents[from].y, mesh.tangents[from].z});
                put(stretch + 2 * row, {mesh.stretch[from].x, mesh.stretch[from].y});
            });
        }
        return py::make_tuple(out.m, out.alphaMax, out.alphaMin, out.phi, out.tangent, out.stretch);
    }

    [[nodiscard]] std::size_t points() const { return points_->points(); }
    [[nodiscard]] std::size_t rows() const { return rows_.size(); }
    [[nodiscard]] std::size_t vertices() const { return gloss_.sources.size(); }
    [[nodiscard]] std::size_t splitPoints() const { return splitPoints_; }
    [[nodiscard]] std::size_t loosePoints() const { return loosePoints_; }

  private:
    static Material toMaterial(const Vec2 &alpha, const GlossMaterialOptions &options) {
        Material material;
        material.name = "gloss";
        material.type = BsdfType::Conductor;
        material.alphaX.value = alpha.x;
        material.alphaY.value = alpha.y;
        material.rotation.value = options.rotation;
        material.poisson = options.poisson;
        material.roughening = options.roughening;
        material.yield = options.yield;
        return material;
    }
    /// Of points, each in the range of a material's.
    void setRestAlphas(std::span<const Vec2> alphas) {
        for (std::size_t point = 0; point < alphas.size(); ++point)
            for (const float alpha : {alphas[point].x, alphas[point].y})
                if (!kAlpha.contains(static_cast<double>(alpha)))
                    failInput({"alpha[" + std::to_string(point) + "]"}, formatNumber(alpha), describe(kAlpha));
        gloss_.restAlphas.resize(gloss_.sources.size());
        for (Index v = 0; v < gloss_.sources.size(); ++v) gloss_.restAlphas[v] = alphas[pointOf(v)];
    }
    static std::optional<GradientEstimator> toEstimator(const std::string &name) {
        if (name == "auto") return std::nullopt;
        std::vector<std::string_view> names{"auto"};
        for (const auto &[value, known] : kEstimators) {
            if (name == known) return value;
            names.emplace_back(known);
        }
        failUnknownName({"gradient"}, name, names);
    }
    [[nodiscard]] Index pointOf(Index vertex) const {
        const Surface &surface = gloss_.surface.surface;
        return surface.surfacePosition[surface.vertexSurface[gloss_.sources[vertex]]];
    }

    /// Whether two vertices at a point have one rest frame: a seam of uvs where the map runs on parts nothing.
    [[nodiscard]] bool sharesFrame(Index a, Index b) const {
        constexpr float kSame = 1e-3F;
        const Surface &surface = gloss_.surface.surface;
        const Index sourceA = gloss_.sources[a];
        const Index sourceB = gloss_.sources[b];
        const Vec4 difference = surface.tangentCoefficients[sourceA] - surface.tangentCoefficients[sourceB];
        return surface.vertexSurface[sourceA] == surface.vertexSurface[sourceB] && glm::dot(difference, difference) < kSame * kSame;
    }

    /// A point has the gloss of the first corner that is there, in the order of the faces.
    void findPoints() {
        rows_.assign(points(), kNone);
        std::vector<unsigned char> split(points(), 0);
        for (const Index3 &triangle : gloss_.mesh.triangles)
            for (int k = 0; k < 3; ++k) {
                Index &row = rows_[pointOf(triangle[k])];
                if (row == kNone) row = triangle[k];
                if (!sharesFrame(row, triangle[k])) split[pointOf(triangle[k])] = 1;
            }
        splitPoints_ = static_cast<std::size_t>(std::count(split.begin(), split.end(), 1));
        loosePoints_ = static_cast<std::size_t>(std::count(rows_.begin(), rows_.end(), kNone));
    }

    /// A polygon of n corners has n - 2 triangles, which name each of its corners (triangulate.h).
    void findCorners() {
        const Mesh &mesh = *scene_.objects.front().mesh;
        rows_.assign(mesh.cornerCount(), kNone);
        std::size_t t = 0;
        for (std::size_t face = 0; face < mesh.faceCount(); ++face) {
            const Index begin = mesh.faceOffsets[face];
            const Index end = mesh.faceOffsets[face + 1];
            for (const std::size_t last = t + (end - begin - 2); t < last; ++t)
                for (int k = 0; k < 3; ++k)
                    for (Index corner = begin; corner < end; ++corner)
                        if (mesh.cornerPositions[corner] == pointOf(gloss_.mesh.triangles[t][k]))
                            rows_[corner] = gloss_.mesh.triangles[t][k];
        }
    }

    Scene scene_;
    std::shared_ptr<CurrentPoints> points_;
    GlossObject gloss_;
    std::vector<Index> rows_; // [points or corners] -> vertex of gloss_.mesh, kNone where there is no face
    std::size_t splitPoints_ = 0, loosePoints_ = 0;
    std::mutex busy_; // one frame at a time
};

/// The number that was written, not its nearest float.
py::object asWritten(float value) {
    return py::float_(py::str(fmt::format("{}", value)));
}

/// name -> the arguments of taut.Gloss that make it.
py::dict presets() {
    py::dict all;
    for (const MaterialPreset &preset : materialPresets()) {
        const Material &m = preset.material;
        py::dict one;
        one["alpha"] = py::make_tuple(asWritten(m.alphaX.value), asWritten(m.alphaY.value));
        one["poisson"] = asWritten(m.poisson);
        one["roughening"] = asWritten(m.roughening);
        one["yield_strain"] = asWritten(m.yield);
        all[py::str(std::string(preset.name))] = one;
    }
    return all;
}

} // namespace

void addGloss(py::module_ &module) {
    py::class_<PointGloss>(module, "PointGloss")
        .def(py::init([](const Array<float> &rest, const Array<std::uint32_t> &starts, const Array<std::uint32_t> &corners,
                         const std::optional<Array<float>> &uvs, const std::optional<Array<float>> &normals, const Array<float> &alphas,
                         const std::array<float, 4> &material, const std::string &gradient, bool perCorner) {
                 return std::make_unique<PointGloss>(MeshArrays{rest, starts, corners, uvs, normals}, alphas,
                                                     GlossMaterialOptions{material[0], material[1], material[2], material[3]}, gradient,
                                                     perCorner);
             }),
             py::arg("rest").noconvert(), py::arg("starts").noconvert(), py::arg("corners").noconvert(), py::arg("uvs").noconvert(),
             py::arg("normals").noconvert(), py::arg("alphas").noconvert(), py::arg("material"), py::arg("gradient"), py::arg("per_corner"))
        .def("at", &PointGloss::at, py::arg("deformed").noconvert())
        .def_property_readonly("points", &PointGloss::points)
        .def_property_readonly("rows", &PointGloss::rows)
        .def_property_readonly("vertices", &PointGloss::vertices)
        .def_property_readonly("split_points", &PointGloss::splitPoints)
        .def_property_readonly("loose_points", &PointGloss::loosePoints);
    module.attr("presets") = presets();
}

} // namespace taut::python

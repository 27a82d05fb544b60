/// M over arrays: made, deformed, brought to canonical form, turned into the parameters of other renderers and back.

#include "row_functions.h"

#include "taut/microsurface/conventions.h"
#include "taut/microsurface/general_transform.h"

namespace taut::python {

namespace {

template <class T> void putTransform(T *to, const BasicMicroTransform<T> &m) {
    for (const T value : {m.a, m.b, m.d, m.p, m.q}) *to++ = value;
}

/// M a row, of `make(row)`.
template <class T, class Make> py::object transformsOf(std::size_t count, const Make &make) {
    Array<T> out = newRows<T>(count, 5);
    T *to = out.mutable_data();
    forRows(count, [&](std::size_t row) { putTransform<T>(to + 5 * row, make(row)); });
    return out;
}

py::object fromAlpha(const py::array &alphas, const py::array &rotations) {
    return byType(alphas, [&]<class T>() {
        const Rows<T> alpha(alphas);
        const Rows<T> rotation(rotations);
        for (std::size_t row = 0; row < alpha.rows; ++row)
            if (!(alpha.at(row)[0] > 0 && alpha.at(row)[1] > 0))
                failInput({"alpha[" + std::to_string(row) + "]"},
                          formatNumber(static_cast<double>(alpha.at(row)[0])) + ", " + formatNumber(static_cast<double>(alpha.at(row)[1])),
                          "two numbers above 0");
        return transformsOf<T>(rowCount(alpha, rotation), [&](std::size_t row) {
            return microTransformFromAlpha<T>(alpha.at(row)[0], alpha.at(row)[1], rotation.at(row)[0]);
        });
    });
}

py::object canonical(const py::array &blocks, const py::array &leans) {
    return byType(blocks, [&]<class T>() {
        const Rows<T> block(blocks); // [a b; c d] by rows
        const Rows<T> lean(leans);
        return transformsOf<T>(rowCount(block, lean), [&](std::size_t row) {
            const T *b = block.at(row);
            return microTransform<T>(b[0], b[1], b[2], b[3], lean.at(row)[0], lean.at(row)[1]);
        });
    });
}

py::object deform(const py::array &gradients, const py::array &transforms, const py::array &stretches, const py::array &leans) {
    return byType(gradients, [&]<class T>() {
        const Rows<T> gradient(gradients); // A by rows
        const TransformRows<T> m(transforms);
        const Rows<T> lambda(stretches);
        const Rows<T> lean(leans);
        m.check();
        return transformsOf<T>(rowCount(gradient, m, lambda, lean), [&](std::size_t row) {
            const T *a = gradient.at(row);
            return deformedTransform<T>(BasicBlock<T>{a[0], a[1], a[2], a[3]}, m.transformAt(row), lambda.at(row)[0],
                                        Vector2<T>(lean.at(row)[0], lean.at(row)[1]));
        });
    });
}

py::object equivalentAlphas(const py::array &transforms) {
    return byType(transforms, [&]<class T>() -> py::object {
        const TransformRows<T> m(transforms);
        m.check();
        Array<T> out = newRows<T>(m.rows, 3);
        T *to = out.mutable_data();
        forRows(m.rows, [&](std::size_t row) {
            const auto alpha = equivalentAlpha(m.transformAt(row));
            to[3 * row] = alpha.max;
            to[3 * row + 1] = alpha.min;
            to[3 * row + 2] = alpha.phi;
        });
        return out;
    });
}

py::object slopeTensors(const py::array &transforms) {
    return byType(transforms, [&]<class T>() -> py::object {
        const TransformRows<T> m(transforms);
        m.check();
        Array<T> out = newRows<T>(m.rows, 3);
        T *to = out.mutable_data();
        forRows(m.rows, [&](std::size_t row) {
            const auto sigma = slopeTensor(m.transformAt(row));
            to[3 * row] = sigma.xx;
            to[3 * row + 1] = sigma.xy;
            to[3 * row + 2] = sigma.yy;
        });
        return out;
    });
}

/// Of [m00 m01 .. m22] by rows.
DMat3 matrixAt(const Rows<double> &matrices, std::size_t row) {
    DMat3 m;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) m[c][r] = matrices.at(row)[3 * r + c];
    return m;
}

py::tuple generalTransforms(const py::array &given) {
    const Rows<double> matrices(given);
    Array<double> transforms = newRows<double>(matrices.rows, 5);
    Array<double> frames = newRows<double>(matrices.rows, 9);
    double *m = transforms.mutable_data();
    double *frame = frames.mutable_data();
    std::atomic<std::size_t> bad{matrices.rows};
    forRows(matrices.rows, [&](std::size_t row) {
        const std::optional<GeneralTransform> general = generalTransform(matrixAt(matrices, row));
        if (!general) {
            bad = row;
            return;
        }
        const MicroTransform &micro = general->micro;
        const std::array<float, 5> values{micro.a, micro.b, micro.d, micro.p, micro.q};
        for (std::size_t c = 0; c < 5; ++c) m[5 * row + c] = static_cast<double>(values[c]);
        const std::array<Vec3, 3> axes{general->frame.s, general->frame.t, general->frame.n};
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (int c = 0; c < 3; ++c) frame[9 * row + 3 * axis + static_cast<std::size_t>(c)] = static_cast<double>(axes[axis][c]);
    });
    if (bad != matrices.rows) failInput({"T[" + std::to_string(bad) + "]"}, "a matrix without an inverse", "an invertible 3 x 3 matrix");
    return py::make_tuple(transforms, frames);
}

py::object generalD(const py::array &given, const py::array &normals) {
    const Rows<double> matrices(given);
    const Rows<double> normal(normals);
    const std::size_t count = rowCount(matrices, normal);
    Array<double> out = newRows<double>(count, 0);
    double *to = out.mutable_data();
    forRows(count, [&](std::size_t row) { to[row] = generalDistribution(matrixAt(matrices, row), normal.vectorAt(row)); });
    return out;
}

const ConventionInfo &conventionNamed(const std::string &name) {
    std::vector<std::string_view> names;
    for (const ConventionInfo &info : kConventions) {
        if (info.name == name) return info;
        names.push_back(info.name);
    }
    failUnknownName({"convention"}, name, names);
}

/// [alphaMax alphaMin phi] a row to [roughness anisotropy rotation], and whether it was clipped.
py::tuple toConventions(const std::string &name, const py::array &given) {
    const ConventionInfo &info = conventionNamed(name);
    const Rows<float> alphas(given);
    Array<float> out = newRows<float>(alphas.rows, 3);
    Array<bool> clipped = newRows<bool>(alphas.rows, 0);
    float *to = out.mutable_data();
    bool *toClipped = clipped.mutable_data();
    forRows(alphas.rows, [&](std::size_t row) {
        const float *alpha = alphas.at(row);
        const ConventionValues values = toConvention(info.convention, {alpha[0], alpha[1], alpha[2]});
        to[3 * row] = values.roughness;
        to[3 * row + 1] = values.anisotropy;
        to[3 * row + 2] = values.rotation;
        toClipped[row] = values.clipped;
    });
    return py::make_tuple(out, clipped);
}

py::object fromConventions(const std::string &name, const py::array &given) {
    const ConventionInfo &info = conventionNamed(name);
    const Rows<float> values(given);
    Array<float> out = newRows<float>(values.rows, 3);
    float *to = out.mutable_data();
    forRows(values.rows, [&](std::size_t row) {
        const float *v = values.at(row);
        const EquivalentAlpha alpha = fromConvention(info.convention, {v[0], v[1], v[2], false});
        to[3 * row] = alpha.max;
        to[3 * row + 1] = alpha.min;
        to[3 * row + 2] = alpha.phi;
    });
    return out;
}

py::object normalStretches(const py::array &areas, float poisson) {
    const Rows<float> area(areas);
    Array<float> out = newRows<float>(area.rows, 0);
    float *to = out.mutable_data();
    forRows(area.rows, [&](std::size_t row) { to[row] = normalStretch(area.at(row)[0], poisson); });
    return out;
}

} // namespace

void addTransforms(py::module_ &part) {
    part.def("from_alpha", fromAlpha);
    part.def("canonical", canonical);
    part.def("deform", deform);
    part.def("equivalent_alpha", equivalentAlphas);
    part.def("slope_tensor", slopeTensors);
    part.def("general_transform", generalTransforms);
    part.def("general_D", generalD);
    part.def("to_convention", toConventions);
    part.def("from_convention", fromConventions);
    part.def("normal_stretch", normalStretches);
    py::list names;
    for (const ConventionInfo &info : kConventions)
        names.append(
            py::make_tuple(std::string(info.name), std::string(info.roughness), std::string(info.anisotropy), std::string(info.rotation)));
    part.attr("conventions") = names;
}

} // namespace taut::python

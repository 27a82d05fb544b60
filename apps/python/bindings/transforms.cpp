/// M over arrays: made, deformed, roughened, of facets of a map, brought to canonical form, turned into the parameters of other renderers
/// and back.

#include "row_functions.h"

#include "taut/microsurface/conventions.h"
#include "taut/microsurface/mesostructure.h"

#include <atomic>

namespace taut::python {

namespace {

py::object fromAlpha(const py::array &alphas, const py::array &rotations) {
    return byType(alphas, [&]<class T>() {
        const Rows<T> alpha(alphas);
        const Rows<T> rotation(rotations);
        for (std::size_t row = 0; row < alpha.rows; ++row)
            if (const Vector2<T> pair = alpha.pairAt(row); !(pair.x > 0 && pair.y > 0))
                failInput({"alpha[" + std::to_string(row) + "]"},
                          formatNumber(static_cast<double>(pair.x)) + ", " + formatNumber(static_cast<double>(pair.y)),
                          "two numbers above 0");
        return tableOf(rowCount(alpha, rotation), [&](std::size_t row) {
            return microTransformFromAlpha<T>(alpha.at(row)[0], alpha.at(row)[1], rotation.numberAt(row));
        });
    });
}

py::object canonical(const py::array &blocks, const py::array &leans) {
    return byType(blocks, [&]<class T>() {
        const Rows<T> block(blocks);
        const Rows<T> lean(leans);
        return tableOf(rowCount(block, lean), [&](std::size_t row) {
            const BasicBlock<T> b = block.blockAt(row);
            return microTransform<T>(b.a, b.b, b.c, b.d, lean.at(row)[0], lean.at(row)[1]);
        });
    });
}

py::object deform(const py::array &gradients, const py::array &transforms, const py::array &stretches, const py::array &leans) {
    return byType(gradients, [&]<class T>() {
        const Rows<T> gradient(gradients);
        const TransformRows<T> m(transforms);
        const Rows<T> lambda(stretches);
        const Rows<T> lean(leans);
        return tableOf(rowCount(gradient, m, lambda, lean), [&](std::size_t row) {
            return deformedTransform<T>(gradient.blockAt(row), m.transformAt(row), lambda.numberAt(row), lean.pairAt(row));
        });
    });
}

/// What f makes of each M, in its own type.
template <class F> py::object ofTransforms(const py::array &transforms, const F &f) {
    return byType(transforms, [&]<class T>() {
        const TransformRows<T> m(transforms);
        return tableOf(m.rows, [&](std::size_t row) { return f(m.transformAt(row)); });
    });
}
template <class T> std::array<T, 3> cells(const BasicEquivalentAlpha<T> &alpha) {
    return {alpha.max, alpha.min, alpha.phi};
}
template <class T> std::array<T, 3> cells(const SlopeTensor<T> &sigma) {
    return {sigma.xx, sigma.xy, sigma.yy};
}

/// M and, by rows, the axes of its frame; `make(row)` is an std::optional<GeneralTransform>. Throws at a row where it is nothing.
template <class Make> py::object generalTable(const std::string &name, std::size_t count, const Make &make) {
    std::atomic<std::size_t> bad{count};
    py::object table = tableOf(count, [&](std::size_t row) {
        const std::optional<GeneralTransform> general = make(row);
        if (!general) bad = row;
        const GeneralTransform g = general.value_or(GeneralTransform());
        std::array<double, 9> axes{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (std::size_t c = 0; c < 3; ++c)
                axes[3 * axis + c] = static_cast<double>(std::array{g.frame.s, g.frame.t, g.frame.n}[axis][static_cast<int>(c)]);
        const MicroTransform &m = g.micro;
        return std::tuple(std::array{double(m.a), double(m.b), double(m.d), double(m.p), double(m.q)}, axes);
    });
    if (bad != count) failInput({name + "[" + std::to_string(bad) + "]"}, "a matrix without an inverse", "an invertible 3 x 3 matrix");
    return table;
}

py::object generalTransforms(const py::array &given) {
    const Rows<double> matrices(given);
    return generalTable("T", matrices.rows, [&](std::size_t row) { return generalTransform(matrices.matrixAt(row)); });
}

py::object generalD(const py::array &given, const py::array &normals) {
    const Rows<double> matrices(given);
    const Rows<double> normal(normals);
    return tableOf(rowCount(matrices, normal),
                   [&](std::size_t row) { return generalDistribution(matrices.matrixAt(row), normal.vectorAt(row)); });
}

// --- roughening and mesostructure ---

/// [larger smaller], the stretches of a surface.
py::object equivalentStrains(const py::array &stretches) {
    const Rows<double> stretch(stretches);
    return tableOf(stretch.rows, [&](std::size_t row) { return equivalentStrain(stretch.at(row)[0], stretch.at(row)[1]); });
}

py::object roughen(const py::array &transforms, const py::array &strains, double roughening, double yield) {
    const TransformRows<float> m(transforms);
    const Rows<double> strain(strains);
    return tableOf(rowCount(m, strain),
                   [&](std::size_t row) { return roughened(m.transformAt(row), addedAlpha(strain.numberAt(row), roughening, yield)); });
}

py::object carriedSlopes(const py::array &deformations, const py::array &slopes) {
    const Rows<double> deformation(deformations);
    const Rows<double> slope(slopes);
    return tableOf(rowCount(deformation, slope), [&](std::size_t row) {
        const DVec2 carried = carriedSlope(deformation.matrixAt(row), slope.pairAt(row));
        return std::array{carried.x, carried.y};
    });
}

/// M of facets of a map, in the space that the deformation leads to, and its frame.
py::object mappedTransforms(const py::array &deformations, const py::array &slopes, const py::array &transforms, const py::array &spreads) {
    const Rows<double> deformation(deformations);
    const Rows<double> slope(slopes);
    const TransformRows<double> m(transforms);
    const Rows<double> spread(spreads);
    return generalTable("F", rowCount(deformation, slope, m, spread), [&](std::size_t row) {
        const auto rest = m.transformAt(row);
        return mappedTransform(deformation.matrixAt(row), {Vec2(slope.pairAt(row)), Vec3(spread.vectorAt(row))},
                               BasicBlock<double>{rest.a, rest.b, 0, rest.d});
    });
}

// --- other renderers ---

const ConventionInfo &conventionNamed(const std::string &name) {
    std::vector<std::string_view> names;
    for (const ConventionInfo &info : kConventions) {
        if (info.name == name) return info;
        names.push_back(info.name);
    }
    failUnknownName({"convention"}, name, names);
}

/// [alphaMax alphaMin phi] a row to [roughness anisotropy rotation], and whether it was clipped.
py::object toConventions(const std::string &name, const py::array &given) {
    const ConventionInfo &info = conventionNamed(name);
    const Rows<float> alphas(given);
    return tableOf(alphas.rows, [&](std::size_t row) {
        const float *alpha = alphas.at(row);
        const ConventionValues values = toConvention(info.convention, {alpha[0], alpha[1], alpha[2]});
        return std::tuple(std::array{values.roughness, values.anisotropy, values.rotation}, values.clipped);
    });
}

py::object fromConventions(const std::string &name, const py::array &given) {
    const ConventionInfo &info = conventionNamed(name);
    const Rows<float> values(given);
    return tableOf(values.rows, [&](std::size_t row) {
        const float *v = values.at(row);
        return cells(fromConvention(info.convention, {v[0], v[1], v[2], false}));
    });
}

py::object normalStretches(const py::array &areas, float poisson) {
    const Rows<float> area(areas);
    return tableOf(area.rows, [&](std::size_t row) { return normalStretch(area.numberAt(row), poisson); });
}

} // namespace

void addTransforms(py::module_ &part) {
    part.def("from_alpha", fromAlpha);
    part.def("canonical", canonical);
    part.def("deform", deform);
    part.def("equivalent_alpha",
             [](const py::array &m) { return ofTransforms(m, [](const auto &t) { return cells(equivalentAlpha(t)); }); });
    part.def("slope_tensor", [](const py::array &m) { return ofTransforms(m, [](const auto &t) { return cells(slopeTensor(t)); }); });
    part.def("general_transform", generalTransforms);
    part.def("general_D", generalD);
    part.def("equivalent_strain", equivalentStrains);
    part.def("roughen", roughen);
    part.def("carried_slope", carriedSlopes);
    part.def("mapped_transform", mappedTransforms);
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

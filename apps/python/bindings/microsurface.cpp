/// The transformed GGX over arrays: the functions of microsurface/ggx.h a row each, in float or double as the arrays are. What there is a
/// vectorised loop for (study/microsurface/batch.h) goes through that, in blocks; it gives the same bits.

#include "row_functions.h"

#include "study/microsurface/batch.h"
#include "taut/microsurface/energy_compensation.h"
#include "taut/microsurface/ggx.h"
#include "taut/microsurface/random_walk.h"

namespace taut::python {

namespace {

/// Arrays of one block of rows, as batch.h takes them.
struct Block {
    static constexpr std::size_t kSize = 256;
    float a[kSize], b[kSize], d[kSize], p[kSize], q[kSize];
    float ox[kSize], oy[kSize], oz[kSize];
    float ix[kSize], iy[kSize], iz[kSize];
    float ux[kSize], uy[kSize];
    float value[kSize], pdf[kSize];

    void setTransform(const TransformRows<float> &m, std::size_t row, std::size_t i) {
        const float *from = m.at(row);
        const bool leans = m.width > 3;
        a[i] = from[0];
        b[i] = from[1];
        d[i] = from[2];
        p[i] = leans ? from[3] : 0;
        q[i] = leans ? from[4] : 0;
    }
    static void set(const Rows<float> &from, std::size_t row, std::size_t i, float *x, float *y, float *z) {
        const float *v = from.at(row);
        x[i] = v[0];
        y[i] = v[1];
        z[i] = v[2];
    }
    [[nodiscard]] batch::Transforms transforms() const { return {a, b, d, p, q}; }
    [[nodiscard]] batch::Vectors wo() const { return {ox, oy, oz}; }
    [[nodiscard]] batch::Vectors wi() const { return {ix, iy, iz}; }
};

/// f(block, first row, rows) for blocks of all rows.
template <class F> void forBlocks(std::size_t count, const F &f) {
    const py::gil_scoped_release unlocked;
    parallelFor((count + Block::kSize - 1) / Block::kSize, 4, [&](std::size_t number) {
        Block block;
        const std::size_t first = number * Block::kSize;
        f(block, first, std::min(Block::kSize, count - first));
    });
}

/// Density of a reflection by caps, as sampleReflection() has it.
template <class T> T reflectionPdf(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector3<T> &wi, bool bounded) {
    if (!(wi.z > 0)) return 0;
    const T length = ggx::stretchedLength(m, wo);
    const T area = ggx::visibleArea(m, wo, length);
    const T k = bounded ? ggx::capBound(m, wo) : T(1);
    return ggx::distribution(m, wo, wi) / (2 * ggx::capArea(k, wo.z, length, area));
}

template <class T> T reflectionFCos(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector3<T> &wi, bool correlated) {
    return wi.z > 0 ? reflectionPdf(m, wo, wi, false) * ggx::reflectionWeight(m, wo, wi, correlated) : T(0);
}

/// One number a row, of M and one direction.
template <class F> py::object numberOfDirection(const py::array &transforms, const py::array &direction, const F &f) {
    return byType(transforms, [&]<class T>() -> py::object {
        const TransformRows<T> m(transforms);
        const Rows<T> w(direction);
        m.check();
        const std::size_t count = rowCount(m, w);
        Array<T> out = newRows<T>(count, 0);
        T *to = out.mutable_data();
        forRows(count, [&](std::size_t row) { to[row] = f(m.transformAt(row), w.vectorAt(row)); });
        return out;
    });
}
/// ... and of two.
template <class F> py::object numberOfDirections(const py::array &transforms, const py::array &first, const py::array &second, const F &f) {
    return byType(transforms, [&]<class T>() -> py::object {
        const TransformRows<T> m(transforms);
        const Rows<T> wo(first);
        const Rows<T> wi(second);
        m.check();
        const std::size_t count = rowCount(m, wo, wi);
        Array<T> out = newRows<T>(count, 0);
        T *to = out.mutable_data();
        forRows(count, [&](std::size_t row) { to[row] = f(m.transformAt(row), wo.vectorAt(row), wi.vectorAt(row)); });
        return out;
    });
}

/// One number a row by a vectorised loop `run(block, rows)` that leaves it in block.value.
template <class Run>
py::object batchedNumber(const py::array &transforms, const py::array &first, const py::array &second, const Run &run) {
    const TransformRows<float> m(transforms);
    const Rows<float> wo(first);
    const Rows<float> wi(second);
    m.check();
    const std::size_t count = rowCount(m, wo, wi);
    Array<float> out = newRows<float>(count, 0);
    float *to = out.mutable_data();
    forBlocks(count, [&](Block &block, std::size_t begin, std::size_t rows) {
        for (std::size_t i = 0; i < rows; ++i) {
            block.setTransform(m, begin + i, i);
            Block::set(wo, begin + i, i, block.ox, block.oy, block.oz);
            Block::set(wi, begin + i, i, block.ix, block.iy, block.iz);
        }
        run(block, rows);
        std::copy(block.value, block.value + rows, to + begin);
    });
    return out;
}

py::object evaluate(const py::array &m, const py::array &wo, const py::array &wi, bool correlated) {
    if (isDouble(m)) return numberOfDirections(m, wo, wi, [&](auto t, auto o, auto i) { return reflectionFCos(t, o, i, correlated); });
    return batchedNumber(
        m, wo, wi, [&](Block &b, std::size_t rows) { batch::evaluate(b.transforms(), b.wo(), b.wi(), rows, correlated, b.value, b.pdf); });
}

py::object pdf(const py::array &m, const py::array &wo, const py::array &wi, bool bounded) {
    if (isDouble(m) || bounded)
        return numberOfDirections(m, wo, wi, [&](auto t, auto o, auto i) { return reflectionPdf(t, o, i, bounded); });
    return batchedNumber(m, wo, wi,
                         [&](Block &b, std::size_t rows) { batch::evaluate(b.transforms(), b.wo(), b.wi(), rows, true, b.pdf, b.value); });
}

py::object weight(const py::array &m, const py::array &wo, const py::array &wi, bool correlated, bool bounded) {
    if (isDouble(m) || bounded)
        return numberOfDirections(m, wo, wi, [&]<class T>(const BasicMicroTransform<T> &t, const Vector3<T> &o, const Vector3<T> &i) -> T {
            if (!(i.z > 0)) return 0;
            const T length = ggx::stretchedLength(t, o);
            const T area = ggx::visibleArea(t, o, length);
            const T k = bounded ? ggx::capBound(t, o) : T(1);
            return ggx::reflectionWeight(t, o, i, correlated) * (ggx::capArea(k, o.z, length, area) / area);
        });
    return batchedNumber(m, wo, wi,
                         [&](Block &b, std::size_t rows) { batch::weight(b.transforms(), b.wo(), b.wi(), rows, correlated, b.value); });
}

template <class T> py::object sampleRows(const py::array &transforms, const py::array &first, const py::array &numbers, bool bounded) {
    const TransformRows<T> m(transforms);
    const Rows<T> wo(first);
    const Rows<T> u(numbers);
    m.check();
    const std::size_t count = rowCount(m, wo, u);
    Array<T> wi = newRows<T>(count, 3);
    Array<T> density = newRows<T>(count, 0);
    T *toWi = wi.mutable_data();
    T *toPdf = density.mutable_data();
    const auto put = [=](std::size_t row, const Vector3<T> &w, T p) {
        for (int c = 0; c < 3; ++c) toWi[3 * row + static_cast<std::size_t>(c)] = w[c];
        toPdf[row] = p;
    };
    if constexpr (std::is_same_v<T, float>)
        if (bounded) {
            forBlocks(count, [&](Block &block, std::size_t begin, std::size_t rows) {
                for (std::size_t i = 0; i < rows; ++i) {
                    block.setTransform(m, begin + i, i);
                    Block::set(wo, begin + i, i, block.ox, block.oy, block.oz);
                    block.ux[i] = u.at(begin + i)[0];
                    block.uy[i] = u.at(begin + i)[1];
                }
                batch::sample(block.transforms(), block.wo(), block.ux, block.uy, rows, {block.ix, block.iy, block.iz}, block.pdf);
                for (std::size_t i = 0; i < rows; ++i) put(begin + i, {block.ix[i], block.iy[i], block.iz[i]}, block.pdf[i]);
            });
            return py::make_tuple(wi, density);
        }
    forRows(count, [&](std::size_t row) {
        const auto t = m.transformAt(row);
        const Vector3<T> o = wo.vectorAt(row);
        const Vector2<T> xy(u.at(row)[0], u.at(row)[1]);
        if (bounded) {
            const auto [w, p] = ggx::sampleReflection(t, o, xy);
            put(row, w, p);
        } else {
            const Vector3<T> wm = ggx::sampleVisibleNormal(t, o, xy);
            const Vector3<T> w = 2 * glm::dot(o, wm) * wm - o;
            put(row, w, reflectionPdf(t, o, w, false));
        }
    });
    return py::make_tuple(wi, density);
}

py::object sampleNormal(const py::array &transforms, const py::array &first, const py::array &numbers) {
    return byType(transforms, [&]<class T>() -> py::object {
        const TransformRows<T> m(transforms);
        const Rows<T> wo(first);
        const Rows<T> u(numbers);
        m.check();
        const std::size_t count = rowCount(m, wo, u);
        Array<T> out = newRows<T>(count, 3);
        T *to = out.mutable_data();
        forRows(count, [&](std::size_t row) {
            const Vector3<T> wm = ggx::sampleVisibleNormal(m.transformAt(row), wo.vectorAt(row), Vector2<T>(u.at(row)[0], u.at(row)[1]));
            for (int c = 0; c < 3; ++c) to[3 * row + static_cast<std::size_t>(c)] = wm[c];
        });
        return out;
    });
}

py::object albedo(const py::array &transforms, const py::array &directions) {
    return numberOfDirection(transforms, directions, [](const auto &t, const auto &w) {
        const MicroTransform m{float(t.a), float(t.b),        float(t.d),        float(t.p),
                               float(t.q), float(t.inverseA), float(t.inverseD), float(t.det)};
        return w.z > 0 ? energy::singleScatterAlbedo(m, Vec3(w)) : 0.0F;
    });
}

py::object averageAlbedo(const py::array &transforms) {
    const TransformRows<float> m(transforms);
    m.check();
    Array<float> out = newRows<float>(m.rows, 0);
    float *to = out.mutable_data();
    forRows(m.rows, [&](std::size_t row) { to[row] = energy::averageAlbedo(m.transformAt(row)); });
    return out;
}

/// The numbers of a row's walk: of its own, whatever thread it runs on.
walk::Random randomOf(std::uint32_t seed, std::size_t row) {
    return walk::Random((static_cast<std::uint64_t>(seed) << 32U) ^ static_cast<std::uint64_t>(row));
}

py::tuple walkFrom(const py::array &transforms, const py::array &directions, const py::array &colors, std::uint32_t seed) {
    const TransformRows<float> m(transforms);
    const Rows<float> wo(directions);
    const Rows<float> color(colors);
    m.check();
    const std::size_t count = rowCount(m, wo, color);
    Array<float> wi = newRows<float>(count, 3);
    Array<float> throughput = newRows<float>(count, 3);
    Array<std::int32_t> bounces = newRows<std::int32_t>(count, 0);
    float *toWi = wi.mutable_data();
    float *toThroughput = throughput.mutable_data();
    std::int32_t *toBounces = bounces.mutable_data();
    forRows(count, [&](std::size_t row) {
        walk::Random random = randomOf(seed, row);
        const Vec2 first(random.uniform(), random.uniform());
        const walk::UniformReflector mirror{color.vectorAt(row)};
        const walk::Exit exit = walk::sample(m.transformAt(row), wo.vectorAt(row), mirror, first, random);
        for (int c = 0; c < 3; ++c) {
            toWi[3 * row + static_cast<std::size_t>(c)] = exit.w[c];
            toThroughput[3 * row + static_cast<std::size_t>(c)] = exit.throughput[c];
        }
        toBounces[row] = exit.bounces;
    });
    return py::make_tuple(wi, throughput, bounces);
}

py::object evaluateWalk(const py::array &transforms, const py::array &first, const py::array &second, const py::array &colors,
                        std::uint32_t seed) {
    const TransformRows<float> m(transforms);
    const Rows<float> wo(first);
    const Rows<float> wi(second);
    const Rows<float> color(colors);
    m.check();
    const std::size_t count = rowCount(m, wo, wi, color);
    Array<float> out = newRows<float>(count, 3);
    float *to = out.mutable_data();
    forRows(count, [&](std::size_t row) {
        walk::Random random = randomOf(seed, row);
        const Vec2 u(random.uniform(), random.uniform());
        const walk::UniformReflector mirror{color.vectorAt(row)};
        const Vec3 w = wi.vectorAt(row);
        const Vec3 fCos = w.z > 0 ? walk::evaluate(m.transformAt(row), wo.vectorAt(row), w, mirror, u, random) : Vec3(0);
        for (int c = 0; c < 3; ++c) to[3 * row + static_cast<std::size_t>(c)] = fCos[c];
    });
    return out;
}

} // namespace

void addTransforms(py::module_ &part);

void addMicrosurface(py::module_ &module) {
    py::module_ part = module.def_submodule("microsurface");
    part.def("D", [](const py::array &m, const py::array &wm) {
        return numberOfDirection(m, wm, [](const auto &t, const auto &w) { return ggx::distribution(t, w); });
    });
    part.def("G1", [](const py::array &m, const py::array &w) {
        return numberOfDirection(m, w, [](const auto &t, const auto &v) { return ggx::masking(t, v); });
    });
    part.def("Lambda", [](const py::array &m, const py::array &w) {
        return numberOfDirection(m, w, [](const auto &t, const auto &v) { return ggx::lambda(t, v); });
    });
    part.def("G2", [](const py::array &m, const py::array &wo, const py::array &wi, bool correlated) {
        return numberOfDirections(m, wo, wi, [=](const auto &t, const auto &o, const auto &i) {
            return ggx::shadowing(ggx::lambda(t, o), ggx::lambda(t, i), (o.z > 0) == (i.z > 0), correlated);
        });
    });
    part.def("visible_normal_pdf", [](const py::array &m, const py::array &wo, const py::array &wm) {
        return numberOfDirections(m, wo, wm, [](const auto &t, const auto &o, const auto &h) { return ggx::visibleNormalPdf(t, o, h); });
    });
    part.def("evaluate", evaluate);
    part.def("pdf", pdf);
    part.def("weight", weight);
    part.def("sample", [](const py::array &m, const py::array &wo, const py::array &u, bool bounded) {
        return byType(m, [&]<class T>() { return sampleRows<T>(m, wo, u, bounded); });
    });
    part.def("sample_normal", sampleNormal);
    part.def("albedo", albedo);
    part.def("average_albedo", averageAlbedo);
    part.def("walk", walkFrom);
    part.def("evaluate_walk", evaluateWalk);
    addTransforms(part);
}

} // namespace taut::python

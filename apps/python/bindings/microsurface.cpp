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

    /// Rows from `begin` on, of M and the directions to the viewer.
    void load(const TransformRows<float> &from, const Rows<float> &viewers, std::size_t begin, std::size_t rows) {
        for (std::size_t i = 0; i < rows; ++i) {
            const MicroTransform t = from.transformAt(begin + i);
            a[i] = t.a;
            b[i] = t.b;
            d[i] = t.d;
            p[i] = t.p;
            q[i] = t.q;
            set(viewers, begin + i, i, ox, oy, oz);
        }
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

/// What wo sees, and the part of it that samples are of: all of it, or the cap that is bounded to what reflects upwards.
template <class T> struct SampledArea {
    T visible, sampled;
    SampledArea(const BasicMicroTransform<T> &m, const Vector3<T> &wo, bool bounded) {
        const T length = ggx::stretchedLength(m, wo);
        visible = ggx::visibleArea(m, wo, length);
        sampled = ggx::capArea(bounded ? ggx::capBound(m, wo) : T(1), wo.z, length, visible);
    }
};

template <class T> T reflectionPdf(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector3<T> &wi, bool bounded) {
    return wi.z > 0 ? ggx::distribution(m, wo, wi) / (2 * SampledArea<T>(m, wo, bounded).sampled) : T(0);
}
template <class T>
T reflectionWeight(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector3<T> &wi, bool correlated, bool bounded) {
    if (!(wi.z > 0)) return 0;
    const SampledArea<T> area(m, wo, bounded);
    return ggx::reflectionWeight(m, wo, wi, correlated) * (area.sampled / area.visible);
}
template <class T> T reflectionFCos(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector3<T> &wi, bool correlated) {
    return wi.z > 0 ? reflectionPdf(m, wo, wi, false) * ggx::reflectionWeight(m, wo, wi, correlated) : T(0);
}

/// f(M, directions...) a row, in the type of M.
template <class F, class... D> py::object byDirections(const F &f, const py::array &transforms, const D &...directions) {
    return byType(transforms, [&]<class T>() {
        const TransformRows<T> m(transforms);
        return std::apply(
            [&](const auto &...w) {
                return tableOf(rowCount(m, w...), [&](std::size_t row) { return f(m.transformAt(row), w.vectorAt(row)...); });
            },
            std::tuple(Rows<T>(directions)...));
    });
}
/// f(M, wo, u) a row.
template <class T, class F>
py::object bySamples(const F &f, const py::array &transforms, const py::array &viewers, const py::array &numbers) {
    const TransformRows<T> m(transforms);
    const Rows<T> wo(viewers);
    const Rows<T> u(numbers);
    return tableOf(rowCount(m, wo, u), [&](std::size_t row) { return f(m.transformAt(row), wo.vectorAt(row), u.pairAt(row)); });
}

/// One number a row by a vectorised loop `run(block, rows)` that leaves it in block.value.
template <class Run>
py::object batchedNumber(const py::array &transforms, const py::array &viewers, const py::array &lights, const Run &run) {
    const TransformRows<float> m(transforms);
    const Rows<float> wo(viewers);
    const Rows<float> wi(lights);
    const std::size_t count = rowCount(m, wo, wi);
    Array<float> out = newRows<float>(count, 0);
    float *to = out.mutable_data();
    forBlocks(count, [&](Block &block, std::size_t begin, std::size_t rows) {
        block.load(m, wo, begin, rows);
        for (std::size_t i = 0; i < rows; ++i) Block::set(wi, begin + i, i, block.ix, block.iy, block.iz);
        run(block, rows);
        std::copy(block.value, block.value + rows, to + begin);
    });
    return out;
}

py::object evaluate(const py::array &m, const py::array &wo, const py::array &wi, bool correlated) {
    if (isDouble(m)) return byDirections([&](auto t, auto o, auto i) { return reflectionFCos(t, o, i, correlated); }, m, wo, wi);
    return batchedNumber(
        m, wo, wi, [&](Block &b, std::size_t rows) { batch::evaluate(b.transforms(), b.wo(), b.wi(), rows, correlated, b.value, b.pdf); });
}

py::object pdf(const py::array &m, const py::array &wo, const py::array &wi, bool bounded) {
    if (isDouble(m) || bounded) return byDirections([&](auto t, auto o, auto i) { return reflectionPdf(t, o, i, bounded); }, m, wo, wi);
    return batchedNumber(m, wo, wi,
                         [&](Block &b, std::size_t rows) { batch::evaluate(b.transforms(), b.wo(), b.wi(), rows, true, b.pdf, b.value); });
}

py::object weight(const py::array &m, const py::array &wo, const py::array &wi, bool correlated, bool bounded) {
    if (isDouble(m) || bounded)
        return byDirections([&](auto t, auto o, auto i) { return reflectionWeight(t, o, i, correlated, bounded); }, m, wo, wi);
    return batchedNumber(m, wo, wi,
                         [&](Block &b, std::size_t rows) { batch::weight(b.transforms(), b.wo(), b.wi(), rows, correlated, b.value); });
}

py::object sampleBatched(const py::array &transforms, const py::array &viewers, const py::array &numbers) {
    const TransformRows<float> m(transforms);
    const Rows<float> wo(viewers);
    const Rows<float> u(numbers);
    const std::size_t count = rowCount(m, wo, u);
    const Table<Vec3, float> table(count);
    forBlocks(count, [&](Block &block, std::size_t begin, std::size_t rows) {
        block.load(m, wo, begin, rows);
        for (std::size_t i = 0; i < rows; ++i) {
            block.ux[i] = u.at(begin + i)[0];
            block.uy[i] = u.at(begin + i)[1];
        }
        batch::sample(block.transforms(), block.wo(), block.ux, block.uy, rows, {block.ix, block.iy, block.iz}, block.pdf);
        for (std::size_t i = 0; i < rows; ++i) table.put(begin + i, {block.ix[i], block.iy[i], block.iz[i]}, block.pdf[i]);
    });
    return table.result();
}

py::object sample(const py::array &m, const py::array &wo, const py::array &u, bool bounded) {
    if (bounded && !isDouble(m)) return sampleBatched(m, wo, u);
    return byType(m, [&]<class T>() {
        const auto reflected = [&](const BasicMicroTransform<T> &t, const Vector3<T> &o, const Vector2<T> &xy) {
            if (bounded) {
                const auto [w, density] = ggx::sampleReflection(t, o, xy);
                return std::tuple(w, density);
            }
            const Vector3<T> wm = ggx::sampleVisibleNormal(t, o, xy);
            const Vector3<T> w = 2 * glm::dot(o, wm) * wm - o;
            return std::tuple(w, reflectionPdf(t, o, w, false));
        };
        return bySamples<T>(reflected, m, wo, u);
    });
}

py::object sampleNormal(const py::array &m, const py::array &wo, const py::array &u) {
    return byType(m, [&]<class T>() {
        return bySamples<T>([](const auto &t, const auto &o, const auto &xy) { return ggx::sampleVisibleNormal(t, o, xy); }, m, wo, u);
    });
}

py::object albedo(const py::array &transforms, const py::array &directions) {
    const auto ofDirection = []<class T>(const BasicMicroTransform<T> &t, const Vector3<T> &w) -> T {
        const MicroTransform m{float(t.a), float(t.b),        float(t.d),        float(t.p),
                               float(t.q), float(t.inverseA), float(t.inverseD), float(t.det)};
        return w.z > 0 ? T(energy::singleScatterAlbedo(m, Vec3(w))) : T(0);
    };
    return byDirections(ofDirection, transforms, directions);
}

py::object averageAlbedo(const py::array &transforms) {
    const TransformRows<float> m(transforms);
    return tableOf(m.rows, [&](std::size_t row) { return energy::averageAlbedo(m.transformAt(row)); });
}

/// A row's own random numbers, whatever thread it runs on.
walk::Random randomOfRow(std::uint32_t seed, std::size_t row) {
    return walk::Random((static_cast<std::uint64_t>(seed) << 32U) ^ static_cast<std::uint64_t>(row));
}

py::object walkFrom(const py::array &transforms, const py::array &viewers, const py::array &colors, std::uint32_t seed) {
    const TransformRows<float> m(transforms);
    const Rows<float> wo(viewers);
    const Rows<float> color(colors);
    return tableOf(rowCount(m, wo, color), [&](std::size_t row) {
        walk::Random random = randomOfRow(seed, row);
        const float x = random.uniform();
        const Vec2 first(x, random.uniform());
        const walk::UniformReflector mirror{color.vectorAt(row)};
        const walk::Exit exit = walk::sample(m.transformAt(row), wo.vectorAt(row), mirror, first, random);
        return std::tuple(exit.w, exit.throughput, static_cast<std::int32_t>(exit.bounces));
    });
}

py::object evaluateWalk(const py::array &transforms, const py::array &viewers, const py::array &lights, const py::array &colors,
                        std::uint32_t seed) {
    const TransformRows<float> m(transforms);
    const Rows<float> wo(viewers);
    const Rows<float> wi(lights);
    const Rows<float> color(colors);
    return tableOf(rowCount(m, wo, wi, color), [&](std::size_t row) {
        walk::Random random = randomOfRow(seed, row);
        const walk::Ends ends = walk::drawEnds(random);
        const walk::UniformReflector mirror{color.vectorAt(row)};
        const Vec3 w = wi.vectorAt(row);
        return w.z > 0 ? walk::evaluate(m.transformAt(row), wo.vectorAt(row), w, mirror, ends, random) : Vec3(0);
    });
}

} // namespace

void addTransforms(py::module_ &part);

void addMicrosurface(py::module_ &module) {
    py::module_ part = module.def_submodule("microsurface");
    part.def("D", [](const py::array &m, const py::array &wm) {
        return byDirections([](const auto &t, const auto &h) { return ggx::distribution(t, h); }, m, wm);
    });
    part.def("G1", [](const py::array &m, const py::array &w) {
        return byDirections([](const auto &t, const auto &v) { return ggx::masking(t, v); }, m, w);
    });
    part.def("Lambda", [](const py::array &m, const py::array &w) {
        return byDirections([](const auto &t, const auto &v) { return ggx::lambda(t, v); }, m, w);
    });
    part.def("G2", [](const py::array &m, const py::array &wo, const py::array &wi, bool correlated) {
        const auto joined = [=](const auto &t, const auto &o, const auto &i) {
            return ggx::shadowing(ggx::lambda(t, o), ggx::lambda(t, i), (o.z > 0) == (i.z > 0), correlated);
        };
        return byDirections(joined, m, wo, wi);
    });
    part.def("visible_normal_pdf", [](const py::array &m, const py::array &wo, const py::array &wm) {
        return byDirections([](const auto &t, const auto &o, const auto &h) { return ggx::visibleNormalPdf(t, o, h); }, m, wo, wm);
    });
    part.def("evaluate", evaluate);
    part.def("pdf", pdf);
    part.def("weight", weight);
    part.def("sample", sample);
    part.def("sample_normal", sampleNormal);
    part.def("albedo", albedo);
    part.def("average_albedo", averageAlbedo);
    part.def("walk", walkFrom);
    part.def("evaluate_walk", evaluateWalk);
    addTransforms(part);
}

} // namespace taut::python

/// What deforming meshes occupy while they are rendered, beside the least that they could.

#include "catch.h"
#include "render_fixtures.h"

#include "taut/render/memory_use.h"

#include <malloc.h>

using namespace taut;
using namespace taut::test;

namespace {

/// Bytes that malloc has given out; 0 where a sanitizer has a malloc of its own.
double heapBytes() {
#ifdef __SANITIZE_ADDRESS__
    return 0;
#else
    const struct mallinfo2 info = mallinfo2();
    return static_cast<double>(info.uordblks + info.hblkhd);
#endif
}

struct Measured {
    MemoryUse use;
    double heap = 0; ///< bytes that malloc has given out for all of it
    bool refits = false;
    [[nodiscard]] double ratio() const { return static_cast<double>(use.rendering()) / static_cast<double>(use.least()); }
};

/// Three frames of a torus under shear; with so many samples that fresh BVHs pay, or so few that those do that can be refitted.
Measured measureTorus(int around, int across, int level, bool refits) {
    Measured measured;
    const double before = heapBytes();
    Object torus = shearedTorus(around, across);
    torus.subdivision.level = level;
    Scene scene = smallScene(std::move(torus), ggxMaterial(0.08F, 0.4F), 512);
    scene.render.spp = refits ? 1 : 256;
    scene.render.frames = {1, 2, 3};
    RenderScene ready(scene, true);
    StageTimes times;
    for (const int frame : scene.render.frames) ready.setFrame(frame, times);
    measured.heap = heapBytes() - before;
    measured.use = memoryUse(ready);
    measured.refits = ready.refits();
    return measured;
}

/// All is counted that malloc has given out, but for small things. Embree may have pages of its own for its trees.
void checkAgainstMalloc(const Measured &m) {
    if (m.heap == 0) {
        WARN("malloc does not tell what it has given out: not compared");
        return;
    }
    const auto counted = static_cast<double>(m.use.total());
    CHECK(m.heap < 1.01 * counted);
    CHECK(m.heap > 0.99 * (counted - static_cast<double>(m.use.embree)));
}

std::string describe(const Measured &m) {
    std::string text = "bytes a triangle:";
    const auto add = [&](const char *name, double bytes) {
        text += std::string(" ") + name + " " + std::to_string(bytes / static_cast<double>(m.use.triangles));
    };
    add("Embree", static_cast<double>(m.use.embree));
    add("shown", static_cast<double>(m.use.shown));
    add("motion", static_cast<double>(m.use.motion));
    add("policy", static_cast<double>(m.use.policy));
    add("source", static_cast<double>(m.use.source));
    add("least", static_cast<double>(m.use.least()));
    add("malloc", m.heap);
    return text + "; ratio " + std::to_string(m.ratio());
}

} // namespace

// With a BVH of triangles it was 1.46 times, of 203 bytes a triangle; pairs leave 183 of them, and the BVH is in the least as well.
TEST_CASE("A deforming mesh takes at most 1.6 times the memory of BVH, positions, normals, UVs, ds and dt", "[memory][render]") {
    for (const bool refits : {false, true}) {
        const Measured m = measureTorus(632, 158, 0, refits);
        INFO(describe(m));
        REQUIRE(m.refits == refits);
        REQUIRE(m.use.triangles == 199'712);
        CHECK(m.ratio() <= 1.6);
        checkAgainstMalloc(m);
    }
}

TEST_CASE("A subdivided mesh that deforms holds its rows of weights once", "[memory][render]") {
    const Measured m = measureTorus(80, 40, 2, false);
    INFO(describe(m));
    // Rows of 16 points and more at each of the vertices, half as many as triangles: 8 bytes of index and weight each for positions, 8
    // more for the gradient.
    CHECK(m.ratio() <= 2.9);
    checkAgainstMalloc(m);
}

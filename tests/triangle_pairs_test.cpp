/// Triangles as Embree's quads: every one once, and hits told as a brute-force search in double tells them.

#include "catch.h"
#include "render_fixtures.h"

#include "taut/render/embree_scene.h"
#include "taut/render/triangle_pairs.h"

#include <algorithm>
#include <random>
#include <set>

using namespace taut;
using namespace taut::test;

namespace {

struct Soup {
    std::vector<Vec3> positions; ///< one more than is indexed, as Embree wants it
    std::vector<Index3> triangles;
};

/// A bumpy sheet of 2 n n triangles. `diagonals`: every quad is cut along one of its two at random. `shuffled`: triangles in any order,
/// each beginning at any of its corners.
Soup sheet(int n, bool diagonals, bool shuffled, std::mt19937 &random) {
    Soup soup;
    std::uniform_real_distribution<float> jitter(-0.3F, 0.3F);
    const auto side = static_cast<Index>(n + 1);
    for (Index y = 0; y < side; ++y)
        for (Index x = 0; x < side; ++x)
            soup.positions.emplace_back(static_cast<float>(x) + jitter(random), static_cast<float>(y) + jitter(random), jitter(random));
    for (Index y = 0; y + 1 < side; ++y)
        for (Index x = 0; x + 1 < side; ++x) {
            const Index a = y * side + x;
            const Index b = a + 1;
            const Index c = b + side;
            const Index d = a + side;
            if (diagonals && random() % 2 == 0)
                soup.triangles.insert(soup.triangles.end(), {Index3(a, b, d), Index3(b, c, d)});
            else
                soup.triangles.insert(soup.triangles.end(), {Index3(a, b, c), Index3(a, c, d)});
        }
    soup.positions.emplace_back(0);
    if (!shuffled) return soup;
    std::shuffle(soup.triangles.begin(), soup.triangles.end(), random);
    for (Index3 &t : soup.triangles)
        for (auto turns = random() % 3; turns > 0; --turns) t = Index3(t.y, t.z, t.x);
    return soup;
}

/// The corners of a quad that are the triangle's, and where `hit` finds each corner of the triangle again.
struct Told {
    Index triangle;
    double u, v;
};

/// What Embree's u and v of a quad become.
Told toldOf(const TrianglePairs &pairs, Index quad, float u, float v) {
    Hit hit;
    hit.u = u;
    hit.v = v;
    hit.primitive = quad;
    pairs.toTriangle(hit);
    return {hit.primitive, hit.u, hit.v};
}

DVec3 pointOf(const Soup &soup, Index triangle, double u, double v) {
    const Index3 &t = soup.triangles[triangle];
    return (1 - u - v) * DVec3(soup.positions[t.x]) + u * DVec3(soup.positions[t.y]) + v * DVec3(soup.positions[t.z]);
}

/// The nearest triangle that a ray meets, in double (Moeller and Trumbore 1997), and how near its edges, in barycentrics.
struct Nearest {
    double t = kInfinity, u = 0, v = 0, margin = 0;
    Index triangle = kNone;
};
Nearest nearestOf(const Soup &soup, const Ray &ray) {
    Nearest best;
    const DVec3 direction(ray.direction);
    for (Index i = 0; i < soup.triangles.size(); ++i) {
        const Index3 &t = soup.triangles[i];
        const DVec3 a(soup.positions[t.x]);
        const DVec3 e1 = DVec3(soup.positions[t.y]) - a;
        const DVec3 e2 = DVec3(soup.positions[t.z]) - a;
        const DVec3 p = glm::cross(direction, e2);
        const double determinant = glm::dot(e1, p);
        if (determinant == 0) continue;
        const DVec3 s = DVec3(ray.origin) - a;
        const DVec3 q = glm::cross(s, e1);
        const double u = glm::dot(s, p) / determinant;
        const double v = glm::dot(direction, q) / determinant;
        const double distance = glm::dot(e2, q) / determinant;
        const double margin = std::min({u, v, 1 - u - v});
        if (margin < 0 || distance < ray.nearest || distance >= best.t) continue;
        best = {distance, u, v, margin, i};
    }
    return best;
}

std::vector<Ray> raysAcross(const Soup &soup, std::size_t count, std::mt19937 &random) {
    std::uniform_real_distribution<float> unit(0, 1);
    Vec3 upper(0);
    for (const Vec3 &p : soup.positions) upper = glm::max(upper, p);
    std::vector<Ray> rays(count);
    for (Ray &ray : rays) {
        ray.origin = Vec3(upper.x * unit(random), upper.y * unit(random), 3);
        ray.direction = glm::normalize(Vec3(unit(random) - 0.5F, unit(random) - 0.5F, -1));
    }
    return rays;
}

/// The scene's hits are those of the search, to float's rounding; hits within it of an edge may be its neighbour's.
void checkHits(const EmbreeScene &scene, const Soup &soup, const std::vector<Ray> &rays) {
    for (const bool coherent : {true, false}) {
        std::vector<Hit> hits(rays.size());
        scene.intersect(rays, coherent, hits);
        std::size_t compared = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Nearest truth = nearestOf(soup, rays[i]);
            if (truth.triangle == kNone) {
                CHECK(hits[i].geometry == kNone);
                continue;
            }
            if (truth.margin < 1e-4) continue;
            ++compared;
            REQUIRE(hits[i].primitive == truth.triangle);
            CHECK(std::abs(hits[i].t - truth.t) < 1e-5 * truth.t);
            CHECK(std::abs(hits[i].u - truth.u) < 2e-5);
            CHECK(std::abs(hits[i].v - truth.v) < 2e-5);
        }
        CHECK(compared > rays.size() / 2);
    }
}

} // namespace

TEST_CASE("Triangle pairs: each triangle once, in its own corners", "[triangle-pairs]") {
    std::mt19937 random(3);
    Soup soup = sheet(20, true, true, random);
    // What no pair is made of: an index twice, and neighbours that wind against each other. A third triangle on one edge.
    soup.triangles.insert(soup.triangles.end(), {Index3(0, 0, 5), Index3(3, 4, 3), Index3(0, 1, 50), Index3(0, 1, 60), Index3(1, 0, 70)});
    const TrianglePairs pairs(soup.triangles);
    std::vector<QuadCorners> quads(pairs.size());
    pairs.corners(soup.triangles, quads);
    std::multiset<Index> seen;
    for (Index q = 0; q < quads.size(); ++q) {
        const auto [a, b, c, d] = quads[q];
        const auto at = [&](Index corner) { return DVec3(soup.positions[corner]); };
        // Embree's triangles are (a, b, d) with (u, v), and (c, d, b) with (1 - u, 1 - v).
        const Told first = toldOf(pairs, q, 0.25F, 0.5F);
        seen.insert(first.triangle);
        CHECK(glm::length(pointOf(soup, first.triangle, first.u, first.v) - (0.25 * at(a) + 0.25 * at(b) + 0.5 * at(d))) < 1e-6);
        if (c == d) continue;
        const Told second = toldOf(pairs, q, 0.75F, 0.875F);
        seen.insert(second.triangle);
        CHECK(glm::length(pointOf(soup, second.triangle, second.u, second.v) - (0.625 * at(c) + 0.25 * at(d) + 0.125 * at(b))) < 1e-6);
    }
    CHECK(seen.size() == soup.triangles.size());
    for (Index t = 0; t < soup.triangles.size(); ++t) CHECK(seen.count(t) == 1);
}

TEST_CASE("Triangle pairs: front and back of one triangle", "[triangle-pairs]") {
    const Soup sheet{{Vec3(0), Vec3(1, 0, 0), Vec3(0, 1, 0.5F), Vec3(0)}, {Index3(0, 1, 2)}};
    for (int turn = 0; turn < 3; ++turn) {
        Soup both = sheet;
        Index3 back(2, 1, 0);
        for (int k = 0; k < turn; ++k) back = Index3(back.y, back.z, back.x);
        both.triangles.push_back(back);
        const TrianglePairs pairs(both.triangles);
        REQUIRE(pairs.size() == 1);
        std::vector<QuadCorners> quads(1);
        pairs.corners(both.triangles, quads);
        const auto [a, b, c, d] = quads[0];
        CHECK(a != b);
        CHECK(c != d);
        CHECK(c != b); // neither half is flat
        CHECK(toldOf(pairs, 0, 0.25F, 0.25F).triangle == 0);
        const Told second = toldOf(pairs, 0, 0.75F, 0.875F);
        CHECK(second.triangle == 1);
        const auto at = [&](Index corner) { return DVec3(both.positions[corner]); };
        CHECK(glm::length(pointOf(both, 1, second.u, second.v) - (0.625 * at(c) + 0.25 * at(d) + 0.125 * at(b))) < 1e-6);
    }
}

TEST_CASE("Triangle pairs: a hub of many open edges", "[triangle-pairs]") {
    std::vector<Index3> book; // pages at one spine
    for (Index page = 2; page < 200'000; ++page) book.emplace_back(0, 1, page);
    CHECK(TrianglePairs(book).size() == book.size());
}

TEST_CASE("Triangle pairs: few stay alone", "[triangle-pairs]") {
    std::mt19937 random(5);
    CHECK(TrianglePairs(sheet(60, false, false, random).triangles).size() == 60 * 60);
    CHECK(TrianglePairs(sheet(60, true, false, random).triangles).size() == 60 * 60);
    const std::size_t shuffled = TrianglePairs(sheet(60, true, true, random).triangles).size();
    INFO(shuffled << " quads of " << 2 * 60 * 60 << " triangles");
    CHECK(shuffled < 60 * 60 * 1.03);
    CHECK(TrianglePairs(std::vector<Index3>{}).size() == 0);
}

TEST_CASE("Triangle pairs: vertices at one place are one", "[triangle-pairs]") {
    std::mt19937 random(6);
    const Soup soup = sheet(12, true, true, random);
    Soup split; // each triangle with vertices of its own
    std::vector<Index> places;
    for (const Index3 &t : soup.triangles) {
        const auto first = static_cast<Index>(places.size());
        split.triangles.emplace_back(first, first + 1, first + 2);
        for (const Index v : {t.x, t.y, t.z}) {
            places.push_back(v);
            split.positions.push_back(soup.positions[v]);
        }
    }
    split.positions.emplace_back(0);
    CHECK(TrianglePairs(split.triangles).size() == split.triangles.size());
    CHECK(TrianglePairs(split.triangles, places).size() == TrianglePairs(soup.triangles).size());
    EmbreeScene scene(false);
    scene.addTriangles({split.positions}, {split.triangles, places});
    scene.commit();
    checkHits(scene, split, raysAcross(split, 600, random));
}

TEST_CASE("Triangle pairs: rays meet what a search in double finds", "[triangle-pairs]") {
    std::mt19937 random(7);
    for (const bool shuffled : {false, true}) {
        const Soup soup = sheet(12, true, shuffled, random);
        const std::vector<Ray> rays = raysAcross(soup, 600, random);
        const Affine here(1);
        for (const bool refits : {false, true}) {
            EmbreeScene scene(refits);
            Soup moving = soup;
            const Index geometry = scene.addTriangles({moving.positions}, {moving.triangles});
            scene.commit();
            checkHits(scene, moving, rays);
            for (Vec3 &p : moving.positions) p.z += 0.2F * std::sin(p.x);
            scene.update(geometry, false);
            scene.commit();
            checkHits(scene, moving, rays);
        }
        EmbreeScene instanced(false);
        instanced.addInstance(soup.positions, {soup.triangles}, {&here, 1});
        instanced.commit();
        checkHits(instanced, soup, rays);
        EmbreeScene blurred(false);
        blurred.addTriangles({soup.positions, soup.positions, soup.positions}, {soup.triangles});
        blurred.commit();
        checkHits(blurred, soup, rays);
    }
}

namespace {

/// Half of the triangles are not there.
class EverySecond : public SurfaceTest {
  public:
    [[nodiscard]] bool isThere(std::size_t, const Hit &hit) const override { return hit.primitive % 2 == 0; }
};

} // namespace

TEST_CASE("Triangle pairs: one of two may be absent", "[triangle-pairs]") {
    std::mt19937 random(9);
    const Soup soup = sheet(12, true, false, random);
    Soup there = soup;
    for (Index t = 1; t < there.triangles.size(); t += 2) there.triangles[t] = Index3(0);
    const std::vector<Ray> rays = raysAcross(soup, 600, random);
    EmbreeScene scene(false);
    scene.ask(scene.addTriangles({soup.positions}, {soup.triangles}), true);
    scene.commit();
    const EverySecond test;
    std::vector<Hit> hits(rays.size());
    std::vector<unsigned char> blocked(rays.size());
    scene.intersect(rays, false, hits, &test);
    scene.occluded(rays, blocked, &test);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Nearest truth = nearestOf(there, rays[i]);
        const Nearest any = nearestOf(soup, rays[i]);
        if (any.margin < 1e-4 || (truth.triangle != kNone && truth.margin < 1e-4)) continue;
        REQUIRE((hits[i].geometry != kNone) == (truth.triangle != kNone));
        if (truth.triangle != kNone) CHECK(hits[i].primitive == truth.triangle);
        CHECK((blocked[i] != 0) == (truth.triangle != kNone));
    }
}

TEST_CASE("Triangle pairs: a frame is the same alone, refitted and rebuilt", "[triangle-pairs][determinism]") {
    const Scene scene = smallScene(shearedTorus(40, 20), ggxMaterial(0.1F, 0.4F), 64);
    const auto picture = [&](bool animated, BvhKind bvh) {
        ScenePlan plan = defaultPlan(scene);
        plan.bvh = bvh;
        RenderScene ready(scene, std::move(plan), animated);
        if (animated) ready.setFrame(1);
        ready.setFrame(3);
        FrameOptions options;
        options.spp = 8;
        return renderFrame(ready, options).film.resolve();
    };
    const std::vector<float> alone = picture(false, BvhKind::Rebuild);
    CHECK(picture(true, BvhKind::Rebuild) == alone);
    CHECK(picture(true, BvhKind::Refit) == alone);
}

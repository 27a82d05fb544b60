/// Mapped facets, coats and what emits, shaded at once: the picture of hits one by one, to the bit.

#include "catch.h"
#include "lanes_fixtures.h"

#include "study/scenes/relief.h"

#include <tbb/global_control.h>

#include <algorithm>

using namespace taut;
using namespace taut::test;

namespace {

enum Map : Index { kShares, kTurns, kNormals, kSlopes };

/// A scene with shares and turns, a relief's normals finer than pixels, and slopes of heights.
Scene mappedScene(const Material &material) {
    Scene s = textured(material);
    s.textures.push_back(chart::reliefNormals({3, 0.6F}, 256));
    s.textures.push_back(chequered(-0.6F, 0.6F));
    for (Object &object : s.objects) object.mapTangents = true;
    return s;
}

template <class Change> void add(std::vector<LaneCase> &cases, const std::string &name, const Material &material, const Change &change) {
    Scene s = mappedScene(material);
    change(s, s.materials[0]);
    cases.push_back({name, std::move(s)});
}

Material paint() {
    Material m = plain(BsdfType::MetallicRoughness, 0.4F, 0.4F, 0);
    m.alphaIsRoughness = true;
    m.multiscatter = Multiscatter::Auto;
    return m;
}

} // namespace

TEST_CASE("Mapped facets at once give the picture of one by one", "[render][lanes][mapped_render]") {
    std::vector<LaneCase> cases;
    const auto mapped = [](Scene &, Material &m) { m.slopes = {SlopeMap::Kind::Normal, kNormals, 1}; };
    add(cases, "diffuse", plain(BsdfType::Diffuse, 1, 1, 0), mapped);
    add(cases, "Schlick, brushed and turned", plain(BsdfType::Conductor, 0.08F, 0.4F, 0.5F), mapped);
    add(cases, "separable glass", plain(BsdfType::Dielectric, 0.1F, 0.3F, 0.3F), [&](Scene &s, Material &m) {
        mapped(s, m);
        m.masking = Masking::Separable;
    });
    add(cases, "rough glass", plain(BsdfType::Dielectric, 0.3F, 0.3F, 0), mapped);
    add(cases, "coated", plain(BsdfType::Coated, 0.1F, 0.3F, 0.2F), mapped);
    add(cases, "paint, textured", paint(), [&](Scene &s, Material &m) {
        mapped(s, m);
        m.color.texture = m.alphaX.texture = m.alphaY.texture = kShares;
    });
    add(cases, "steep facets, many of which turn from the viewer", plain(BsdfType::Metal, 0.2F, 0.2F, 0), [](Scene &, Material &m) {
        m.slopes = {SlopeMap::Kind::Normal, kNormals, 4};
    });
    add(cases, "steep facets of white paint", paint(), [](Scene &, Material &m) {
        m.color.value = Vec3(1);
        m.slopes = {SlopeMap::Kind::Normal, kNormals, -6};
    });
    add(cases, "facets that bend", plain(BsdfType::Conductor, 0.2F, 0.3F, 0), [&](Scene &s, Material &m) {
        mapped(s, m);
        m.facets = FacetModel::Bends;
    });
    add(cases, "Poisson's ratio", plain(BsdfType::Metal, 0.1F, 0.3F, 0.3F), [&](Scene &s, Material &m) {
        mapped(s, m);
        m.poisson = 0.4F;
    });
    add(cases, "bumps", plain(BsdfType::Conductor, 0.2F, 0.3F, 0.3F), [](Scene &, Material &m) {
        m.slopes = {SlopeMap::Kind::Bump, kSlopes, 0.7F};
    });
    add(cases, "heights", paint(), [](Scene &, Material &m) { m.slopes = {SlopeMap::Kind::Height, kSlopes, 0.5F}; });
    add(cases, "seen from afar", plain(BsdfType::Conductor, 0.1F, 0.2F, 0.3F), [&](Scene &s, Material &m) {
        mapped(s, m);
        m.detail = TextureDetail::Moments;
        m.rotation.texture = kTurns;
    });
    add(cases, "seen from afar, textured paint", paint(), [&](Scene &s, Material &m) {
        mapped(s, m);
        m.detail = TextureDetail::Moments;
        m.color.texture = m.metallic.texture = kShares;
        m.metallic = {1, kShares, 2};
    });
    add(cases, "a mirrored UV map", plain(BsdfType::Conductor, 0.08F, 0.4F, 0.5F), [&](Scene &s, Material &m) {
        mapped(s, m);
        Mesh mesh = *s.objects[0].mesh;
        for (Vec2 &uv : mesh.uvs) uv.x = 1 - uv.x;
        s.objects[0].mesh = std::make_shared<const Mesh>(std::move(mesh));
    });
    add(cases, "a mirrored placement", plain(BsdfType::Conductor, 0.08F, 0.4F, 0.5F), [&](Scene &s, Material &m) {
        mapped(s, m);
        s.objects[0].placement.scale = Keyed<DVec3>(DVec3(-1, 1, 1));
    });
    add(cases, "an instance that moves", plain(BsdfType::Conductor, 0.08F, 0.4F, 0.5F), [&](Scene &s, Material &m) {
        mapped(s, m);
        s.objects[0].deformers.clear();
        s.objects[0].placement.rotation.keys = {{1, DVec3(0)}, {3, DVec3(0.2, 0.1, 0.5)}};
    });
    add(cases, "beside a mesh with a stored M", plain(BsdfType::Conductor, 0.08F, 0.4F, 0.5F), [&](Scene &s, Material &m) {
        mapped(s, m);
        storeGloss(s);
    });
    add(cases, "rough metal, of which some lanes walk", plain(BsdfType::Metal, 0.8F, 0.8F, 0), [&](Scene &s, Material &m) {
        mapped(s, m);
        m.multiscatter = Multiscatter::Auto;
        m.alphaX.texture = m.alphaY.texture = kShares;
    });
    add(cases, "metal here, paint there, compensated or walked", paint(), [&](Scene &s, Material &m) {
        mapped(s, m);
        m.metallic = {1, kShares, 2};
        m.alphaX.value = m.alphaY.value = 0.9F;
    });
    add(cases, "compensated, however it leans", plain(BsdfType::Conductor, 0.7F, 0.7F, 0), [](Scene &, Material &m) {
        m.slopes = {SlopeMap::Kind::Normal, kNormals, 3};
        m.multiscatter = Multiscatter::Compensation;
    });
    checkPictures(cases);
}

TEST_CASE("Walks from what was gathered give the picture of one by one", "[render][lanes]") {
    std::vector<LaneCase> cases;
    for (const auto treatment : {Multiscatter::Walk, Multiscatter::Auto})
        for (const BsdfType type : {BsdfType::Conductor, BsdfType::Metal, BsdfType::Dielectric, BsdfType::MetallicRoughness})
            for (const bool mapped : {false, true})
                add(cases, "kind " + std::to_string(static_cast<int>(type)) + (mapped ? ", mapped" : ""), plain(type, 0.9F, 0.6F, 0.3F),
                    [&](Scene &, Material &m) {
                        m.multiscatter = treatment;
                        m.alphaX.texture = m.alphaY.texture = kShares;
                        m.metallic = {1, kShares, 1};
                        if (mapped) m.slopes = {SlopeMap::Kind::Normal, kNormals, 1};
                        m.clearcoat.value = mapped ? 0.5F : 0.0F;
                    });
    checkPictures(cases);
}

TEST_CASE("What no loop knows scatters from what was gathered, as one by one", "[render][lanes]") {
    std::vector<LaneCase> cases;
    using Change = void (*)(Material &);
    const std::pair<const char *, Change> kinds[] = {{"fibres",
                                                      [](Material &m) {
                                                          m.sheenColor = {Vec3(0.8F, 0.3F, 0.4F), kShares};
                                                      }},
                                                     {"a film",
                                                      [](Material &m) {
                                                          m.iridescence = {1, kShares, 0};
                                                      }},
                                                     {"passes straight on",
                                                      [](Material &m) {
                                                          m.transmission = {0.8F, kShares, 1};
                                                      }},
                                                     {"a volume", [](Material &m) {
                                                          m.transmission.value = 1;
                                                          m.thinWalled = false;
                                                          m.attenuationColor = Vec3(0.9F, 0.5F, 0.2F);
                                                          m.attenuationDistance = 0.3F;
                                                      }}};
    for (const auto &[name, change] : kinds)
        for (const bool mapped : {false, true})
            add(cases, std::string(name) + (mapped ? ", mapped and coated" : ""), paint(), [&](Scene &, Material &m) {
                change(m);
                m.metallic = {0.5F, kShares, 2};
                if (mapped) m.slopes = {SlopeMap::Kind::Normal, kNormals, 1};
                m.clearcoat.value = mapped ? 0.5F : 0.0F;
            });
    add(cases, "thin glass", plain(BsdfType::ThinGlass, 0.2F, 0.3F, 0.1F), [](Scene &, Material &) {});
    add(cases, "thin glass, mapped", plain(BsdfType::ThinGlass, 0.2F, 0.3F, 0.1F), [](Scene &, Material &m) {
        m.slopes = {SlopeMap::Kind::Normal, kNormals, 1};
    });
    checkPictures(cases);
}

TEST_CASE("Coats and numbers of KHR_materials_specular at once give the picture of one by one", "[render][lanes]") {
    std::vector<LaneCase> cases;
    const auto coated = [](float share, float roughness) {
        Material m = paint();
        m.clearcoat.value = share;
        m.clearcoatRoughness.value = roughness;
        return m;
    };
    const auto asItIs = [](Scene &, Material &) {};
    const auto mapped = [](Scene &, Material &m) { m.slopes = {SlopeMap::Kind::Normal, kNormals, 1}; };
    add(cases, "a smooth coat", coated(1, 0.1F), asItIs);
    add(cases, "a coat so rough that the cone is sampled", coated(0.8F, 1), asItIs);
    add(cases, "a textured coat", coated(1, 0.7F), [](Scene &, Material &m) {
        m.clearcoat.texture = m.clearcoatRoughness.texture = m.color.texture = kShares;
        m.clearcoatRoughness.channel = 1;
    });
    add(cases, "a coat over mapped facets", coated(1, 0.2F), mapped);
    add(cases, "a mapped coat over what is not", coated(1, 0.3F), [](Scene &, Material &m) {
        m.coatSlopes = {SlopeMap::Kind::Normal, kNormals, 2};
    });
    add(cases, "a mapped coat beside a mesh with a stored M", coated(1, 0.3F), [](Scene &s, Material &m) {
        m.coatSlopes = {SlopeMap::Kind::Normal, kNormals, 1};
        storeGloss(s);
    });
    add(cases, "a coat of its own map, from afar", coated(1, 0.3F), [&](Scene &s, Material &m) {
        mapped(s, m);
        m.coatSlopes = {SlopeMap::Kind::Bump, kSlopes, 0.5F};
        m.detail = TextureDetail::Moments;
        m.poisson = 0.3F;
    });
    add(cases, "steep facets under a steep coat", coated(1, 0.4F), [](Scene &, Material &m) {
        m.slopes = {SlopeMap::Kind::Normal, kNormals, 4};
        m.coatSlopes = {SlopeMap::Kind::Normal, kNormals, -4};
    });
    add(cases, "a coat on a compensated metal", coated(0.7F, 0.3F), [](Scene &, Material &m) {
        m.metallic.value = 1;
        m.alphaX.value = m.alphaY.value = 1;
    });
    add(cases, "a coat on a mapped metal, of which some lanes walk", coated(0.7F, 0.3F), [&](Scene &s, Material &m) {
        mapped(s, m);
        m.metallic = {1, kShares, 0};
        m.alphaX.value = m.alphaY.value = 0.9F;
    });
    add(cases, "a coat on white paint, separable", coated(1, 0.1F), [](Scene &, Material &m) {
        m.color.value = Vec3(1);
        m.masking = Masking::Separable;
    });
    add(cases, "specular, textured", paint(), [](Scene &, Material &m) {
        m.specular = {1, kShares, 1};
        m.specularColor = {Vec3(1, 0.5F, 1.5F), kShares};
        m.ior = 1.8F;
    });
    add(cases, "specular and facets, textured", paint(), [&](Scene &s, Material &m) {
        mapped(s, m);
        m.specular = {1, kShares, 1};
    });
    checkPictures(cases);
}

TEST_CASE("What emits is shaded at once as one by one", "[render][lanes]") {
    std::vector<LaneCase> cases;
    const auto shining = [](Scene &s, const Emission &slot) { s.objects[0].slotEmission = {slot}; };
    add(cases, "a mesh that shines", paint(), [&](Scene &s, Material &) { s.objects[0].emission.value = Vec3(0.3F, 0.2F, 0.1F); });
    add(cases, "a textured slot", paint(), [&](Scene &s, Material &m) {
        m.slopes = {SlopeMap::Kind::Normal, kNormals, 1};
        shining(s, {{Vec3(1, 2, 3), kShares}, true, kNone});
    });
    add(cases, "seen from inside, where it is dark", plain(BsdfType::Dielectric, 0.1F, 0.1F, 0), [&](Scene &s, Material &) {
        shining(s, {{Vec3(0.3F, 0.2F, 0.1F)}, false, kNone});
    });
    add(cases, "its last event", paint(), [&](Scene &s, Material &) {
        shining(s, {{Vec3(0.3F, 0.2F, 0.1F)}, true, kNone});
        s.render.maxEvents = 1;
    });
    add(cases, "lanes that walk", plain(BsdfType::Metal, 0.8F, 0.8F, 0), [&](Scene &s, Material &m) {
        m.slopes = {SlopeMap::Kind::Normal, kNormals, 1};
        m.multiscatter = Multiscatter::Auto;
        shining(s, {{Vec3(0.3F, 0.2F, 0.1F)}, true, kNone});
    });
    checkPictures(cases);
}

TEST_CASE("Every way of deforming at once gives the picture of one by one", "[render][lanes]") {
    std::vector<LaneCase> cases;
    const Material brushed = plain(BsdfType::Conductor, 0.08F, 0.4F, 0.5F);
    const auto asItIs = [](Scene &, Material &) {};
    const auto mapped = [](Scene &, Material &m) { m.slopes = {SlopeMap::Kind::Normal, kNormals, 1}; };
    const auto coated = [](Scene &, Material &m) {
        m.clearcoat.value = 0.7F;
        m.coatSlopes = {SlopeMap::Kind::Normal, kNormals, 1};
        m.poisson = 0.3F;
    };
    const auto roughens = [](Scene &, Material &m) {
        m.roughening = 0.4F;
        m.yield = 0.02F;
    };
    const auto addAll = [&](const std::string &name, const auto &change) {
        const auto both = [&](const auto &first) {
            return [&change, &first](Scene &s, Material &m) {
                first(s, m);
                change(s, m);
            };
        };
        add(cases, name, brushed, both(asItIs));
        add(cases, name + ", mapped", brushed, both(mapped));
        add(cases, name + ", coated", paint(), both(coated));
        add(cases, name + ", roughening", brushed, both(roughens));
        add(cases, name + ", a roughening coat", paint(), both([&](Scene &s, Material &m) {
                coated(s, m);
                roughens(s, m);
            }));
    };
    addAll("a mesh that leans", [](Scene &s, Material &) { s.objects[0].lean = true; });
    for (const auto scheme : {GradientInterpolation::Stretch, GradientInterpolation::DsDt, GradientInterpolation::Cholesky,
                              GradientInterpolation::LogEuclidean, GradientInterpolation::Face})
        addAll("scheme " + std::to_string(static_cast<int>(scheme)),
               [scheme](Scene &s, Material &) { s.objects[0].interpolation = scheme; });
    addAll("motion blur", [](Scene &s, Material &) {
        s.render.shutter = 1;
        s.objects[1].placement.translation.keys = {{1, DVec3(0, 0, -0.4)}, {3, DVec3(0.5, 0, -0.4)}};
    });
    addAll("motion blur of a mesh that leans", [](Scene &s, Material &) {
        s.render.shutter = 1;
        s.objects[0].lean = true;
    });
    add(cases, "two meshes of one material, of which one leans", brushed, [&](Scene &s, Material &m) {
        m.poisson = 0.4F;
        s.objects[1].materials = {0};
        s.objects[0].lean = true;
    });
    checkPictures(cases);
}

#pragma once
/// glTF 2.0's material (appendix B.3): a diffuse part under a dielectric's reflections, mixed with a metal's, on one microsurface,
///
///     f = (1 - m) [ (1 - max F) c / pi + F D V ] + m F_c D V
///
/// F, F_c: Schlick's with the cosine between view and half vector, the metal's F0 the base colour c. F0 and F90 of the dielectric part
/// are those of KHR_materials_ior and _specular. It has extensions' layers, too:
///     transmission   takes the place of a share of the diffuse part: straight through, spread as reflections are, or by refraction
///     iridescence    F of a thin film in the place of Schlick's (thin_film.h)
///     sheen          fibres on top, and what is below scaled by what their albedo leaves (sheen.h)
///     clearcoat      a dielectric of index 1.5 above everything, with its own microsurface (clear_coat.h)
///
/// Both terms of B.3 may add up to more than the light that comes: white at a grazing view by nearly 2. There, and only there, the
/// diffuse part is held to what reflections leave (LobeShares::kept).

#include "taut/base/warp.h"
#include "taut/bsdf/clear_coat.h"
#include "taut/bsdf/reflector.h"
#include "taut/bsdf/sheen.h"
#include "taut/bsdf/thin_film.h"
#include "taut/microsurface/energy_compensation.h"

namespace taut {

/// What its facets reflect.
struct MetallicRoughnessInterface {
    static constexpr bool kTransmits = false;
    enum class Part : std::uint8_t { Both, Dielectric, Metal };
    const Bsdf &bsdf;
    Part part = Part::Both; ///< one of them alone, as if it were all of the surface

    [[nodiscard, gnu::always_inline]] Vec3 reflectance(float cosine, bool /*beyond*/ = false) const {
        const float c = outside(cosine);
        Vec3 r = part == Part::Both    ? fresnel::schlick(c, bsdf.f0, bsdf.f90)
                 : part == Part::Metal ? fresnel::schlick(c, bsdf.metalF0)
                                       : fresnel::schlick(c, bsdf.dielectricF0, bsdf.coverF90);
        if (bsdf.film.share > 0) r = glm::mix(r, filmed(c), bsdf.film.share);
        const bool meets = c >= 0;
        return {meets ? r.x : 1.0F, meets ? r.y : 1.0F, meets ? r.z : 1.0F};
    }
    /// Light that goes from facet to facet is mixed as a whole, not at each of them: walks, by `choose` in [0, 1), are of one part.
    [[nodiscard]] MetallicRoughnessInterface partOfWalk(float choose) const {
        return {bsdf, choose < bsdf.metallic ? Part::Metal : Part::Dielectric};
    }
    [[nodiscard]] Vec3 meanReflectance() const {
        return fresnel::diffuseMean([&](float cosine) { return reflectance(cosine); });
    }
    /// What the dielectric part keeps from layers below it, in the brightest channel: one number, so that no colour is made of white.
    [[nodiscard, gnu::always_inline]] float cover(float cosine) const {
        const float c = outside(cosine);
        float covered = bsdf.coverF0 + (bsdf.coverF90 - bsdf.coverF0) * fresnel::schlickShare(c);
        if (bsdf.film.share > 0)
            covered = glm::mix(covered, maxComponent(thin_film::reflectance(c, bsdf.film.ior, bsdf.film.thickness, bsdf.dielectricF0)),
                               bsdf.film.share);
        return c >= 0 ? covered : 1.0F;
    }

  private:
    /// Schlick's cosine is the one in air: seen from inside a volume, that of the refracted ray; negative at total reflection.
    [[nodiscard, gnu::always_inline]] float outside(float cosine) const {
        if (!bsdf.refracts || bsdf.eta >= 1) return cosine;
        const float c2 = 1 - (1 - cosine * cosine) / (bsdf.eta * bsdf.eta);
        return c2 > 0 ? std::sqrt(c2) : -1.0F;
    }
    [[nodiscard]] Vec3 filmed(float cosine) const {
        const auto film = [&](const Vec3 &f0) { return thin_film::reflectance(cosine, bsdf.film.ior, bsdf.film.thickness, f0); };
        const float metal = part == Part::Both ? bsdf.metallic : part == Part::Metal ? 1.0F : 0.0F;
        Vec3 sum(0);
        if (metal < 1) sum += (1 - metal) * film(bsdf.dielectricF0);
        if (metal > 0) sum += metal * film(bsdf.metalF0);
        return sum;
    }
};

struct MetallicRoughnessBsdf {
    [[gnu::always_inline]] static MetallicRoughnessInterface interface(const Bsdf &bsdf) { return MetallicRoughnessInterface{bsdf}; }

    static void make(const MaterialValues &material, Bsdf &bsdf) {
        const float m = material.metallic;
        const float dielectric = 1 - m;
        // KHR_materials_specular: F0 is tinted and held at 1, then both ends are scaled. An index of 0 reflects everything (_ior).
        const float normal = sqr((material.ior - 1) / (material.ior + 1));
        const Vec3 f0 = glm::min(normal * material.specularColor, Vec3(1)) * material.specular;
        bsdf.f0 = dielectric * f0 + m * material.color;
        bsdf.f90 = dielectric * material.specular + m;
        bsdf.coverF0 = maxComponent(f0);
        bsdf.coverF90 = material.specular;
        bsdf.refracts = !material.thinWalled && material.transmission > 0 && material.ior > 0 && m < 1;
        bsdf.albedo = material.color * (dielectric * (1 - material.transmission));
        bsdf.tint = material.color * (dielectric * material.transmission);
        bsdf.coat = material.clearcoat;
        bsdf.sheenColor = material.sheenColor;
        bsdf.sheenAlpha = material.sheenAlpha;
        bsdf.film = material.film;
        bsdf.metallic = m;
        bsdf.dielectricF0 = f0;
        bsdf.metalF0 = material.color;
    }

    /// Fills the view's shares and layers, and puts the compensation of the facets below layers and beside lobes.
    static void prepare(BsdfView &view, MultipleScattering &multiple) {
        const Bsdf &bsdf = view.bsdf;
        color(bsdf, multiple);
        LayerView &layers = view.layers;
        LobeShares &shares = view.lobe.shares;
        float coat = 0, sheen = 0;
        if (bsdf.coat > 0) {
            const Vec3 wo = inCoat(bsdf, view.wo);
            coat = layers.coatShare = clear_coat::reflectance(bsdf.coat, wo);
            const float length = ggx::stretchedLength(bsdf.coatMicro, wo);
            const float area = ggx::visibleArea(bsdf.coatMicro, wo, length);
            layers.coatReflections.emplace(bsdf.coatMicro, wo, bsdf.bearableWaste);
            layers.coatLobe = {length, area, layers.coatReflections->pdfScale(), bsdf.correlated, bsdf.eta, {}};
            shares.under -= coat;
        }
        if (hasSheen(bsdf) && view.wo.z > 0) {
            const float white = sheen::albedo(view.wo.z, bsdf.sheenAlpha);
            layers.sheenScale = white > 1 ? 1 / white : 1.0F;
            sheen = maxComponent(bsdf.sheenColor) * std::fmin(white, 1.0F);
            layers.sheenScale *= shares.under;
            sheen *= shares.under;
            shares.under -= sheen;
        }
        const bool surelyDark = isSurelyDark(bsdf, bsdf.micro, view.wo);
        Reflected reflected = reflectedAtNormal(bsdf, view.wo);
        if (!surelyDark) {
            reflected = {};
            for (std::size_t node = 0; node < kMeanNodes; ++node) addVisible(bsdf, bsdf.micro, view.wo, node, reflected);
            shares.kept = keptDiffuse(bsdf, bsdf.micro, view.wo, multiple, reflected);
        }
        divide(bsdf, reflected, sheen, coat, shares, multiple);
    }

    static BsdfEval evaluate(const BsdfView &view, const Vec3 &wi) {
        const BsdfEval e = beside(view, wi);
        return wi.z > 0 ? withFacets(e, view.bsdf, view.bsdf.micro, view.lobe, view.wo, wi) : e;
    }

    static BsdfEval beside(const BsdfView &view, const Vec3 &wi) {
        if (wi.z > 0) return lobesAbove(view, wi);
        if (wi.z < 0 && view.lobe.shares.through > 0) return view.bsdf.refracts ? refracted(view, wi) : passed(view, wi);
        return {};
    }

    // --- many at once, without fibres on top and without what passes ---
    [[gnu::always_inline]] static BsdfEval above(const Bsdf &bsdf, const MicroTransform &m, const LobeView &view, const Vec3 &wo,
                                                 const Vec3 &wi) {
        return withFacets(diffusePart(bsdf, view.shares, wo, wi), bsdf, m, view, wo, wi);
    }
    [[gnu::always_inline]] static LaneSample sampleLane(const Bsdf &bsdf, const MicroTransform &m, const LobeView &view, float cap,
                                                        const Vec3 &wo, const Vec2 &u, float lobe) {
        const float share = view.shares.facets;
        const LaneSample facets = Reflector<MetallicRoughnessBsdf>::sampleLane(bsdf, m, view, cap, wo, u, lobe / share);
        const Vec3 diffuse = squareToCosineHemisphere(u);
        const bool isFacets = lobe < share;
        return {Vec3(isFacets ? facets.wi.x : diffuse.x, isFacets ? facets.wi.y : diffuse.y, isFacets ? facets.wi.z : diffuse.z), 1,
                isFacets ? facets.coin : -1.0F};
    }

    /// And with a coat, which sees wi in its own frame.
    [[gnu::always_inline]] static BsdfEval aboveCoated(const Bsdf &bsdf, const MicroTransform &m, const LobeView &view,
                                                       const clear_coat::Seen &coat, const Vec3 &wo, const Vec3 &wi, const Vec3 &wiInCoat) {
        const BsdfEval e = clear_coat::aboveWhere(diffusePart(bsdf, view.shares, wo, wi), coat, view.shares.coat, wiInCoat);
        return withFacets(e, bsdf, m, view, wo, wi);
    }

    /// The compensation's colour is that of each part alone, mixed.
    static void color(const Bsdf &bsdf, MultipleScattering &multiple) {
        if (multiple.treatment == Multiscatter::Compensation) multiple.color = severalFacets(bsdf, 1 - multiple.lossMean);
    }

    /// Means over what the viewer sees of the microsurface.
    struct Reflected {
        Vec3 all{0};     ///< by the facets
        float cover = 0; ///< MetallicRoughnessInterface::cover
    };
    static constexpr std::size_t kMeanNodes = 8; ///< visible normals that reflectances are averaged over

    /// Where no light could be made, the reflectance at the normal does for a choice.
    [[gnu::always_inline]] static Reflected reflectedAtNormal(const Bsdf &bsdf, const Vec3 &wo) {
        const MetallicRoughnessInterface facets{bsdf};
        const float cosine = std::fabs(wo.z);
        return {facets.reflectance(cosine), facets.cover(cosine)};
    }
    /// One node of a rank-1 lattice of visible normals, for every M.
    [[gnu::always_inline]] static void addVisible(const Bsdf &bsdf, const MicroTransform &m, const Vec3 &wo, std::size_t node,
                                                  Reflected &mean) {
        const MetallicRoughnessInterface facets{bsdf};
        const auto at = static_cast<float>(node);
        const float around = at * 0.375F + 0.0625F;
        const Vec2 u(around - static_cast<float>(static_cast<int>(around)), (at + 0.5F) / kMeanNodes);
        const float cosine = glm::dot(wo, ggx::sampleVisibleNormal(m, wo, u));
        const Vec3 all = facets.reflectance(cosine) * (1.0F / kMeanNodes);
        mean.all = {mean.all.x + all.x, mean.all.y + all.y, mean.all.z + all.z};
        mean.cover += facets.cover(cosine) * (1.0F / kMeanNodes);
    }

    /// Whether the parts cannot add up to more than 1: seen within 45 degrees of the normal, a surface of alpha up to 1 has come 5 % of the
    /// way from F0 to F90 at most (0.042 by the lattice).
    [[gnu::always_inline]] static bool isSurelyDark(const Bsdf &bsdf, const MicroTransform &m, const Vec3 &wo) {
        const bool black = (bsdf.albedo.x == 0) & (bsdf.albedo.y == 0) & (bsdf.albedo.z == 0);
        return black | ((wo.z > 0.71F) & (maxComponent(bsdf.f0 + bsdf.albedo + bsdf.tint) + 0.05F <= 1) & !bsdf.refracts &
                        !(bsdf.film.share > 0) & (slopeTensor(m).larger() <= 1));
    }

    /// The diffuse part beside all that is reflected or passes, and how far off that may be.
    struct Room {
        Vec3 diffuse, beside;
        float margin;
        [[nodiscard, gnu::always_inline]] bool suffices() const { return !(maxComponent(beside + diffuse) + margin > 1); }
    };
    [[gnu::always_inline]] static Room roomFor(const Bsdf &bsdf, const Vec3 &wo, const Reflected &reflected) {
        const float c = glm::clamp(wo.z, 0.0F, 1.0F);
        const float schlick = 0.0280843F + c * (-0.0775432F + c * (0.0751559F - c * 0.0256882F));
        float cover = bsdf.coverF0 + (bsdf.coverF90 - bsdf.coverF0) * schlick;
        if (bsdf.film.share > 0) cover = glm::mix(cover, 0.0F, bsdf.film.share); // no closed form: as if it covered nothing
        const Vec3 diffuse = bsdf.albedo * (1 - cover);
        const Vec3 beside = reflected.all + bsdf.tint * (1 - reflected.cover);
        return {Vec3(diffuse.x, diffuse.y, diffuse.z), Vec3(beside.x, beside.y, beside.z), kEstimateError * fresnel::schlickShare(c)};
    }
    /// The diffuse part's share that leaves the albedo of everything at 1 in every channel. With E the albedo of a white mirror of such
    /// facets, and light of several given back, the facets reflect E F + (1 - E) F_several; the diffuse part sends back its colour
    /// times 1 - (F0 + (F90 - F0) s), s the mean over the hemisphere of Schlick's share at the half vector (a cubic in the view's
    /// cosine, within 8e-5 of quadrature).
    static float keptDiffuse(const Bsdf &bsdf, const MicroTransform &m, const Vec3 &wo, const MultipleScattering &multiple,
                             const Reflected &reflected) {
        const Room room = roomFor(bsdf, wo, reflected);
        if (room.suffices()) return 1;
        if (!(m.upright() && wo.z > 0)) return keptIn(room, 0, Vec3(0));
        const float loss = multiple.treatment == Multiscatter::Compensation ? multiple.loss : 1 - energy::singleScatterAlbedo(m, wo);
        if (multiple.treatment == Multiscatter::Walk) return keptIn(room, loss, severalFacets(bsdf, energy::averageAlbedo(m)));
        return keptIn(room, loss, multiple.treatment == Multiscatter::Compensation ? multiple.color : Vec3(0));
    }
    /// Where there is not room for all of it: the facets lose that much of what they reflect, of which the share `several` is given back.
    [[gnu::always_inline]] static float keptIn(const Room &room, float loss, const Vec3 &several) {
        const auto in = [&](float diffuse, float beside, float back) __attribute__((always_inline)) {
            const float all = beside * (1 - loss) + loss * back;
            const float share = (1 - room.margin - all) / (diffuse > 0 ? diffuse : 1.0F);
            return (diffuse > 0) & (share < 1) ? share : 1.0F;
        };
        const float x = in(room.diffuse.x, room.beside.x, several.x);
        const float y = in(room.diffuse.y, room.beside.y, several.y);
        const float z = in(room.diffuse.z, room.beside.z, several.z);
        const float xy = y < x ? y : x;
        const float least = z < xy ? z : xy;
        return least > 0 ? least : 0.0F;
    }

    /// Samples by what each lobe brings, none starved: facets that lean from the normal may let pass what the mean does not. `sheen` and
    /// `coat`: what these reflect.
    [[gnu::always_inline]] static void divide(const Bsdf &bsdf, const Reflected &reflected, float sheen, float coat, LobeShares &shares,
                                              MultipleScattering &multiple) {
        const auto share = [](bool isThere, float light) __attribute__((always_inline)) {
            const float bright = kLeastLight < light ? light : kLeastLight;
            return isThere ? bright : 0.0F;
        };
        const float below = 1 - reflected.cover;
        const bool mirrors = (bsdf.f90 > 0) | (bsdf.f0.x != 0) | (bsdf.f0.y != 0) | (bsdf.f0.z != 0);
        const bool colored = (bsdf.albedo.x != 0) | (bsdf.albedo.y != 0) | (bsdf.albedo.z != 0);
        const bool passes = (bsdf.tint.x != 0) | (bsdf.tint.y != 0) | (bsdf.tint.z != 0);
        const bool diffuse = colored & (shares.kept > 0);
        const float facets = share(mirrors, shares.under * luminance(reflected.all));
        const float spread = share(diffuse | (sheen > 0), shares.under * below * shares.kept * luminance(bsdf.albedo) + sheen);
        const float through = share(passes, shares.under * below * luminance(bsdf.tint));
        const float onTop = share(coat > 0, coat);
        const float sum = facets + spread + through + onTop;
        const bool any = sum > 0;
        if (multiple.probability > 0 && any) {
            const float several = shares.under * multiple.loss * luminance(multiple.color);
            multiple.probability = several / (several + sum);
            multiple.color *= shares.under;
        }
        const float whole = any ? sum : 1.0F;
        shares.facets = any ? facets / whole : 1.0F;
        shares.diffuse = spread / whole;
        shares.through = through / whole;
        shares.coat = onTop / whole;
    }

    static std::optional<Vec3> sample(const BsdfView &view, const Vec2 &u, float lobe) {
        const float facets = view.lobe.shares.facets;
        if (lobe < facets) return view.reflections->sample(u, lobe / facets);
        return sampleLobes(view, u, lobe - facets);
    }
    static std::optional<Vec3> sampleBeside(const BsdfView &view, const Vec2 &u, float lobe) {
        return sampleLobes(view, u, lobe * (1 - view.lobe.shares.facets));
    }

  private:
    static constexpr float kLeastLight = 0.02F; ///< of a lobe that is there, for the choice of samples
    /// How far the reflected light may be above E times that mean, at grazing, by the lattice and the table of E: found by quadrature for
    /// alpha 0.02 to 2.
    static constexpr float kEstimateError = 0.025F;

    static bool hasSheen(const Bsdf &bsdf) { return bsdf.sheenColor != Vec3(0); }

    /// Colour of the light of several facets, of each part alone and mixed.
    static Vec3 severalFacets(const Bsdf &bsdf, float averageAlbedo) {
        using Part = MetallicRoughnessInterface::Part;
        const auto of = [&](Part part) {
            return energy::multipleColor(MetallicRoughnessInterface{bsdf, part}.meanReflectance(), averageAlbedo);
        };
        Vec3 sum(0);
        if (bsdf.metallic < 1) sum += (1 - bsdf.metallic) * of(Part::Dielectric);
        if (bsdf.metallic > 0) sum += bsdf.metallic * of(Part::Metal);
        return sum;
    }

    /// What facets add to other lobes.
    [[gnu::always_inline]] static BsdfEval withFacets(const BsdfEval &others, const Bsdf &bsdf, const MicroTransform &m,
                                                      const LobeView &view, const Vec3 &wo, const Vec3 &wi) {
        const BsdfEval facets = Reflector<MetallicRoughnessBsdf>::above(bsdf, m, view, wo, wi);
        const float under = view.shares.under;
        return {Vec3(others.fCos.x + facets.fCos.x * under, others.fCos.y + facets.fCos.y * under, others.fCos.z + facets.fCos.z * under),
                others.pdf + facets.pdf * view.shares.facets};
    }

    /// wi.z > 0.
    [[gnu::always_inline]] static BsdfEval diffusePart(const Bsdf &bsdf, const LobeShares &shares, const Vec3 &wo, const Vec3 &wi) {
        const float cosineDensity = kInvPi * wi.z;
        const Vec3 h = wo + wi;
        const float inverse = 1 / std::sqrt(glm::dot(h, h));
        const float below = 1 - MetallicRoughnessInterface{bsdf}.cover(glm::dot(wo, h) * inverse);
        const float scale = shares.diffuse > 0 ? below * shares.kept * shares.under * cosineDensity : 0.0F;
        return {Vec3(bsdf.albedo.x * scale, bsdf.albedo.y * scale, bsdf.albedo.z * scale), shares.diffuse * cosineDensity};
    }

    /// Diffuse part, fibres and coat: wi.z > 0.
    static BsdfEval lobesAbove(const BsdfView &view, const Vec3 &wi) {
        const Bsdf &bsdf = view.bsdf;
        const LobeShares &shares = view.lobe.shares;
        const LayerView &layers = view.layers;
        BsdfEval e = diffusePart(bsdf, shares, view.wo, wi);
        if (shares.diffuse > 0 && hasSheen(bsdf) && view.wo.z > 0) {
            const Vec3 h = view.wo + wi;
            const float cosH = h.z * (1 / std::sqrt(glm::dot(h, h)));
            e.fCos += bsdf.sheenColor * (layers.sheenScale * sheen::lobe(view.wo.z, wi.z, cosH, bsdf.sheenAlpha));
        }
        const Vec3 up = inCoat(bsdf, wi);
        if (!(shares.coat > 0 && up.z > 0)) return e;
        return clear_coat::above(e, {bsdf.coatMicro, layers.coatLobe, layers.coatShare, inCoat(bsdf, view.wo)}, shares.coat, up);
    }

    /// A direction in the coat's own frame.
    static Vec3 inCoat(const Bsdf &bsdf, const Vec3 &w) { return bsdf.coatTilted ? bsdf.coatFrame.toLocal(w) : w; }
    /// What the coat reflects below the horizon of what it covers is left out.
    static std::optional<Vec3> sampleCoat(const BsdfView &view, const Vec2 &u, float coin) {
        std::optional<Vec3> wi = view.layers.coatReflections->sample(u, coin);
        if (!wi || !view.bsdf.coatTilted) return wi;
        wi = view.bsdf.coatFrame.fromLocal(*wi);
        return wi->z > 0 ? wi : std::nullopt;
    }

    /// KHR_materials_transmission: the lobe of reflection mirrored at a wall so thin that nothing is bent.
    static BsdfEval passed(const BsdfView &view, const Vec3 &wi) {
        const Bsdf &bsdf = view.bsdf;
        BsdfEval e = reflectionLobe(bsdf.micro, view.lobe, view.wo, Vec3(wi.x, wi.y, -wi.z),
                                    [&](float cosine) { return bsdf.tint * (1 - MetallicRoughnessInterface{bsdf}.cover(cosine)); });
        e.fCos *= view.lobe.shares.under;
        e.pdf *= view.lobe.shares.through;
        return e;
    }

    /// KHR_materials_volume: into the medium behind the surface.
    static BsdfEval refracted(const BsdfView &view, const Vec3 &wi) {
        const Bsdf &bsdf = view.bsdf;
        float below = 0;
        BsdfEval e = refractionLobe(bsdf.micro, view.lobe, view.wo, wi, [&](float cosine) {
            below = 1 - MetallicRoughnessInterface{bsdf}.cover(cosine);
            return 1.0F;
        });
        if (!(e.pdf > 0)) return {};
        e.fCos *= bsdf.tint * (below * view.lobe.shares.under);
        e.pdf *= view.lobe.shares.through;
        return e;
    }

    /// `at` in [0, 1 - facets).
    static std::optional<Vec3> sampleLobes(const BsdfView &view, const Vec2 &u, float at) {
        const LobeShares &shares = view.lobe.shares;
        if (at < shares.coat) return sampleCoat(view, u, at / shares.coat);
        at -= shares.coat;
        if (at < shares.through) return view.bsdf.refracts ? sampleRefracted(view, u) : samplePassed(view, u, at / shares.through);
        if (!(shares.diffuse > 0)) return std::nullopt; // rounding
        return squareToCosineHemisphere(u);
    }
    static std::optional<Vec3> samplePassed(const BsdfView &view, const Vec2 &u, float coin) {
        const std::optional<Vec3> wi = view.reflections->sample(u, coin);
        return wi ? std::optional<Vec3>({wi->x, wi->y, -wi->z}) : std::nullopt;
    }
    static std::optional<Vec3> sampleRefracted(const BsdfView &view, const Vec2 &u) {
        const Vec3 wm = ggx::spreadVisibleNormal(view.bsdf.micro, view.wo, u);
        const float cosine = glm::dot(view.wo, wm);
        Vec3 wi;
        if (!(cosine > 0) || !fresnel::refract(view.wo, wm, cosine, view.bsdf.eta, wi) || !(wi.z < 0)) return std::nullopt;
        return wi;
    }
};

} // namespace taut

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
///     clearcoat      a dielectric of index 1.5 above everything, with its own microsurface; F by the cosine at the normal
///
/// Both terms of B.3 may add up to more than the light that comes: white at a grazing view by nearly 2. There, and only there, the
/// diffuse part is held to what reflections leave (LayerView::kept).

#include "taut/base/warp.h"
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

    [[nodiscard]] Vec3 reflectance(float cosine, bool /*beyond*/ = false) const {
        const float c = outside(cosine);
        if (!(c >= 0)) return Vec3(1);
        const Vec3 schlick = part == Part::Both    ? fresnel::schlick(c, bsdf.f0, bsdf.f90)
                             : part == Part::Metal ? fresnel::schlick(c, bsdf.metalF0)
                                                   : fresnel::schlick(c, bsdf.dielectricF0, bsdf.coverF90);
        return bsdf.film.share > 0 ? glm::mix(schlick, filmed(c), bsdf.film.share) : schlick;
    }
    /// Light that goes from facet to facet is mixed as a whole, not at each of them: walks, by `choose` in [0, 1), are of one part.
    [[nodiscard]] MetallicRoughnessInterface partOfWalk(float choose) const {
        return {bsdf, choose < bsdf.metallic ? Part::Metal : Part::Dielectric};
    }
    [[nodiscard]] Vec3 meanReflectance() const {
        return fresnel::diffuseMean([&](float cosine) { return reflectance(cosine); });
    }
    /// What the dielectric part keeps from layers below it, in the brightest channel: one number, so that no colour is made of white.
    [[nodiscard]] float cover(float cosine) const {
        const float c = outside(cosine);
        if (!(c >= 0)) return 1;
        const float schlick = bsdf.coverF0 + (bsdf.coverF90 - bsdf.coverF0) * fresnel::schlickShare(c);
        if (!(bsdf.film.share > 0)) return schlick;
        return glm::mix(schlick, maxComponent(thin_film::reflectance(c, bsdf.film.ior, bsdf.film.thickness, bsdf.dielectricF0)),
                        bsdf.film.share);
    }

  private:
    /// Schlick's cosine is the one in air: seen from inside a volume, that of the refracted ray; negative at total reflection.
    [[nodiscard]] float outside(float cosine) const {
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
    static MetallicRoughnessInterface interface(const Bsdf &bsdf) { return {bsdf, MetallicRoughnessInterface::Part::Both}; }

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

    /// Fills view.layers, and puts the compensation of the facets below layers and beside lobes.
    static void prepare(BsdfView &view, MultipleScattering &multiple) {
        const Bsdf &bsdf = view.bsdf;
        if (multiple.treatment == Multiscatter::Compensation) multiple.color = severalFacets(bsdf, 1 - multiple.lossMean);
        LayerView &layers = view.layers;
        float coat = 0;
        float sheen = 0;
        if (bsdf.coat > 0) {
            const Vec3 wo = inCoat(bsdf, view.wo);
            coat = layers.coatShare = bsdf.coat * (kCoatF0 + (1 - kCoatF0) * fresnel::schlickShare(std::fabs(wo.z)));
            const float length = ggx::stretchedLength(bsdf.coatMicro, wo);
            const float area = ggx::visibleArea(bsdf.coatMicro, wo, length);
            layers.coatReflections.emplace(bsdf.coatMicro, wo, bsdf.bearableWaste);
            layers.coatLobe = {length, area, layers.coatReflections->pdfScale(), bsdf.correlated, bsdf.eta};
            layers.under -= coat;
        }
        if (hasSheen(bsdf) && view.wo.z > 0) {
            const float white = sheen::albedo(view.wo.z, bsdf.sheenAlpha);
            layers.sheenScale = white > 1 ? 1 / white : 1.0F;
            sheen = maxComponent(bsdf.sheenColor) * std::fmin(white, 1.0F);
            layers.sheenScale *= layers.under;
            sheen *= layers.under;
            layers.under -= sheen;
        }
        const bool surelyDark = isSurelyDark(view);
        const Reflected reflected = meanReflected(view, surelyDark);
        const float below = 1 - reflected.cover;
        if (!surelyDark) layers.kept = keptDiffuse(view, multiple, reflected);
        // Samples by what each lobe brings, none starved: facets that lean from the normal may let pass what the mean does not.
        const auto share = [](bool isThere, float light) { return isThere ? std::fmax(light, kLeastLight) : 0.0F; };
        const bool diffuse = bsdf.albedo != Vec3(0) && layers.kept > 0;
        layers.facets = share(bsdf.f90 > 0 || bsdf.f0 != Vec3(0), layers.under * luminance(reflected.all));
        layers.diffuse = share(diffuse || sheen > 0, layers.under * below * layers.kept * luminance(bsdf.albedo) + sheen);
        layers.through = share(bsdf.tint != Vec3(0), layers.under * below * luminance(bsdf.tint));
        layers.coat = share(coat > 0, coat);
        const float sum = layers.facets + layers.diffuse + layers.through + layers.coat;
        if (!(sum > 0)) return void(layers.facets = 1);
        if (multiple.probability > 0) {
            const float several = layers.under * multiple.loss * luminance(multiple.color);
            multiple.probability = several / (several + sum);
            multiple.color *= layers.under;
        }
        for (float *part : {&layers.facets, &layers.diffuse, &layers.through, &layers.coat}) *part /= sum;
    }

    static BsdfEval evaluate(const BsdfView &view, const Vec3 &wi) {
        BsdfEval e = beside(view, wi);
        if (wi.z <= 0) return e;
        const BsdfEval facets = Reflector<MetallicRoughnessBsdf>::evaluate(view, wi);
        e.fCos += facets.fCos * view.layers.under;
        e.pdf += facets.pdf * view.layers.facets;
        return e;
    }

    static BsdfEval beside(const BsdfView &view, const Vec3 &wi) {
        if (wi.z > 0) return above(view, wi);
        if (wi.z < 0 && view.layers.through > 0) return view.bsdf.refracts ? refracted(view, wi) : passed(view, wi);
        return {};
    }

    static std::optional<Vec3> sample(const BsdfView &view, const Vec2 &u, float lobe) {
        if (lobe < view.layers.facets) return view.reflections->sample(u, lobe / view.layers.facets);
        return sampleLobes(view, u, lobe - view.layers.facets);
    }
    static std::optional<Vec3> sampleBeside(const BsdfView &view, const Vec2 &u, float lobe) {
        return sampleLobes(view, u, lobe * (1 - view.layers.facets));
    }

  private:
    static constexpr float kCoatF0 = 0.04F;      ///< of index 1.5
    static constexpr float kLeastLight = 0.02F;  ///< of a lobe that is there, for the choice of samples
    static constexpr std::size_t kMeanNodes = 8; ///< visible normals that reflectances are averaged over
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

    /// Means over what the viewer sees of the microsurface.
    struct Reflected {
        Vec3 all;    ///< by the facets
        float cover; ///< MetallicRoughnessInterface::cover
    };

    /// Whether the parts cannot add up to more than 1: seen within 45 degrees of the normal, a surface of alpha up to 1 has come 5 % of the
    /// way from F0 to F90 at most (0.042 by the lattice below).
    static bool isSurelyDark(const BsdfView &view) {
        const Bsdf &bsdf = view.bsdf;
        if (bsdf.albedo == Vec3(0)) return true;
        return view.wo.z > 0.71F && maxComponent(bsdf.f0 + bsdf.albedo + bsdf.tint) + 0.05F <= 1 && !bsdf.refracts &&
               !(bsdf.film.share > 0) && slopeTensor(bsdf.micro).larger() <= 1;
    }

    /// By a rank-1 lattice of visible normals, for every M; where no light could be made, the reflectance at the normal does for a choice.
    static Reflected meanReflected(const BsdfView &view, bool surelyDark) {
        const Bsdf &bsdf = view.bsdf;
        const MetallicRoughnessInterface facets{bsdf};
        if (surelyDark) {
            const float cosine = std::fabs(view.wo.z);
            return {facets.reflectance(cosine), facets.cover(cosine)};
        }
        Reflected mean{Vec3(0), 0};
        for (std::size_t i = 0; i < kMeanNodes; ++i) {
            const auto at = static_cast<float>(i);
            const Vec2 u(std::fmod(at * 0.375F + 0.0625F, 1.0F), (at + 0.5F) / kMeanNodes);
            const float cosine = glm::dot(view.wo, ggx::sampleVisibleNormal(bsdf.micro, view.wo, u));
            mean.all += facets.reflectance(cosine) * (1.0F / kMeanNodes);
            mean.cover += facets.cover(cosine) * (1.0F / kMeanNodes);
        }
        return mean;
    }

    /// The diffuse part's share that leaves the albedo of everything at 1 in every channel. With E the albedo of a white mirror of such
    /// facets, and light of several given back, the facets reflect E F + (1 - E) F_several; the diffuse part sends back its colour
    /// times 1 - (F0 + (F90 - F0) s), s the mean over the hemisphere of Schlick's share at the half vector (a cubic in the view's
    /// cosine, within 8e-5 of quadrature).
    static float keptDiffuse(const BsdfView &view, const MultipleScattering &multiple, const Reflected &reflected) {
        const Bsdf &bsdf = view.bsdf;
        const float c = glm::clamp(view.wo.z, 0.0F, 1.0F);
        const float schlick = 0.0280843F + c * (-0.0775432F + c * (0.0751559F - c * 0.0256882F));
        float cover = bsdf.coverF0 + (bsdf.coverF90 - bsdf.coverF0) * schlick;
        if (bsdf.film.share > 0) cover = glm::mix(cover, 0.0F, bsdf.film.share); // no closed form: as if it covered nothing
        const Vec3 diffuse = bsdf.albedo * (1 - cover);
        Vec3 beside = reflected.all + bsdf.tint * (1 - reflected.cover);
        const float margin = kEstimateError * fresnel::schlickShare(c);
        if (!(maxComponent(beside + diffuse) + margin > 1)) return 1;
        if (bsdf.micro.upright() && view.wo.z > 0) {
            const float loss =
                multiple.treatment == Multiscatter::Compensation ? multiple.loss : 1 - energy::singleScatterAlbedo(bsdf.micro, view.wo);
            beside *= 1 - loss;
            if (multiple.treatment == Multiscatter::Compensation) beside += loss * multiple.color;
            if (multiple.treatment == Multiscatter::Walk) beside += loss * severalFacets(bsdf, energy::averageAlbedo(bsdf.micro));
        }
        float kept = 1;
        for (int i = 0; i < 3; ++i)
            if (diffuse[i] > 0) kept = std::fmin(kept, (1 - margin - beside[i]) / diffuse[i]);
        return std::fmax(kept, 0.0F);
    }

    /// Diffuse part, fibres and coat: wi.z > 0.
    static BsdfEval above(const BsdfView &view, const Vec3 &wi) {
        const Bsdf &bsdf = view.bsdf;
        const LayerView &layers = view.layers;
        const float cosineDensity = kInvPi * wi.z;
        BsdfEval e{Vec3(0), layers.diffuse * cosineDensity};
        if (layers.diffuse > 0) {
            const Vec3 h = view.wo + wi;
            const float inverse = 1 / std::sqrt(glm::dot(h, h));
            const float below = 1 - MetallicRoughnessInterface{bsdf}.cover(glm::dot(view.wo, h) * inverse);
            e.fCos = bsdf.albedo * (below * layers.kept * layers.under * cosineDensity);
            if (hasSheen(bsdf) && view.wo.z > 0)
                e.fCos += bsdf.sheenColor * (layers.sheenScale * sheen::lobe(view.wo.z, wi.z, h.z * inverse, bsdf.sheenAlpha));
        }
        if (const Vec3 up = inCoat(bsdf, wi); layers.coat > 0 && up.z > 0) {
            const BsdfEval coat = reflectionLobe(bsdf.coatMicro, layers.coatLobe, inCoat(bsdf, view.wo), up,
                                                 [&](float /*cosine*/) { return Vec3(layers.coatShare); });
            e.fCos += coat.fCos;
            e.pdf += layers.coat * coat.pdf;
        }
        return e;
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
        e.fCos *= view.layers.under;
        e.pdf *= view.layers.through;
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
        e.fCos *= bsdf.tint * (below * view.layers.under);
        e.pdf *= view.layers.through;
        return e;
    }

    /// `at` in [0, 1 - facets).
    static std::optional<Vec3> sampleLobes(const BsdfView &view, const Vec2 &u, float at) {
        const LayerView &layers = view.layers;
        if (at < layers.coat) return sampleCoat(view, u, at / layers.coat);
        at -= layers.coat;
        if (at < layers.through) return view.bsdf.refracts ? sampleRefracted(view, u) : samplePassed(view, u, at / layers.through);
        if (!(layers.diffuse > 0)) return std::nullopt; // rounding
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

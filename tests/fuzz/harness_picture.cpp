/// Any mesh through topology, subdivision, a frame's gradient and a picture of 4 x 3 pixels with many lights.

#include "harness.h"
#include "harness_list.h"

#include "render_fixtures.h"

#include "taut/mesh/topology.h"
#include "taut/plan/plan.h"
#include "taut/render/denoise_features.h"
#include "taut/render/denoise_frames.h"
#include "taut/render/image_file.h"
#include "taut/render/light_groups.h"
#include "taut/scene/check_scene.h"
#include "taut/scene/ground.h"

#include <algorithm>

namespace taut::fuzz {

namespace {

/// Numbers from bytes; zeros when they are used up.
class Source {
  public:
    explicit Source(std::string_view bytes) : bytes_(bytes) {}
    [[nodiscard]] bool empty() const { return at_ >= bytes_.size(); }
    unsigned byte() { return empty() ? 0 : static_cast<unsigned char>(bytes_[at_++]); }
    unsigned below(unsigned count) { return byte() % count; }
    bool flag() { return (byte() & 1U) != 0; }
    /// Mostly small and round, so that points and edges meet; at times far away, tiny or next to another.
    float number() {
        const unsigned b = byte();
        if (b < 200) return (static_cast<float>(b) - 100) / 25;
        static constexpr float kOdd[] = {0, 1e-30F, -1e-7F, 1e6F, -1e15F, 1e19F, 1.0000001F, -1e-38F};
        return kOdd[b % std::size(kOdd)];
    }
    Vec3 vector() {
        const float x = number();
        const float y = number();
        return {x, y, number()};
    }
    float share() { return static_cast<float>(byte()) / 255; }

  private:
    std::string_view bytes_;
    std::size_t at_ = 0;
};

Mesh meshFrom(Source &source) {
    Mesh mesh;
    mesh.name = "fuzz";
    const unsigned points = 3 + source.below(22);
    for (unsigned p = 0; p < points; ++p) mesh.positions.push_back(source.vector());
    const bool uvs = source.flag();
    const bool normals = source.flag();
    const bool slots = source.flag();
    const unsigned faces = 1 + source.below(24);
    for (unsigned f = 0; f < faces; ++f) {
        const unsigned corners = 3 + (source.flag() ? source.below(6) : 0);
        for (unsigned c = 0; c < corners; ++c) mesh.cornerPositions.push_back(source.below(points));
        mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
        if (slots) mesh.faceMaterials.push_back(source.below(2));
    }
    if (slots) mesh.materialNames = {"one", "two"};
    if (uvs) {
        for (unsigned p = 0; p < points; ++p) mesh.uvs.emplace_back(source.number(), source.number());
        mesh.cornerUvs = mesh.cornerPositions;
    }
    if (normals) {
        for (unsigned p = 0; p < points; ++p) mesh.normals.push_back(glm::normalize(source.vector() + Vec3(0, 0, 1e-3F)));
        mesh.cornerNormals = mesh.cornerPositions;
        for (std::size_t c = 0; c < mesh.cornerNormals.size(); ++c)
            if (!isFinite(mesh.normals[mesh.cornerNormals[c]])) mesh.cornerNormals[c] = kNone;
        for (Vec3 &normal : mesh.normals)
            if (!isFinite(normal)) normal = Vec3(0, 0, 1);
    }
    if (source.flag()) mesh.creases.push_back({mesh.cornerPositions[0], mesh.cornerPositions[1], source.share() * 12});
    if (source.flag()) mesh.corners.push_back({mesh.cornerPositions[0], source.share() * 12});
    return mesh;
}

/// Faces of which a reader would leave none; those are no finding.
void dropFlatFaces(Mesh &mesh) {
    Mesh kept = mesh;
    kept.faceOffsets = {0};
    kept.cornerPositions.clear();
    kept.cornerUvs.clear();
    kept.cornerNormals.clear();
    kept.faceMaterials.clear();
    for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
        const auto begin = mesh.cornerPositions.begin() + mesh.faceOffsets[f];
        const auto end = mesh.cornerPositions.begin() + mesh.faceOffsets[f + 1];
        std::vector<Index> distinct(begin, end);
        std::sort(distinct.begin(), distinct.end());
        if (std::unique(distinct.begin(), distinct.end()) - distinct.begin() < 3) continue;
        for (Index c = mesh.faceOffsets[f]; c < mesh.faceOffsets[f + 1]; ++c) {
            kept.cornerPositions.push_back(mesh.cornerPositions[c]);
            if (!mesh.cornerUvs.empty()) kept.cornerUvs.push_back(mesh.cornerUvs[c]);
            if (!mesh.cornerNormals.empty()) kept.cornerNormals.push_back(mesh.cornerNormals[c]);
        }
        kept.faceOffsets.push_back(static_cast<Index>(kept.cornerPositions.size()));
        if (!mesh.faceMaterials.empty()) kept.faceMaterials.push_back(mesh.faceMaterials[f]);
    }
    mesh = std::move(kept);
}

DeformerKeys deformerFrom(Source &source) {
    DeformerKeys keys;
    keys.type = static_cast<DeformerType>(source.below(7));
    keys.centre = DVec3(source.vector());
    keys.axis = static_cast<int>(source.below(3));
    keys.axis2 = (keys.axis + 1) % 3;
    keys.lower = -1;
    keys.upper = keys.lower + 0.01 + static_cast<double>(source.share());
    keys.factor = DVec3(glm::abs(source.vector()) + 1e-3F);
    keys.amount.keys = {{1, 0.0}, {3, static_cast<double>(source.number())}};
    keys.amplitude = static_cast<double>(source.number());
    keys.wavelength = 0.01 + static_cast<double>(source.share());
    if (keys.type == DeformerType::Taper) keys.amount = static_cast<double>(source.share());
    if (keys.type == DeformerType::Lattice) {
        keys.latticeOffsets.assign(8, Keyed<DVec3>(DVec3(0)));
        keys.latticeOffsets[source.below(8)] = DVec3(source.vector());
    }
    return keys;
}

Material materialFrom(Source &source) {
    Material material;
    material.type = static_cast<BsdfType>(source.below(static_cast<unsigned>(kBsdfs.size())));
    material.color.value = Vec3(source.share());
    material.conductorEta = Vec3(0.2F, 0.9F, 1.2F);
    material.conductorK = Vec3(3);
    material.alphaX.value = 1e-4F + source.share();
    material.alphaY.value = 1e-4F + source.share();
    material.rotation.value = source.number();
    material.metallic.value = source.share();
    material.poisson = source.share() / 2;
    material.multiscatter = static_cast<Multiscatter>(source.below(4));
    if (source.flag()) {
        material.transmission.value = source.share();
        material.clearcoat.value = source.share();
        material.sheenColor.value = Vec3(source.share());
        material.iridescence.value = source.share();
        material.thinWalled = source.flag();
        material.roughening = source.share();
        material.alphaMode = static_cast<AlphaMode>(source.below(3));
        material.opacity.value = source.share();
        material.doubleSided = source.flag();
    }
    return material;
}

Light lightFrom(Source &source) {
    Light light;
    light.radiance = Vec3(source.share() * 10);
    const DVec3 place(source.vector());
    DVec3 direction(source.vector() + Vec3(0, 0, 1e-3F));
    direction = glm::length(direction) > 0 && glm::length(direction) < 1e30 ? glm::normalize(direction) : DVec3(0, 0, -1);
    switch (source.below(5)) {
    case 0: light.shape = QuadLight{place, DVec3(0, 0.5, 0), DVec3(0.5, 0, 0.1), source.flag()}; break;
    case 1: light.shape = SphereLight{place, 0.01 + static_cast<double>(source.share())}; break;
    case 2: light.shape = DirectionalLight{direction}; break;
    case 3: light.shape = PointLight{place}; break;
    default: {
        SpotLight spot;
        spot.position = place;
        spot.direction = direction;
        light.shape = spot;
    }
    }
    return light;
}

Scene sceneFrom(Source &source) {
    Scene scene;
    scene.path = "fuzz";
    scene.render.width = 4;
    scene.render.height = 3;
    scene.render.spp = 1;
    scene.render.maxEvents = 4;
    scene.render.shutter = source.flag() ? 1 : 0;
    scene.render.motionSteps = 2;
    scene.materials = {materialFrom(source), materialFrom(source)};
    Object object;
    object.name = "fuzz";
    Mesh mesh = meshFrom(source);
    dropFlatFaces(mesh);
    object.mesh = std::make_shared<const Mesh>(std::move(mesh));
    object.materials = {0, 1};
    object.materials.resize(std::max<std::size_t>(1, object.mesh->materialNames.size()));
    object.smooth = source.flag();
    object.follow = !source.flag() || source.flag();
    object.lean = source.flag();
    object.subdivision.level = static_cast<int>(source.below(4)) % 3;
    object.subdivision.scheme = source.flag() ? SubdivisionScheme::Loop : SubdivisionScheme::CatmullClark;
    object.subdivision.boundary = source.flag() ? SubdivisionBoundary::EdgeOnly : SubdivisionBoundary::EdgeAndCorner;
    if (source.flag()) object.subdivision.creaseAngle = source.share() * 3;
    if (source.flag()) object.interpolation = static_cast<GradientInterpolation>(source.below(5));
    if (source.flag()) object.emission.value = Vec3(source.share());
    if (!object.lean && source.flag()) object.gradient = static_cast<GradientEstimator>(source.below(object.subdivision.level > 0 ? 5 : 4));
    if (source.flag()) object.placement.scale = Keyed<DVec3>(DVec3(source.vector()));
    if (source.flag()) object.placement.translation.keys = {{1, DVec3(0)}, {3, DVec3(source.vector())}};
    for (unsigned d = source.below(4); d > 0; --d) object.deformers.push_back(deformerFrom(source));
    scene.objects.push_back(std::move(object));
    scene.camera.position = DVec3(0.3, -3.2, 1.9);
    if (source.flag()) scene.environment = constantEnvironment(Vec3(source.share()));
    for (unsigned l = source.below(64); l > 0 && !source.empty(); --l) scene.lights.push_back(lightFrom(source));
    return scene;
}

void requireNumbers(const std::vector<float> &values) {
    for (const float value : values) require(!std::isnan(value), "a picture has no value that is no number");
}

FilmLayers layersFrom(Source &source) {
    FilmLayers layers;
    layers.objects = source.flag();
    layers.materials = source.flag();
    layers.lights = source.flag();
    layers.samples = source.flag();
    layers.variance = source.flag();
    layers.ranks = 2 + 2 * static_cast<int>(source.below(16));
    return layers;
}

/// Two frames, the second with what the first shows.
void renderDenoised(RenderScene &scene, FrameOptions options, Source &source) {
    options.denoiseBlock = 1;
    options.spp = 2 + static_cast<int>(source.below(3));
    FrameDenoiser denoiser(source.flag());
    std::optional<FrameBefore> before;
    for (const double frame : {2.0, 3.0}) {
        if (frame > 2) {
            before.emplace(scene);
            StageTimes times;
            scene.setFrame(frame, times);
            options.before = &*before;
        }
        const Denoised picture = denoiser.next(renderFrame(scene, options).film);
        requireNumbers(picture.rgb);
        requireNumbers(picture.error);
    }
}

void writeAndRead(const RenderScene &scene, const Film &film, Source &source) {
    const Image image = imageOf(film, scene.scene().render);
    ImageSettings settings;
    settings.exrHalf = source.flag();
    settings.exrCompression = exrCompressions()[source.below(static_cast<unsigned>(exrCompressions().size()))];
    settings.pngBits = source.flag() ? 16 : 8;
    settings.view.exposure = static_cast<double>(source.number());
    settings.view.view = source.flag() ? "filmic" : "";
    for (const char *name : {"/picture.exr", "/picture.png"}) {
        const std::string path = scratchFolder() + name;
        if (std::string_view(name).ends_with("exr")) checkCompressionOf(settings.exrCompression, image.channels);
        writeImage(path, image, matteMetadata(scene.scene(), film.layers()), settings);
        const Image read = readImage(path);
        require(read.width == image.width && read.height == image.height && read.window == image.window, "what is written can be read");
        if (std::string_view(name).ends_with("exr")) require(read.channels.size() == image.channels.size(), "with all channels");
    }
}

} // namespace

void runPicture(std::string_view bytes) {
    survive([&] {
        Source source(bytes);
        Scene scene = sceneFrom(source);
        const Mesh &mesh = *scene.objects.front().mesh;
        static_cast<void>(topologyOf(mesh, true));
        if (mesh.faceCount() == 0) return;
        const bool planned = source.flag();
        check(scene);
        if (source.flag()) {
            scene.render.ground = scene.unsaid.camera = scene.unsaid.up = true;
            if (const std::optional<Ground> ground = groundOf(scene)) standOn(*ground, scene);
            check(scene);
        }
        std::optional<RenderScene> ready;
        if (planned) {
            PlannedScene plan = planScene(scene, {});
            ready.emplace(std::move(scene), std::move(plan.plan), false, std::move(plan.surfaces));
        } else {
            ready.emplace(std::move(scene), source.flag());
        }
        StageTimes times;
        ready->setFrame(2, times);
        FrameOptions options;
        options.spp = 1;
        const std::string_view all = "all";
        if (source.flag()) options.aovs = aovsNamed({&all, 1}, "fuzz");
        if (source.flag()) options.layers = layersFrom(source);
        if (source.flag()) {
            renderDenoised(*ready, options, source);
            return;
        }
        const FrameResult result = renderFrame(*ready, options);
        requireNumbers(result.film.resolve());
        if (source.flag()) writeAndRead(*ready, result.film, source);
    });
}

std::vector<std::string> pictureSeeds() {
    std::vector<std::string> seeds;
    for (unsigned seed = 1; seed <= 24; ++seed) { // a multiplicative generator, Park and Miller 1988
        std::string bytes;
        std::uint64_t state = seed;
        for (unsigned i = 0; i < 200 + 40 * seed; ++i) {
            state = state * 48271 % 2147483647;
            bytes += static_cast<char>(state >> 8U & 0xffU);
        }
        seeds.push_back(std::move(bytes));
    }
    return seeds;
}

} // namespace taut::fuzz

/// Animated positions of every vertex, through the library's own path from file to frame, against two others: an evaluation in
/// double written down from the specification (gltf_reference.h), at any time, and Blender, at the times of keys (it does not
/// interpolate rotations as glTF asks; tests/blender/skinned_positions.py says more).

#include "assets.h"
#include "command.h"
#include "gltf_reference.h"
#include "render_fixtures.h"

#include "taut/scene/load_scene.h"
#include "taut/scene/object_motion.h"

#include <array>
#include <set>

using namespace taut;
using namespace taut::test;

namespace {

/// Times to look at, as shares of a clip.
constexpr std::array<double, 8> kShares{-0.1, 0.0, 0.137, 0.391, 0.618, 0.905, 1.0, 1.3};

/// Largest distance between matching points over the diagonal of the reference's box. Infinite where the counts differ.
double relativeError(const std::vector<DVec3> &points, const std::vector<DVec3> &reference) {
    if (points.size() != reference.size() || reference.empty()) return std::numeric_limits<double>::infinity();
    DVec3 lower = reference.front();
    DVec3 upper = lower;
    double largest = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        lower = glm::min(lower, reference[i]);
        upper = glm::max(upper, reference[i]);
        largest = std::max(largest, glm::length(points[i] - reference[i]));
    }
    return largest / glm::length(upper - lower);
}

/// A file loaded as the command loads it.
struct Loaded {
    Scene scene;
    explicit Loaded(const std::string &path, const std::string &clip = "") {
        Warnings warnings;
        std::vector<std::string> overrides;
        if (!clip.empty()) overrides.push_back("mesh.0.clip=\"" + clip + "\"");
        scene = loadScene(path, overrides, warnings);
    }
    [[nodiscard]] const Rig &rig() const { return *scene.objects.front().rig->rig; }

    /// The object of a node.
    [[nodiscard]] const Object &objectOf(const std::string &node) const {
        for (const Object &object : scene.objects)
            if (rig().nodes[object.rig->node].name == node) return object;
        throw std::logic_error("no object of node " + node);
    }

    /// Positions in the file's space, y up.
    [[nodiscard]] std::vector<DVec3> positions(const Object &object, double seconds) const {
        ObjectMotion motion;
        motionAtFrame(object, 1 + seconds * scene.render.fps, scene.render.fps, DMat4(1), motion);
        std::vector<Vec3> world;
        evaluatePositions(motion.state, object.mesh->skin, world);
        std::vector<DVec3> out;
        for (const Vec3 &p : world) out.emplace_back(p.x, p.z, -p.y);
        return out;
    }
};

/// The name of a node, else the one that the reader gives it.
std::string nameOf(const GltfReference &reference, int node) {
    return reference.nodes()[static_cast<std::size_t>(node)].value("name", "node" + std::to_string(node));
}

/// Positions of a node's mesh: of the vertices that faces use, primitive by primitive, shared ones once.
std::vector<DVec3> usedPositions(const GltfReference &reference, int node, int animation, double seconds) {
    const auto &primitives = reference.primitives(node);
    std::vector<DVec3> out;
    for (std::size_t p = 0; p < primitives.size(); ++p) {
        const auto shares = [&](std::size_t other) { return primitives[other]["attributes"] == primitives[p]["attributes"]; };
        bool isFirst = true;
        for (std::size_t earlier = 0; earlier < p; ++earlier) isFirst &= !shares(earlier);
        if (!isFirst) continue;
        std::vector<bool> used = reference.usedVertices(primitives[p]);
        for (std::size_t later = p + 1; later < primitives.size(); ++later) {
            if (!shares(later)) continue;
            const std::vector<bool> too = reference.usedVertices(primitives[later]);
            for (std::size_t v = 0; v < used.size(); ++v) used[v] = used[v] || too[v];
        }
        const std::vector<DVec3> all = reference.positions(node, primitives[p], animation, seconds);
        for (std::size_t v = 0; v < all.size(); ++v)
            if (used[v]) out.push_back(all[v]);
    }
    return out;
}

/// Times at which every rotation of the clip stands on a key or does not turn: there Blender and glTF agree.
std::vector<double> keyTimes(const Clip &clip) {
    std::set<float> all;
    for (const Channel &channel : clip.channels) all.insert(channel.times.begin(), channel.times.end());
    const auto isOnKeys = [](const Channel &channel, float time) {
        if (channel.path != ChannelPath::Rotation || channel.interpolation == Interpolation::Step) return true;
        const auto next = std::lower_bound(channel.times.begin(), channel.times.end(), time);
        if (next == channel.times.begin() || next == channel.times.end() || *next == time) return true;
        const auto key = static_cast<std::size_t>(next - channel.times.begin()) * channel.width;
        return std::equal(channel.values.begin() + static_cast<std::ptrdiff_t>(key - channel.width),
                          channel.values.begin() + static_cast<std::ptrdiff_t>(key),
                          channel.values.begin() + static_cast<std::ptrdiff_t>(key));
    };
    std::vector<double> times;
    for (const float time : all)
        if (std::all_of(clip.channels.begin(), clip.channels.end(), [&](const Channel &channel) { return isOnKeys(channel, time); }))
            times.push_back(static_cast<double>(time));
    return times;
}

/// `count` of them, evenly spread, the first and the last included.
std::vector<double> spread(const std::vector<double> &times, std::size_t count) {
    if (times.size() <= count) return times;
    std::vector<double> chosen;
    for (std::size_t i = 0; i < count; ++i) chosen.push_back(times[i * (times.size() - 1) / (count - 1)]);
    return chosen;
}

/// Largest errors of one mesh over the times, and how far it moves.
struct MeshErrors {
    std::size_t vertices = 0;
    double largest = 0;
    double farthest = 0;
};
MeshErrors compareMesh(const Loaded &loaded, const Object &ours, const std::function<std::vector<DVec3>(double)> &expectedAt,
                       double duration) {
    const std::vector<DVec3> start = expectedAt(0);
    MeshErrors errors{start.size(), 0, 0};
    for (const double share : kShares) {
        const double seconds = share * duration;
        const std::vector<DVec3> expected = expectedAt(seconds);
        const double error = relativeError(loaded.positions(ours, seconds), expected);
        INFO(ours.name << " at " << seconds << " s");
        CHECK(error <= 2e-6);
        errors.largest = std::max(errors.largest, error);
        errors.farthest = std::max(errors.farthest, relativeError(expected, start));
    }
    return errors;
}

/// The first clip, at times on keys, between them and outside.
void compareWithReference(const std::string &path) {
    const Loaded loaded(path);
    const GltfReference reference(path);
    const double duration = static_cast<double>(loaded.rig().clips.front().duration);
    double largest = 0;
    double farthest = 0;
    std::size_t vertices = 0;
    for (const int node : reference.meshNodes()) {
        const Object &ours = loaded.objectOf(nameOf(reference, node));
        INFO(path << ", " << nameOf(reference, node));
        const auto expectedAt = [&](double seconds) { return usedPositions(reference, node, 0, seconds); };
        const MeshErrors errors = compareMesh(loaded, ours, expectedAt, duration);
        vertices += errors.vertices;
        largest = std::max(largest, errors.largest);
        farthest = std::max(farthest, errors.farthest);
    }
    CHECK(farthest > 1e-3); // it did move
    std::cout << fs::path(path).filename().string() << " against the specification in double: " << vertices << " vertices at "
              << kShares.size() << " times, largest error " << largest << " of the diagonal" << std::endl;
}

/// Largest distance from a corner (position in diagonals, normal) of one list to its nearest of the other.
double farthestCorner(const std::vector<std::pair<DVec3, DVec3>> &from, const std::vector<std::pair<DVec3, DVec3>> &to) {
    double largest = 0;
    for (const auto &[position, normal] : from) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto &[p, n] : to) nearest = std::min(nearest, glm::length(p - position) + glm::length(n - normal));
        largest = std::max(largest, nearest);
    }
    return largest;
}

/// Normals of nodes without a skin, morphed ones included: where the file's vertices are, both ways. A morph may turn faces inside out and
/// its file's normals not with them: expected is the side of the faces, and either where they are on edge.
void compareNormals(const std::string &path) {
    const Loaded loaded(path);
    const GltfReference reference(path);
    const double duration = static_cast<double>(loaded.rig().clips.front().duration);
    double largest = 0;
    double turned = 0;
    std::size_t against = 0;
    for (const int node : reference.meshNodes()) {
        const Object &ours = loaded.objectOf(nameOf(reference, node));
        std::vector<std::pair<DVec3, DVec3>> start;
        for (const double share : kShares) {
            const double seconds = share * duration;
            const DeformedVertices surface = surfaceOf(ours, 1 + seconds * loaded.scene.render.fps, loaded.scene.render.fps);
            std::vector<std::pair<DVec3, DVec3>> expected;
            std::vector<std::pair<DVec3, DVec3>> either;
            std::vector<std::pair<DVec3, DVec3>> sure;
            for (const auto &primitive : reference.primitives(node)) {
                const std::vector<bool> used = reference.usedVertices(primitive);
                const std::vector<DVec3> points = reference.positions(node, primitive, 0, seconds);
                const std::vector<DVec3> normals = reference.normals(node, primitive, 0, seconds);
                REQUIRE(normals.size() == points.size());
                const std::vector<DVec3> faces = reference.faceNormals(primitive, points);
                for (std::size_t v = 0; v < points.size(); ++v) {
                    const double side = glm::dot(faces[v], normals[v]) / glm::length(faces[v]);
                    const DVec3 outward = side < 0 ? -normals[v] : normals[v];
                    if (used[v]) expected.emplace_back(points[v], outward);
                    if (!used[v]) continue;
                    if (std::fabs(side) < 0.2)
                        either.emplace_back(points[v], -outward);
                    else
                        sure.emplace_back(points[v], outward);
                    against += side < 0 ? 1 : 0;
                }
            }
            std::vector<std::pair<DVec3, DVec3>> found;
            for (std::size_t v = 0; v < surface.normals.size(); ++v) {
                const Vec3 &p = surface.positions[v];
                const Vec3 &n = surface.normals[v];
                found.emplace_back(DVec3(p.x, p.z, -p.y), DVec3(n.x, n.z, -n.y));
            }
            either.insert(either.end(), expected.begin(), expected.end());
            const double error = std::max(farthestCorner(sure, found), farthestCorner(found, either));
            INFO(path << ", " << ours.name << " at " << seconds << " s");
            CHECK(error < 1e-4);
            largest = std::max(largest, error);
            if (start.empty()) start = expected;
            for (std::size_t v = 0; v < expected.size(); ++v) turned = std::max(turned, glm::length(expected[v].second - start[v].second));
        }
    }
    CHECK(turned > 0.1); // they did turn
    std::cout << fs::path(path).filename().string() << ": normals against the specification in double, largest error " << largest << "; "
              << against << " of the file's stood against its faces" << std::endl;
}

std::string exact(double value) {
    char text[40];
    std::snprintf(text, sizeof(text), "%.17g", value);
    return text;
}

/// What Blender makes of a file: {"objects": [{"name", "times": [[[x, y, z]]]}]}.
nlohmann::json blenderPositions(const std::string &path, const std::string &clip, const std::vector<double> &times) {
    const std::string output = outputFolder("blender") + "/" + fs::path(path).stem().string() + ".json";
    fs::remove(output);
    Arguments words{"blender", "-b", "-noaudio", "--factory-startup", "--python", TAUT_SOURCE_DIR "/tests/blender/skinned_positions.py",
                    "--",      path, output};
    for (const double time : times) words.push_back(exact(time));
    if (!clip.empty()) words.insert(words.end(), {"--clip", clip});
    const CommandResult result = runProgram(words, 300);
    INFO(result.out << result.err);
    REQUIRE(result.exitCode == 0);
    return nlohmann::json::parse(readBytes(output));
}

void compareWithBlender(const std::string &path, const std::string &clipName) {
    const Loaded loaded(path, clipName);
    const GltfReference reference(path);
    const RigMotion &motion = *loaded.scene.objects.front().rig;
    REQUIRE(motion.clip != kNone);
    const std::vector<double> times = spread(keyTimes(motion.rig->clips[motion.clip]), 5);
    REQUIRE(times.size() >= 3);
    const nlohmann::json blender = blenderPositions(path, clipName, times);
    const std::vector<int> nodes = reference.meshNodes();
    REQUIRE(blender["objects"].size() == nodes.size());
    std::size_t vertices = 0;
    double largest = 0;
    for (const int node : nodes) {
        const std::string name = nameOf(reference, node);
        const auto match =
            std::find_if(blender["objects"].begin(), blender["objects"].end(), [&](const auto &object) { return object["name"] == name; });
        REQUIRE((nodes.size() == 1 || match != blender["objects"].end()));
        const auto &object = nodes.size() == 1 ? blender["objects"][0] : *match;
        for (std::size_t t = 0; t < times.size(); ++t) {
            const std::vector<DVec3> points = loaded.positions(loaded.objectOf(name), times[t]);
            std::vector<DVec3> theirs;
            for (const auto &p : object["times"][t]) theirs.emplace_back(p[0], p[1], p[2]);
            const double error = relativeError(points, theirs);
            INFO(path << ", " << name << " at " << times[t] << " s");
            CHECK(error <= 1e-5);
            largest = std::max(largest, error);
            if (t == 0) vertices += points.size();
        }
    }
    std::cout << fs::path(path).filename().string() << " against Blender " << blender["blender"].get<std::string>() << ": " << vertices
              << " vertices at " << times.size() << " keys of " << (clipName.empty() ? "its clip" : clipName) << ", largest error "
              << largest << " of the diagonal" << std::endl;
}

} // namespace

TEST_CASE("positions agree with a double-precision evaluation of glTF at any time", "[gltf_reference]") {
    for (const char *name :
         {"anim/khronos/SimpleSkin.gltf", "anim/khronos/RiggedSimple.glb", "anim/khronos/RiggedFigure.glb", "anim/khronos/Fox.glb",
          "anim/khronos/CesiumMan.glb", "anim/khronos/BoxAnimated.glb", "anim/khronos/SimpleMorph.gltf",
          "anim/khronos/AnimatedMorphCube.glb", "anim/blender_io/03_skinned_cylinder/03_skinned_cylinder.gltf", "anim/kaykit/Knight.glb"})
        if (const auto path = asset(name)) compareWithReference(*path);
}

TEST_CASE("normals of nodes and morphs agree with a double-precision evaluation of glTF", "[gltf_reference][normals]") {
    for (const char *name : {"anim/khronos/AnimatedMorphCube.glb", "anim/khronos/AnimatedMorphSphere.glb", "anim/khronos/BoxAnimated.glb"})
        if (const auto path = asset(name)) compareNormals(*path);
}

TEST_CASE("positions agree with Blender at key times", "[blender]") {
    if (runProgram({"blender", "--version"}, 60).exitCode != 0) {
        std::cout << "SKIPPED: there is no Blender on this machine" << std::endl;
        return;
    }
    const std::vector<std::pair<std::string, std::string>> clips{
        {"anim/khronos/Fox.glb", "Survey"},
        {"anim/khronos/CesiumMan.glb", ""},
        {"anim/blender_io/03_skinned_cylinder/03_skinned_cylinder.gltf", ""},
        {"anim/khronos/AnimatedMorphSphere.glb", ""},
        {"anim/kaykit/Knight.glb", "Walking_A"},
    };
    for (const auto &[name, clip] : clips)
        if (const auto path = asset(name)) compareWithBlender(*path, clip);
}

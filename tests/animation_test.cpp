#include "taut/deform/animation.h"
#include "taut/formats/gltf.h"

#include "assets.h"
#include "catch.h"

#include <glm/gtc/matrix_transform.hpp>
#include <limits>

using namespace taut;

namespace {

constexpr double kPiD = 3.14159265358979323846;

/// x, y, z, w of a turn about an axis of unit length.
std::vector<float> turn(const DVec3 &axis, double angle) {
    const DVec3 v = axis * std::sin(angle / 2);
    return {float(v.x), float(v.y), float(v.z), float(std::cos(angle / 2))};
}

std::vector<float> joined(const std::vector<std::vector<float>> &parts) {
    std::vector<float> all;
    for (const auto &part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

Channel channelOf(ChannelPath path, Interpolation interpolation, std::vector<float> times, std::vector<float> values) {
    Channel channel;
    channel.node = 0;
    channel.path = path;
    channel.interpolation = interpolation;
    channel.width = path == ChannelPath::Rotation ? 4 : 3;
    channel.times = std::move(times);
    channel.values = std::move(values);
    return channel;
}

double maxDifference(const std::vector<float> &a, const std::vector<float> &b) {
    REQUIRE(a.size() == b.size());
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i) worst = std::fmax(worst, std::fabs(double(a[i]) - b[i]));
    return worst;
}

double maxDifference(const DMat4 &a, const DMat4 &b) {
    double worst = 0;
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) worst = std::fmax(worst, std::fabs(a[column][row] - b[column][row]));
    return worst;
}

DMat4 translation(const DVec3 &t) {
    return glm::translate(DMat4(1), t);
}
DMat4 scaling(const DVec3 &s) {
    return glm::scale(DMat4(1), s);
}
DMat4 rotationZ(double angle) {
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return {c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
}

Node nodeOf(Index parent) {
    Node node;
    node.parent = parent;
    return node;
}

} // namespace

TEST_CASE("STEP holds each key until the next", "[animation]") {
    const Channel channel = channelOf(ChannelPath::Translation, Interpolation::Step, {1, 2, 4}, {1, 2, 3, 4, 5, 6, 7, 8, 9});
    CHECK(evaluateChannel(channel, 0) == std::vector<float>{1, 2, 3});
    CHECK(evaluateChannel(channel, 1.999) == std::vector<float>{1, 2, 3});
    CHECK(evaluateChannel(channel, 2) == std::vector<float>{4, 5, 6});
    CHECK(evaluateChannel(channel, 3.999) == std::vector<float>{4, 5, 6});
    CHECK(evaluateChannel(channel, 4) == std::vector<float>{7, 8, 9});
    CHECK(evaluateChannel(channel, 400) == std::vector<float>{7, 8, 9});
}

TEST_CASE("LINEAR goes straight between keys and holds the ends", "[animation]") {
    const Channel channel = channelOf(ChannelPath::Translation, Interpolation::Linear, {1, 2, 4}, {1, 2, 3, 5, 2, 1, 7, 8, 9});
    CHECK(evaluateChannel(channel, -1) == std::vector<float>{1, 2, 3});
    CHECK(evaluateChannel(channel, 1) == std::vector<float>{1, 2, 3});
    CHECK(evaluateChannel(channel, 1.25) == std::vector<float>{2, 2, 2.5F});
    CHECK(evaluateChannel(channel, 2) == std::vector<float>{5, 2, 1});
    CHECK(evaluateChannel(channel, 3) == std::vector<float>{6, 5, 5});
    CHECK(evaluateChannel(channel, 9) == std::vector<float>{7, 8, 9});
    CHECK(evaluateChannel(channel, std::numeric_limits<double>::quiet_NaN()) == std::vector<float>{1, 2, 3});
}

TEST_CASE("LINEAR rotations turn at an even pace along the shorter arc", "[animation]") {
    const DVec3 axis = glm::normalize(DVec3(1, 2, -2));
    for (const double angle : {1e-9, 1e-4, 0.5, 2.0, kPiD - 1e-3}) {
        const std::vector<float> from = turn(axis, 0.3);
        const std::vector<float> to = turn(axis, 0.3 + angle);
        std::vector<float> negative = to; // the same rotation, on the far side of the sphere
        for (float &x : negative) x = -x;
        for (const double u : {0.0, 0.1, 0.5, 0.9, 1.0}) {
            const std::vector<float> expected = turn(axis, 0.3 + u * angle);
            CHECK(maxDifference(evaluateChannel(channelOf(ChannelPath::Rotation, Interpolation::Linear, {0, 1}, joined({from, to})), u),
                                expected) < 3e-7);
            std::vector<float> other =
                evaluateChannel(channelOf(ChannelPath::Rotation, Interpolation::Linear, {0, 1}, joined({from, negative})), u);
            if (u == 1)
                for (float &x : other) x = -x; // the last key as it is stored
            CHECK(maxDifference(other, expected) < 3e-7);
        }
    }
    // 350 degrees is 10 degrees the other way round.
    const Channel wide =
        channelOf(ChannelPath::Rotation, Interpolation::Linear, {0, 1}, joined({turn(axis, 0), turn(axis, 350 * kPiD / 180)}));
    std::vector<float> middle = evaluateChannel(wide, 0.5);
    CHECK(maxDifference(middle, turn(axis, -5 * kPiD / 180)) < 3e-7);
}

TEST_CASE("Rotations come out with unit length", "[animation]") {
    // Keys as normalised bytes leave them, and components that do not cancel on the way.
    const std::vector<float> values{0, 0, 0, 0.99F, 0.7F, 0, 0, 0.7F, 0, 0, 0.5F, 0.5F};
    const auto length = [](const std::vector<float> &q) {
        return std::sqrt(double(q[0]) * q[0] + double(q[1]) * q[1] + double(q[2]) * q[2] + double(q[3]) * q[3]);
    };
    for (const Interpolation interpolation : {Interpolation::Step, Interpolation::Linear})
        for (const double t : {-1.0, 0.0, 0.3, 1.0, 1.7, 2.0, 3.0})
            CHECK(length(evaluateChannel(channelOf(ChannelPath::Rotation, interpolation, {0, 1, 2}, values), t)) ==
                  Approx(1).epsilon(2e-7));
    const std::vector<float> spline{0, 0, 0, 0, 0, 0, 0, 1, 5, 0, 0, 0, /**/ 0, 2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0};
    for (const double t : {-1.0, 0.0, 0.3, 0.9, 1.0})
        CHECK(length(evaluateChannel(channelOf(ChannelPath::Rotation, Interpolation::CubicSpline, {0, 1}, spline), t)) ==
              Approx(1).epsilon(2e-7));
    // A quaternion without length is no rotation, not a NaN.
    CHECK(evaluateChannel(channelOf(ChannelPath::Rotation, Interpolation::Linear, {0, 1}, std::vector<float>(8, 0.0F)), 0.5) ==
          std::vector<float>{0, 0, 0, 1});
}

TEST_CASE("CUBICSPLINE reproduces a cubic, its tangents counted per second", "[animation]") {
    // p(t) = (t^3 - 2 t, t^2, 1 - t) with p'(t) = (3 t^2 - 2, 2 t, -1), keys at 1, 3, 3.5.
    const auto p = [](float t) { return std::vector<float>{t * t * t - 2 * t, t * t, 1 - t}; };
    const auto slope = [](float t) { return std::vector<float>{3 * t * t - 2, 2 * t, -1}; };
    std::vector<std::vector<float>> parts;
    for (const float t : {1.0F, 3.0F, 3.5F}) {
        parts.push_back(slope(t));
        parts.push_back(p(t));
        parts.push_back(slope(t));
    }
    const Channel channel = channelOf(ChannelPath::Translation, Interpolation::CubicSpline, {1, 3, 3.5F}, joined(parts));
    for (const float t : {1.0F, 1.5F, 2.25F, 3.0F, 3.125F, 3.5F}) CHECK(maxDifference(evaluateChannel(channel, t), p(t)) < 4e-6);
    CHECK(evaluateChannel(channel, 0) == p(1));
    CHECK(evaluateChannel(channel, 9) == p(3.5F));
}

TEST_CASE("CUBICSPLINE by hand: which tangent belongs to which side", "[animation]") {
    // One component moves: value 0 -> 1 over 2 s; only the first key's out-tangent (1.5 per second) and the second key's
    // in-tangent (-0.5 per second) may count. Halfway: (0 + 1)/2 + 2 s * (1.5 - -0.5) / 8 = 1.
    const std::vector<float> values{90, 0, 0, 0, 0, 0, 1.5F, 0, 0, /**/ -0.5F, 0, 0, 1, 0, 0, 70, 0, 0};
    const Channel channel = channelOf(ChannelPath::Scale, Interpolation::CubicSpline, {0, 2}, values);
    CHECK(evaluateChannel(channel, 1)[0] == 1.0F);
    // A quarter: h00 = 27/32, h10 = 9/64, h01 = 5/32, h11 = -3/64: 5/32 + 2 * (1.5 * 9/64 + 0.5 * 3/64) = 0.625.
    CHECK(evaluateChannel(channel, 0.5)[0] == 0.625F);
}

TEST_CASE("Nodes compose from the root down", "[animation]") {
    Rig rig;
    rig.nodes = {nodeOf(kNone), nodeOf(0), nodeOf(1), nodeOf(0)};
    rig.nodes[0].translation = {1, 2, 3};
    rig.nodes[0].rotation = glm::angleAxis(kPiD / 2, DVec3(0, 0, 1));
    rig.nodes[1].scale = {2, 3, 4};
    rig.nodes[1].translation = {0, 1, 0};
    const DMat4 sheared(1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 4, 0, 0, 1);
    rig.nodes[2].matrix = sheared;
    rig.nodes[2].translation = {99, 99, 99}; // a matrix speaks for itself
    rig.nodes[3].morphWeights = {0.25F, 0.5F};
    const Pose pose = evaluatePose(rig, nullptr, 0.7);

    const DMat4 root = translation({1, 2, 3}) * rotationZ(kPiD / 2);
    const DMat4 child = root * translation({0, 1, 0}) * scaling({2, 3, 4});
    REQUIRE(pose.worldFromNode.size() == 4);
    CHECK(maxDifference(pose.worldFromNode[0], root) < 1e-15);
    CHECK(maxDifference(pose.worldFromNode[1], child) < 1e-15);
    CHECK(maxDifference(pose.worldFromNode[2], child * sheared) < 1e-14);
    CHECK(maxDifference(pose.worldFromNode[3], root) < 1e-15);
    // By hand: the point (1, 0, 0) of node 1 -> (2, 1, 0) -> a quarter turn (-1, 2, 0) -> (0, 4, 3).
    CHECK(glm::distance(DVec3(pose.worldFromNode[1] * glm::dvec4(1, 0, 0, 1)), DVec3(0, 4, 3)) < 1e-14);
    CHECK(pose.morphWeights[0].empty());
    CHECK(pose.morphWeights[3] == std::vector<float>{0.25F, 0.5F});
}

TEST_CASE("Channels replace the parts of a node that they name", "[animation]") {
    Rig rig;
    rig.nodes = {nodeOf(kNone), nodeOf(0), nodeOf(1)};
    rig.nodes[0].scale = {2, 2, 2};
    rig.nodes[1].translation = {1, 0, 0};
    rig.nodes[1].morphWeights = {1, 0};
    rig.nodes[2].matrix = translation({0, 0, 5});
    Clip clip;
    clip.channels.push_back(channelOf(ChannelPath::Translation, Interpolation::Linear, {0, 2}, {0, 0, 0, 4, 0, 0}));
    clip.channels.push_back(
        channelOf(ChannelPath::Rotation, Interpolation::Linear, {0, 1}, joined({turn({0, 0, 1}, 0), turn({0, 0, 1}, 1)})));
    clip.channels.push_back(channelOf(ChannelPath::Scale, Interpolation::Step, {0}, {3, 1, 1}));
    clip.channels[1].node = clip.channels[2].node = 1;
    Channel weights = channelOf(ChannelPath::Weights, Interpolation::Linear, {0, 1}, {0, 0, 1, 0.5F});
    weights.width = 2;
    weights.node = 1;
    clip.channels.push_back(weights);
    clip.channels.push_back(channelOf(ChannelPath::Translation, Interpolation::Step, {0}, {7, 7, 7}));
    clip.channels.back().node = 2; // has a matrix: not animated
    clip.channels.push_back(clip.channels.back());
    clip.channels.back().node = kNone;                                                           // targets nothing
    clip.channels.push_back(channelOf(ChannelPath::Translation, Interpolation::Linear, {}, {})); // no keys

    const Pose pose = evaluatePose(rig, &clip, 0.5);
    const DMat4 root = translation({1, 0, 0}) * scaling({2, 2, 2});
    const DMat4 child = root * translation({1, 0, 0}) * rotationZ(0.5) * scaling({3, 1, 1});
    CHECK(maxDifference(pose.worldFromNode[0], root) < 1e-15);
    CHECK(maxDifference(pose.worldFromNode[1], child) < 1e-6); // the keys are floats
    CHECK(maxDifference(pose.worldFromNode[2], child * translation({0, 0, 5})) < 1e-5);
    CHECK(pose.morphWeights[1] == std::vector<float>{0.5F, 0.25F});
    CHECK(evaluatePose(rig, nullptr, 0.5).morphWeights[1] == std::vector<float>{1, 0});
}

TEST_CASE("CUBICSPLINE morph weights take as many floats a key as there are morphs", "[animation]") {
    Channel channel = channelOf(ChannelPath::Weights, Interpolation::CubicSpline, {0, 1}, {9, 9, 0, 1, 0, 0, /**/ 0, 0, 1, 3, 9, 9});
    channel.width = 2;
    CHECK(evaluateChannel(channel, 0.5) == std::vector<float>{0.5F, 2});
    CHECK(maxDifference(evaluateChannel(channel, 0.25), {5.0F / 32, 1 + 2 * 5.0F / 32}) < 1e-7);
}

TEST_CASE("A constant scale is part of the rest pose, a moving one is not", "[animation]") {
    Rig rig;
    rig.nodes = {nodeOf(kNone)};
    rig.nodes[0].scale = {1, 1, 1};
    rig.nodes[0].translation = {5, 0, 0};
    rig.nodes[0].morphWeights = {0.5F};
    const auto restOf = [&](const Channel &channel) {
        Clip clip;
        clip.channels.push_back(channelOf(ChannelPath::Translation, Interpolation::Step, {0}, {9, 9, 9}));
        Channel weights = channelOf(ChannelPath::Weights, Interpolation::Step, {0}, {1});
        weights.width = 1;
        clip.channels.push_back(weights);
        clip.channels.push_back(channel);
        const Pose pose = restPose(rig, &clip);
        CHECK(pose.morphWeights[0] == std::vector<float>{0.5F});
        return pose.worldFromNode[0];
    };
    const DMat4 stored = translation({5, 0, 0});
    const DMat4 scaled = stored * scaling({2, 3, 4});
    CHECK(restPose(rig, nullptr).worldFromNode[0] == stored);
    CHECK(restOf(channelOf(ChannelPath::Scale, Interpolation::Linear, {1, 2}, {2, 3, 4, 2, 3, 4})) == scaled);
    CHECK(restOf(channelOf(ChannelPath::Scale, Interpolation::Step, {1}, {2, 3, 4})) == scaled);
    CHECK(restOf(channelOf(ChannelPath::Scale, Interpolation::Linear, {1, 2}, {2, 3, 4, 2, 3, 4.0000005F})) == stored);
    const std::vector<float> zero(3, 0.0F);
    const std::vector<float> value{2, 3, 4};
    CHECK(restOf(channelOf(ChannelPath::Scale, Interpolation::CubicSpline, {1, 2}, joined({zero, value, zero, zero, value, zero}))) ==
          scaled);
    CHECK(restOf(channelOf(ChannelPath::Scale, Interpolation::CubicSpline, {1, 2}, joined({zero, value, {0, 0, 1}, zero, value, zero}))) ==
          stored);
    CHECK(restOf(channelOf(ChannelPath::Rotation, Interpolation::Step, {1}, turn({0, 0, 1}, 1))) == stored);
    rig.nodes[0].matrix = stored;
    CHECK(restOf(channelOf(ChannelPath::Scale, Interpolation::Step, {1}, {2, 3, 4})) == stored);
}

TEST_CASE("A constant scale evaluates to itself exactly at any time", "[animation]") {
    const Channel channel = channelOf(ChannelPath::Scale, Interpolation::Linear, {0, 0.7F}, {0.1F, 0.3F, 1e-7F, 0.1F, 0.3F, 1e-7F});
    for (const double t : {0.0, 0.1, 0.33, 0.6999, 1.0}) CHECK(evaluateChannel(channel, t) == std::vector<float>{0.1F, 0.3F, 1e-7F});
}

TEST_CASE("Joint matrices take the bind pose to the joint's place", "[animation]") {
    Rig rig;
    rig.nodes = {nodeOf(kNone), nodeOf(0)};
    rig.nodes[0].translation = {0, 1, 0};
    rig.nodes[1].translation = {0, 2, 0};
    Skin skin;
    skin.joints = {1, 0};
    skin.inverseBindMatrix = {translation({0, -3, 0}), translation({0, -1, 0})};
    for (const DMat4 &matrix : jointMatrices(skin, evaluatePose(rig, nullptr, 0))) CHECK(matrix == DMat4(1));

    Clip clip; // the lower joint turns about itself: what hangs on the upper one turns with it about (0, 1, 0)
    clip.channels.push_back(channelOf(ChannelPath::Rotation, Interpolation::Step, {0}, turn({0, 0, 1}, kPiD / 2)));
    const std::vector<DMat4> turned = jointMatrices(skin, evaluatePose(rig, &clip, 0));
    REQUIRE(turned.size() == 2);
    const DMat4 about = translation({0, 1, 0}) * rotationZ(kPiD / 2) * translation({0, -1, 0});
    for (const DMat4 &matrix : turned) CHECK(maxDifference(matrix, about) < 1e-6);
    CHECK(glm::distance(DVec3(turned[0] * glm::dvec4(0, 3, 0, 1)), DVec3(-2, 1, 0)) < 1e-6);
}

TEST_CASE("The InterpolationTest asset moves by each rule", "[animation][asset]") {
    const auto path = test::asset("anim/khronos/InterpolationTest.glb");
    if (!path) return;
    Warnings warnings;
    const GltfFile file = readGltf(*path, warnings);
    REQUIRE(file.rig.clips.size() == 9);
    // worldFromNode of the node that the named clip moves; all of them are roots. The numbers are read off the file.
    const auto matrixAt = [&](const std::string &name, double seconds) {
        for (const Clip &clip : file.rig.clips)
            if (clip.name == name) {
                REQUIRE(clip.channels.size() == 1);
                return evaluatePose(file.rig, &clip, seconds).worldFromNode[clip.channels[0].node];
            }
        FAIL("no clip " << name);
        return DMat4(1);
    };
    const auto scaleAt = [&](const std::string &name, double t) { return glm::length(DVec3(matrixAt(name, t)[0])); };
    const auto angleAt = [&](const std::string &name, double t) {
        const DMat4 m = matrixAt(name, t);
        return std::atan2(m[0][1], m[0][0]) * 180 / kPiD;
    };
    const auto heightAt = [&](const std::string &name, double t) { return matrixAt(name, t)[3].y; };
    const auto near = [](double x) { return Approx(x).margin(2e-6); };
    CHECK(scaleAt("Step Scale", 0) == near(1));
    CHECK(scaleAt("Step Scale", 0.5) == near(0.5)); // keys at 1/24, 10/24, 21/24, 30/24, 40/24
    CHECK(scaleAt("Step Scale", 9) == near(1));
    CHECK(scaleAt("Linear Scale", 15.5 / 24) == near(0.75));
    CHECK(scaleAt("CubicSpline Scale", 15.5 / 24) == near(0.75)); // tangents zero: 3 u^2 - 2 u^3
    CHECK(scaleAt("CubicSpline Scale", 12.75 / 24) == near(0.5 + 0.5 * 5 / 32));
    CHECK(angleAt("Step Rotation", 0.5) == near(-45)); // keys at 0, 10/24, 21/24, 30/24, 41/24, 45 degrees apart
    CHECK(angleAt("Linear Rotation", 5.0 / 24) == near(-22.5));
    CHECK(angleAt("Linear Rotation", 35.5 / 24) == near(-157.5));
    // u = 1/2 of 10/24 s: (q0 + q1) / 2 + (10/24) (out0 - in1) / 8 in z and w, then the angle of that.
    const double z = 0.5 * (0 - 0.3826834559440613) + 10.0 / 24 * (0.0 + 0.04789090156555176) / 8;
    const double w = 0.5 * (1 + 0.9238795638084412) + 10.0 / 24 * (1.0 - 0.9988526701927185) / 8;
    CHECK(angleAt("CubicSpline Rotation", 5.0 / 24) == near(2 * std::atan2(z, w) * 180 / kPiD));
    CHECK(heightAt("Step Translation", 0.6) == near(10));
    CHECK(heightAt("Linear Translation", 15.0 / 24) == near(8)); // keys at 0, 10/24, 20/24 ...; 10 -> 6
    CHECK(heightAt("CubicSpline Translation", 12.5 / 24) == near(10 - 4.0 * 5 / 32));
}

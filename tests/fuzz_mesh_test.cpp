/// Every cut and many random changes of valid files: each loads as a valid mesh or throws InputError, and nothing else.
/// Meant to run under the sanitizers, too.

#include "mesh_samples.h"

#include <random>

using namespace taut;
using namespace taut::test;

namespace {

struct Sample {
    std::string name;
    std::string bytes;
    bool text;
};

std::string withCarriageReturns(std::string text) {
    std::replace(text.begin(), text.end(), '\n', '\r');
    return "\xef\xbb\xbf" + text;
}

/// Texture coordinates of corners, triangle strips, and lines that hold what they like.
std::string plyWedgeSample() {
    return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n"
           "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
           "0 0 0 1 0 0\n1 1 0\n0 1\n0\n3 0 1 2 6 0 0.5 1 0 1 1\n4 0 1 2 3 8 0 0 1 0 1 1 0 1\n7 0 1 3 2 -1 1 2\n";
}

std::vector<Sample> samples() {
    return {{"fuzz.obj", objSample(), true},
            {"fuzz.ply", plyAsciiSample(), true},
            {"fuzz_b.ply", plyBinarySample(false), false},
            {"fuzz_m.ply", plyBinarySample(true), false},
            {"fuzz_w.ply", plyWedgeSample(), true},
            {"fuzz_cr.obj", withCarriageReturns(objSample()), true},
            {"fuzz.off", offSample(), true},
            {"fuzz.stl", stlAsciiSample(), true},
            {"fuzz_b.stl", stlBinarySample(), false},
            {"fuzz.glb", gltfSample().glb(), false},
            {"fuzz.gltf", gltfSample().gltf(), true}};
}

/// How many of the changed files loaded and how many said what is wrong with them.
struct LoadTally {
    std::size_t loaded = 0;
    std::size_t rejected = 0;
};

/// Loads, or says what is wrong on one line: anything else fails the test (or stops it, under a sanitizer).
void mustLoadOrSay(const std::string &name, const std::string &bytes, LoadTally &tally) {
    std::string failure;
    try {
        const std::string error = errorOf(name, bytes);
        ++(error.empty() ? tally.loaded : tally.rejected);
        if (error.find('\n') != std::string::npos) failure = "more than one line: " + error;
    } catch (const std::exception &other) {
        failure = other.what();
    }
    if (failure.empty()) return;
    std::ofstream(outputFolder("mesh") + "/failed_" + name, std::ios::binary) << bytes;
    FAIL_CHECK(name << ": " << failure);
}

/// Every value of a JSON tree, the tree itself included.
void collectValues(nlohmann::json &value, std::vector<nlohmann::json *> &out) {
    out.push_back(&value);
    for (auto &member : value)
        if (value.is_structured()) collectValues(member, out);
}

} // namespace

TEST_CASE("The samples themselves load", "[mesh][malformed]") {
    for (const Sample &sample : samples()) CHECK(errorOf(sample.name, sample.bytes).empty());
}

TEST_CASE("A file cut anywhere loads or says why not", "[mesh][malformed][fuzz]") {
    for (const Sample &sample : samples()) {
        LoadTally tally;
        const std::size_t step = std::max<std::size_t>(1, sample.bytes.size() / 400);
        for (std::size_t length = 0; length < sample.bytes.size(); length += step) {
            std::string cut = sample.bytes.substr(0, length);
            mustLoadOrSay(sample.name, cut, tally);
            if (sample.name != "fuzz.glb" || length < 12) continue;
            // With the length in the header made right again, so that the cut is met further in.
            const auto whole = static_cast<std::uint32_t>(length);
            std::memcpy(cut.data() + 8, &whole, sizeof whole);
            mustLoadOrSay(sample.name, cut, tally);
        }
        CHECK(tally.rejected > 100);
    }
}

TEST_CASE("A file with flipped bits loads or says why not", "[mesh][malformed][fuzz]") {
    std::mt19937 random(20240229);
    for (const Sample &sample : samples()) {
        LoadTally tally;
        for (int i = 0; i < 400; ++i) {
            std::string bytes = sample.bytes;
            for (std::size_t flips = 1 + random() % 4; flips > 0; --flips)
                bytes[random() % bytes.size()] ^= static_cast<char>(1U << random() % 8);
            mustLoadOrSay(sample.name, bytes, tally);
        }
        CHECK(tally.loaded > 0);
        CHECK(tally.rejected > 0);
    }
}

TEST_CASE("A text with other numbers loads or says why not", "[mesh][malformed][fuzz]") {
    constexpr const char *kNumbers[] = {"0",    "-1",     "1",   "2",   "255", "65536", "2147483647", "4294967295", "18446744073709551615",
                                        "1e38", "-1e300", "0.5", "nan", "7"};
    std::mt19937 random(20240301);
    for (const Sample &sample : samples()) {
        if (!sample.text && sample.name != "fuzz.glb") continue;
        LoadTally tally;
        for (int i = 0; i < 500; ++i) {
            std::string bytes = sample.bytes;
            // The buffer's base64 in the .gltf is full of digits, too: those are data.
            const std::size_t end = std::min(bytes.size(), bytes.find("base64,"));
            for (std::size_t changes = 1 + random() % 2; changes > 0; --changes) {
                std::size_t at = random() % end;
                while (at < end && !(bytes[at] >= '0' && bytes[at] <= '9')) ++at;
                std::size_t length = 0;
                while (at + length < end && bytes[at + length] >= '0' && bytes[at + length] <= '9') ++length;
                if (length != 0) bytes.replace(at, length, kNumbers[random() % std::size(kNumbers)]);
            }
            mustLoadOrSay(sample.name, bytes, tally);
        }
        CHECK(tally.loaded > 0);
        CHECK(tally.rejected > 0);
    }
}

TEST_CASE("A binary file with other words loads or says why not", "[mesh][malformed][fuzz]") {
    constexpr std::uint32_t kWords[] = {0, 1, 2, 3, 255, 0x7fffffff, 0x80000000, 0xffffffff, 0x7f800000, 0x7fc00000, 0x3f800000, 50};
    std::mt19937 random(20240302);
    for (const Sample &sample : samples()) {
        if (sample.text) continue;
        LoadTally tally;
        for (int i = 0; i < 400; ++i) {
            std::string bytes = sample.bytes;
            const std::uint32_t word = kWords[random() % std::size(kWords)];
            std::memcpy(bytes.data() + random() % (bytes.size() - 4), &word, sizeof word);
            mustLoadOrSay(sample.name, bytes, tally);
        }
        CHECK(tally.loaded > 0);
        CHECK(tally.rejected > 0);
    }
}

TEST_CASE("A glTF with members of other types and values loads or says why not", "[mesh][malformed][gltf][fuzz]") {
    const nlohmann::json others[] = {nullptr,
                                     true,
                                     0,
                                     1,
                                     5,
                                     -1,
                                     2147483647,
                                     4294967296,
                                     0.5,
                                     1e300,
                                     "",
                                     "VEC3",
                                     nlohmann::json::array(),
                                     nlohmann::json::array({1}),
                                     nlohmann::json::object(),
                                     {{"index", 0}}};
    std::mt19937 random(20240303);
    LoadTally tally;
    for (int i = 0; i < 2500; ++i) {
        GltfBuilder b = gltfSample();
        for (std::size_t changes = 1 + random() % 2; changes > 0; --changes) {
            std::vector<nlohmann::json *> values;
            collectValues(b.json, values);
            nlohmann::json *const changed = values[1 + random() % (values.size() - 1)];
            // Another value of the file often has the right type and the wrong meaning.
            if (random() % 2 == 0)
                *changed = others[random() % std::size(others)];
            else
                *changed = nlohmann::json(*values[1 + random() % (values.size() - 1)]);
        }
        mustLoadOrSay("fuzz.gltf", b.gltf(), tally);
    }
    CHECK(tally.loaded > 0);
    CHECK(tally.rejected > 0);
}

#pragma once
/// A second evaluation of glTF animation, for tests: straight from the JSON, in double, as plainly as the specification says it.
/// Shares no code with the library. It trusts the file, and knows neither CUBICSPLINE nor sparse accessors nor a second set of
/// joints: it throws where a file has them.

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

namespace taut::test {

class GltfReference {
  public:
    using Json = nlohmann::json;
    using Element = std::vector<double>; ///< components of one element of an accessor

    explicit GltfReference(const std::string &path) {
        std::ifstream file(path, std::ios::binary);
        const std::string bytes{std::istreambuf_iterator<char>(file), {}};
        std::string binary;
        if (bytes.compare(0, 4, "glTF") == 0) {
            const std::size_t length = word(bytes, 12);
            json_ = Json::parse(bytes.substr(20, length));
            if (bytes.size() > 20 + length) binary = bytes.substr(28 + length, word(bytes, 20 + length));
        } else {
            json_ = Json::parse(bytes);
        }
        for (const Json &buffer : json_.value("buffers", Json::array())) buffers_.push_back(bufferOf(buffer, path, binary));
        parents_.assign(nodes().size(), -1);
        for (std::size_t n = 0; n < nodes().size(); ++n)
            for (const int child : nodes()[n].value("children", std::vector<int>{}))
                parents_[static_cast<std::size_t>(child)] = static_cast<int>(n);
    }

    [[nodiscard]] const Json &nodes() const { return json_.at("nodes"); }

    /// Nodes with a mesh, in the order of the file.
    [[nodiscard]] std::vector<int> meshNodes() const {
        std::vector<int> found;
        for (std::size_t n = 0; n < nodes().size(); ++n)
            if (nodes()[n].contains("mesh")) found.push_back(static_cast<int>(n));
        return found;
    }
    [[nodiscard]] const Json &primitives(int node) const {
        return json_["meshes"][nodes()[at(node)]["mesh"].get<std::size_t>()]["primitives"];
    }

    /// Vertices of a primitive that a face uses.
    [[nodiscard]] std::vector<bool> usedVertices(const Json &primitive) const {
        const std::size_t count = json_["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()]["count"];
        if (!primitive.contains("indices")) return std::vector<bool>(count, true);
        std::vector<bool> used(count, false);
        for (const Element &index : accessor(primitive["indices"])) used[static_cast<std::size_t>(index[0])] = true;
        return used;
    }

    /// Positions of all vertices of a primitive in the space of the scene (y up) at a time of an animation; -1: no animation.
    [[nodiscard]] std::vector<glm::dvec3> positions(int node, const Json &primitive, int animation, double seconds) const {
        std::vector<Element> points = accessor(primitive["attributes"]["POSITION"]);
        const Element weights = morphWeights(node, animation, seconds);
        const Json targets = primitive.value("targets", Json::array());
        for (std::size_t t = 0; t < targets.size(); ++t) {
            if (!targets[t].contains("POSITION")) continue;
            const std::vector<Element> delta = accessor(targets[t]["POSITION"]);
            for (std::size_t v = 0; v < points.size(); ++v)
                for (std::size_t c = 0; c < 3; ++c) points[v][c] += weights[t] * delta[v][c];
        }
        std::vector<glm::dvec3> out;
        if (!nodes()[at(node)].contains("skin")) {
            const glm::dmat4 world = worldFromNode(node, animation, seconds);
            for (const Element &p : points) out.emplace_back(world * glm::dvec4(p[0], p[1], p[2], 1));
            return out;
        }
        // The transform of the node itself is ignored for a skinned mesh.
        if (primitive["attributes"].contains("JOINTS_1")) throw std::runtime_error("more than four joints a vertex");
        const std::vector<glm::dmat4> joints =
            jointMatrices(json_["skins"][nodes()[at(node)]["skin"].get<std::size_t>()], animation, seconds);
        const std::vector<Element> indices = accessor(primitive["attributes"]["JOINTS_0"]);
        const std::vector<Element> influence = accessor(primitive["attributes"]["WEIGHTS_0"]);
        for (std::size_t v = 0; v < points.size(); ++v) {
            glm::dvec4 sum(0);
            for (std::size_t k = 0; k < 4; ++k)
                sum += influence[v][k] *
                       (joints[static_cast<std::size_t>(indices[v][k])] * glm::dvec4(points[v][0], points[v][1], points[v][2], 1));
            out.emplace_back(sum);
        }
        return out;
    }

    /// Sums of the normals of the faces at each vertex of a primitive, at `points`.
    [[nodiscard]] std::vector<glm::dvec3> faceNormals(const Json &primitive, const std::vector<glm::dvec3> &points) const {
        std::vector<glm::dvec3> sums(points.size(), glm::dvec3(0));
        const std::vector<Element> indices = accessor(primitive["indices"]);
        for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
            const auto corner = [&](std::size_t k) { return static_cast<std::size_t>(indices[i + k][0]); };
            const glm::dvec3 n = glm::cross(points[corner(1)] - points[corner(0)], points[corner(2)] - points[corner(0)]);
            for (std::size_t k = 0; k < 3; ++k) sums[corner(k)] += n;
        }
        return sums;
    }

    /// Unit normals of all vertices of a primitive of a node without a skin, in the space of the scene; empty where it has none.
    [[nodiscard]] std::vector<glm::dvec3> normals(int node, const Json &primitive, int animation, double seconds) const {
        if (!primitive["attributes"].contains("NORMAL")) return {};
        if (nodes()[at(node)].contains("skin")) throw std::runtime_error("normals of a skinned mesh");
        std::vector<Element> sums = accessor(primitive["attributes"]["NORMAL"]);
        const Element weights = morphWeights(node, animation, seconds);
        const Json targets = primitive.value("targets", Json::array());
        for (std::size_t t = 0; t < targets.size(); ++t) {
            if (!targets[t].contains("NORMAL")) continue;
            const std::vector<Element> delta = accessor(targets[t]["NORMAL"]);
            for (std::size_t v = 0; v < sums.size(); ++v)
                for (std::size_t c = 0; c < 3; ++c) sums[v][c] += weights[t] * delta[v][c];
        }
        const glm::dmat3 covectors = glm::transpose(glm::inverse(glm::dmat3(worldFromNode(node, animation, seconds))));
        std::vector<glm::dvec3> out;
        for (const Element &n : sums) out.push_back(glm::normalize(covectors * glm::normalize(glm::dvec3(n[0], n[1], n[2]))));
        return out;
    }

  private:
    static std::size_t at(int index) { return static_cast<std::size_t>(index); }

    static std::uint32_t word(const std::string &bytes, std::size_t offset) {
        std::uint32_t value = 0;
        std::memcpy(&value, &bytes.at(offset), sizeof(value));
        return value;
    }

    static std::string fromBase64(const std::string &text) {
        const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        std::string bytes;
        unsigned bits = 0;
        int count = 0;
        for (const char c : text) {
            const std::size_t digit = digits.find(c);
            if (digit == std::string::npos) break; // '='
            bits = bits << 6 | static_cast<unsigned>(digit);
            count += 6;
            if (count < 8) continue;
            count -= 8;
            bytes += static_cast<char>(bits >> count & 255);
        }
        return bytes;
    }

    static std::string bufferOf(const Json &buffer, const std::string &path, const std::string &binary) {
        if (!buffer.contains("uri")) return binary;
        const std::string uri = buffer["uri"];
        if (uri.compare(0, 5, "data:") == 0) return fromBase64(uri.substr(uri.find(',') + 1));
        std::ifstream file(path.substr(0, path.rfind('/') + 1) + uri, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }

    /// One component; normalised integers as the specification's table says.
    static double component(const std::string &bytes, std::size_t offset, int type, bool normalized) {
        const auto read = [&](auto value) {
            std::memcpy(&value, &bytes.at(offset + sizeof(value) - 1) - (sizeof(value) - 1), sizeof(value));
            return static_cast<double>(value);
        };
        switch (type) {
        case 5120: return normalized ? std::max(read(std::int8_t{}) / 127, -1.0) : read(std::int8_t{});
        case 5121: return read(std::uint8_t{}) / (normalized ? 255 : 1);
        case 5122: return normalized ? std::max(read(std::int16_t{}) / 32767, -1.0) : read(std::int16_t{});
        case 5123: return read(std::uint16_t{}) / (normalized ? 65535 : 1);
        case 5125: return read(std::uint32_t{});
        case 5126: return read(float{});
        default: throw std::runtime_error("unknown component type");
        }
    }

    [[nodiscard]] std::vector<Element> accessor(std::size_t index) const {
        const Json &a = json_["accessors"][index];
        if (a.contains("sparse")) throw std::runtime_error("a sparse accessor");
        const Json &view = json_["bufferViews"][a["bufferView"].get<std::size_t>()];
        const std::string type = a["type"];
        const std::size_t width = type == "SCALAR" ? 1 : type == "MAT4" ? 16 : static_cast<std::size_t>(type.back() - '0');
        const int componentType = a["componentType"];
        const std::size_t size = componentType <= 5121 ? 1 : componentType <= 5123 ? 2 : 4;
        const std::size_t stride = view.value("byteStride", size * width);
        const std::size_t start = view.value("byteOffset", std::size_t{0}) + a.value("byteOffset", std::size_t{0});
        std::vector<Element> elements(a["count"].get<std::size_t>(), Element(width));
        for (std::size_t i = 0; i < elements.size(); ++i)
            for (std::size_t c = 0; c < width; ++c)
                elements[i][c] = component(buffers_[view["buffer"].get<std::size_t>()], start + i * stride + c * size, componentType,
                                           a.value("normalized", false));
        return elements;
    }

    static Element unit(Element q) {
        const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        for (double &c : q) c /= length;
        return q;
    }

    /// Spherical linear interpolation, appendix C.4 of the specification, which is for unit quaternions: files round theirs
    /// (SimpleSkin's have three digits).
    static Element slerp(const Element &from, const Element &to, double t) {
        const Element a = unit(from);
        const Element b = unit(to);
        double dot = 0;
        for (std::size_t c = 0; c < 4; ++c) dot += a[c] * b[c];
        const double sign = dot < 0 ? -1 : 1;
        const double angle = std::acos(std::min(1.0, std::fabs(dot)));
        const double shareOfA = angle > 1e-9 ? std::sin(angle * (1 - t)) / std::sin(angle) : 1 - t;
        const double shareOfB = sign * (angle > 1e-9 ? std::sin(angle * t) / std::sin(angle) : t);
        Element out(4);
        for (std::size_t c = 0; c < 4; ++c) out[c] = shareOfA * a[c] + shareOfB * b[c];
        return out;
    }

    /// Value of the channel that drives a property of a node: `width` numbers; `fallback` where none does.
    [[nodiscard]] Element animated(int node, const std::string &property, int animation, double seconds, const Element &fallback) const {
        if (animation < 0) return fallback;
        const Json &clip = json_["animations"][at(animation)];
        for (const Json &channel : clip["channels"]) {
            if (channel["target"].value("node", -1) != node || channel["target"]["path"] != property) continue;
            const Json &sampler = clip["samplers"][channel["sampler"].get<std::size_t>()];
            const std::string mode = sampler.value("interpolation", "LINEAR");
            if (mode == "CUBICSPLINE") throw std::runtime_error("CUBICSPLINE");
            const std::vector<Element> times = accessor(sampler["input"]);
            const std::vector<Element> values = accessor(sampler["output"]);
            const std::size_t width = fallback.size(); // the elements of an array of weights are scalars
            const auto valueOf = [&](std::size_t key) {
                Element value;
                for (std::size_t e = key * values.size() / times.size(); e < (key + 1) * values.size() / times.size(); ++e)
                    value.insert(value.end(), values[e].begin(), values[e].end());
                if (value.size() != width) throw std::runtime_error("a key of the wrong width");
                return value;
            };
            std::size_t next = 0;
            while (next < times.size() && times[next][0] <= seconds) ++next;
            if (next == 0) return valueOf(0);
            if (next == times.size() || mode == "STEP") return valueOf(next - 1);
            const double t = (seconds - times[next - 1][0]) / (times[next][0] - times[next - 1][0]);
            const Element a = valueOf(next - 1);
            const Element b = valueOf(next);
            if (property == "rotation") return slerp(a, b, t);
            Element out(width);
            for (std::size_t c = 0; c < width; ++c) out[c] = (1 - t) * a[c] + t * b[c];
            return out;
        }
        return fallback;
    }

    [[nodiscard]] Element morphWeights(int node, int animation, double seconds) const {
        const Json &mesh = json_["meshes"][nodes()[at(node)]["mesh"].get<std::size_t>()];
        const std::size_t count = mesh["primitives"][0].value("targets", Json::array()).size();
        const Element own = mesh.value("weights", Element(count, 0.0));
        return animated(node, "weights", animation, seconds, nodes()[at(node)].value("weights", own));
    }

    [[nodiscard]] glm::dmat4 localTransform(int index, int animation, double seconds) const {
        const Json &node = nodes()[at(index)];
        if (node.contains("matrix")) {
            glm::dmat4 m;
            for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = node["matrix"][at(i)];
            return m;
        }
        const Element t = animated(index, "translation", animation, seconds, node.value("translation", Element{0, 0, 0}));
        const Element s = animated(index, "scale", animation, seconds, node.value("scale", Element{1, 1, 1}));
        const Element q = unit(animated(index, "rotation", animation, seconds, node.value("rotation", Element{0, 0, 0, 1})));
        const double x = q[0], y = q[1], z = q[2], w = q[3];
        const glm::dvec3 right(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y));
        const glm::dvec3 up(2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x));
        const glm::dvec3 back(2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y));
        return {glm::dvec4(right * s[0], 0), glm::dvec4(up * s[1], 0), glm::dvec4(back * s[2], 0), glm::dvec4(t[0], t[1], t[2], 1)};
    }

    [[nodiscard]] glm::dmat4 worldFromNode(int node, int animation, double seconds) const {
        const glm::dmat4 local = localTransform(node, animation, seconds);
        const int parent = parents_[at(node)];
        return parent < 0 ? local : worldFromNode(parent, animation, seconds) * local;
    }

    [[nodiscard]] std::vector<glm::dmat4> jointMatrices(const Json &skin, int animation, double seconds) const {
        const std::vector<int> joints = skin["joints"];
        std::vector<Element> inverseBind;
        if (skin.contains("inverseBindMatrices")) inverseBind = accessor(skin["inverseBindMatrices"]);
        std::vector<glm::dmat4> matrices;
        for (std::size_t j = 0; j < joints.size(); ++j) {
            glm::dmat4 bind(1);
            for (int i = 0; i < 16 && !inverseBind.empty(); ++i) bind[i / 4][i % 4] = inverseBind[j][at(i)];
            matrices.push_back(worldFromNode(joints[j], animation, seconds) * bind);
        }
        return matrices;
    }

    Json json_;
    std::vector<std::string> buffers_;
    std::vector<int> parents_;
};

} // namespace taut::test

#include "taut/formats/gltf_value.h"

#include "taut/formats/gltf_source.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>

namespace taut {

namespace {

using nlohmann::json;

/// Deeper nesting than any real file has; checks and the JSON library recurse.
constexpr int kDeepestJson = 96;

/// Where the token begins that ends before `end`: the JSON library says only where it stopped.
std::size_t lastTokenBegin(std::string_view text, std::size_t end) {
    constexpr std::string_view kStructural = "{}[]:,";
    if (end == 0) return 0;
    std::size_t begin = end - 1;
    if (kStructural.find(text[begin]) != std::string_view::npos) return begin;
    if (text[begin] == '"') {
        while (begin > 0 && text[begin - 1] != '"' && text[begin - 1] != '\n') --begin;
        return begin > 0 ? begin - 1 : 0;
    }
    while (begin > 0 && !std::isspace(static_cast<unsigned char>(text[begin - 1])) &&
           kStructural.find(text[begin - 1]) == std::string_view::npos)
        --begin;
    return begin;
}

} // namespace

std::shared_ptr<const json> parseGltfJson(std::string_view text, const std::string &path,
                                          const std::function<Location(std::size_t)> &locate) {
    try {
        const auto limitDepth = [&](int depth, json::parse_event_t, json &) {
            if (depth > kDeepestJson)
                failGltf(path, "the JSON", "members nested deeper than " + std::to_string(kDeepestJson) + " levels", "fewer levels");
            return true;
        };
        return std::make_shared<const json>(json::parse(text.begin(), text.end(), limitDepth));
    } catch (const json::parse_error &error) {
        // "[json.exception...] parse error at line 1, column 5: syntax error while parsing value - ...; last read: '...'"
        std::string reason = error.what();
        reason = reason.substr(std::min(reason.find(": ") + 2, reason.size()));
        reason = reason.substr(0, reason.find("; last read"));
        const std::size_t end = std::min(error.byte, text.size());
        const std::size_t begin = error.byte > end ? end : lastTokenBegin(text, end);
        const std::string_view token = text.substr(begin, end - begin);
        failInput(locate(begin), token.empty() ? "the end of the JSON" : taut::quoted(token), "valid JSON (" + reason.substr(0, 200) + ")");
    } catch (const json::exception &error) {
        failGltf(path, "the JSON", std::string(error.what()).substr(0, 200), "valid JSON");
    }
}

bool GltfValue::has(std::string_view key) const {
    return (*this)[key].present();
}

GltfValue GltfValue::operator[](std::string_view key) const {
    const nlohmann::json *found = nullptr;
    if (isObject())
        if (const auto member = value_->find(std::string(key)); member != value_->end()) found = &*member;
    return {*file_, found, path_.empty() ? std::string(key) : path_ + "." + std::string(key)};
}

GltfValue GltfValue::operator[](std::size_t index) const {
    return {*file_, index < size() ? &(*value_)[index] : nullptr, jsonPath(path_, index)};
}

std::size_t GltfValue::size() const {
    return present() && value_->is_array() ? value_->size() : 0;
}

bool GltfValue::isObject() const {
    return present() && value_->is_object();
}

long long GltfValue::integer(long long otherwise) const {
    return present() && value_->is_number_integer() ? value_->get<long long>() : otherwise;
}

double GltfValue::number(double otherwise) const {
    return present() && value_->is_number() ? value_->get<double>() : otherwise;
}

std::vector<double> GltfValue::numbers() const {
    std::vector<double> result;
    for (std::size_t i = 0; i < size(); ++i) result.push_back((*value_)[i].is_number() ? (*value_)[i].get<double>() : 0);
    return result;
}

const std::string &GltfValue::text() const {
    static const std::string kEmpty;
    return present() && value_->is_string() ? value_->get_ref<const std::string &>() : kEmpty;
}

bool GltfValue::isTrue() const {
    return present() && value_->is_boolean() && value_->get<bool>();
}

std::vector<std::string> GltfValue::keys() const {
    std::vector<std::string> keys;
    if (isObject())
        for (const auto &member : value_->items()) keys.push_back(member.key());
    return keys;
}

std::string GltfValue::dump() const {
    return present() ? value_->dump(-1, ' ', false, json::error_handler_t::replace) : "";
}

Index GltfValue::index(std::size_t count, std::string_view what) const {
    const long long value = integer(-1);
    if (value < 0 || static_cast<unsigned long long>(value) >= count)
        fail(std::to_string(value), count == 0 ? "none, for the file has no " + std::string(what) : "0 to " + std::to_string(count - 1));
    return static_cast<Index>(value);
}

std::size_t GltfValue::choice(std::span<const std::string_view> valid) const {
    const auto found = std::find(valid.begin(), valid.end(), text());
    if (found == valid.end()) failUnknownName({place(), 0, 0, -1}, text(), valid);
    return static_cast<std::size_t>(found - valid.begin());
}

std::string GltfValue::nameOr(std::string_view kind, std::size_t number) const {
    const std::string name = (*this)["name"].text();
    return name.empty() ? std::string(kind) + std::to_string(number) : name;
}

void GltfValue::fail(std::string_view found, std::string_view expected) const {
    failGltf(*file_, path_, found, expected);
}

void failGltf(const std::string &file, std::string_view where, std::string_view found, std::string_view expected) {
    failInput({file + ": " + std::string(where), 0, 0, -1}, found, expected);
}

std::string jsonPath(std::string_view name, std::size_t index) {
    return std::string(name) + "[" + std::to_string(index) + "]";
}

} // namespace taut

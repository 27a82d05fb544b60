#pragma once
/// A value of a glTF file's JSON that knows its place, so that every error names the file and the JSON path
/// (`meshes[0].primitives[1].indices`).

#include "taut/base/error.h"
#include "taut/base/vec.h"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace taut {

/// Refers to the file's path and to its JSON, which live longer. A value that is absent, or of another type than the question
/// asks for, answers with the default: nothing here throws but fail() and what says so. What the file has is of the right type
/// wherever a reader looks (checkGltfJson).
class GltfValue {
  public:
    GltfValue(const std::string &file, const nlohmann::json *value, std::string path = {})
        : file_(&file), value_(value), path_(std::move(path)) {}

    [[nodiscard]] bool has(std::string_view key) const;
    /// A member or an element, which may be absent.
    GltfValue operator[](std::string_view key) const;
    GltfValue operator[](std::size_t index) const;
    /// The number of elements of an array.
    [[nodiscard]] std::size_t size() const;

    [[nodiscard]] bool present() const { return value_ != nullptr; }
    [[nodiscard]] bool isObject() const;
    [[nodiscard]] long long integer(long long otherwise) const;
    [[nodiscard]] double number(double otherwise) const;
    [[nodiscard]] std::vector<double> numbers() const;
    [[nodiscard]] const std::string &text() const; ///< else empty
    [[nodiscard]] bool isTrue() const;
    [[nodiscard]] std::vector<std::string> keys() const; ///< of an object's members
    [[nodiscard]] std::string dump() const;              ///< the JSON, the same for the same value

    /// The value as one of `count` elements called `what`; throws InputError where it is none.
    [[nodiscard]] Index index(std::size_t count, std::string_view what) const;
    /// The number of the text in `valid`; throws InputError where it is none of them.
    [[nodiscard]] std::size_t choice(std::span<const std::string_view> valid) const;
    /// Member "name" of the value, else `kind` and a number ("mesh0").
    [[nodiscard]] std::string nameOr(std::string_view kind, std::size_t number) const;

    /// "FILE: PATH", with which errors and warnings begin.
    [[nodiscard]] std::string place() const { return *file_ + ": " + path_; }
    [[noreturn]] void fail(std::string_view found, std::string_view expected) const;
    [[nodiscard]] const std::string &path() const { return path_; }

  private:
    const std::string *file_;
    const nlohmann::json *value_;
    std::string path_;
};

/// Throws InputError("FILE: WHERE: found FOUND, expected EXPECTED").
[[noreturn]] void failGltf(const std::string &file, std::string_view where, std::string_view found, std::string_view expected);

/// "name[index]", the JSON path of an element.
std::string jsonPath(std::string_view name, std::size_t index);

} // namespace taut

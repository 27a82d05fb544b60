#pragma once
/// Vector and matrix names used throughout: GLM types, column-major, column vectors (`M * v`).
/// Inside the library lengths are metres, times seconds, angles radians.

#define GLM_FORCE_SILENT_WARNINGS
#define GLM_ENABLE_EXPERIMENTAL
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace taut {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Vec4 = glm::vec4;
using Mat2 = glm::mat2;
using Mat3 = glm::mat3;
using Mat4 = glm::mat4;
using Quat = glm::quat;
using DVec2 = glm::dvec2;
using DVec3 = glm::dvec3;
using DMat3 = glm::dmat3;
using DMat4 = glm::dmat4;
using DQuat = glm::dquat;
/// Vectors of any real type, for code that is instantiated in float, double and long double.
template <class T> using Vector2 = glm::vec<2, T, glm::defaultp>;
template <class T> using Vector3 = glm::vec<3, T, glm::defaultp>;
using Index = std::uint32_t;
using Index3 = glm::u32vec3;

inline constexpr float kPi = 3.14159265358979323846F;
inline constexpr float kInvPi = 0.31830988618379067154F;
inline constexpr float kInfinity = INFINITY;
/// Largest float below one: the upper end of every canonical random number.
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1F;
/// "No such element" in index arrays.
inline constexpr Index kNone = 0xffffffffU;

template <class T> constexpr T sqr(T x) {
    return x * x;
}
inline float luminance(const Vec3 &rgb) {
    return 0.2126F * rgb.r + 0.7152F * rgb.g + 0.0722F * rgb.b;
}
inline float maxComponent(const Vec3 &v) {
    return std::max(v.x, std::max(v.y, v.z));
}
inline bool isFinite(const Vec3 &v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline double radians(double degrees) {
    return degrees * 0.017453292519943295769;
}

} // namespace taut

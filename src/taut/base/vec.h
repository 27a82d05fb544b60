#pragma once
/// Vector and matrix names used throughout: GLM types, column-major, column vectors (`M * v`).
/// Inside the library lengths are metres, times seconds, angles radians.

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace taut {

// Named by what they are, not by GLM's short names, which GLM_FORCE_... macros of a program that includes us may turn into others.
/// Vectors of any real type, for code that is instantiated in float, double and long double.
template <class T> using Vector2 = glm::vec<2, T, glm::packed_highp>;
template <class T> using Vector3 = glm::vec<3, T, glm::packed_highp>;
template <class T> using Vector4 = glm::vec<4, T, glm::packed_highp>;
template <int Columns, int Rows, class T> using Matrix = glm::mat<Columns, Rows, T, glm::packed_highp>;
using Vec2 = Vector2<float>;
using Vec3 = Vector3<float>;
using Vec4 = Vector4<float>;
using Mat2 = Matrix<2, 2, float>;
using Mat3 = Matrix<3, 3, float>;
using Mat4 = Matrix<4, 4, float>;
using Quat = glm::qua<float, glm::packed_highp>;
using DVec2 = Vector2<double>;
using DVec3 = Vector3<double>;
using DVec4 = Vector4<double>;
using DMat3 = Matrix<3, 3, double>;
using DMat4 = Matrix<4, 4, double>;
using DQuat = glm::qua<double, glm::packed_highp>;
using Index = std::uint32_t;
using Index3 = Vector3<std::uint32_t>;

inline constexpr float kPi = 3.14159265358979323846F;
inline constexpr double kTwoPi = 6.28318530717958647693;
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

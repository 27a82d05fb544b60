/// Includes every header that is installed, uses a little of the library and checks what comes back: the microsurface (headers
/// only), a mesh reader and a deformer (compiled). Prints one line and returns 0 where all is right.

#include "all_headers.h" // written by install_test.cmake

#include <cmath>
#include <fstream>
#include <iostream>

namespace {

bool isNear(double a, double b) {
    return std::fabs(a - b) <= 1e-5 * std::fabs(b);
}

/// D at the normal of a surface with alpha 0.1 and 0.4 is 1 / (pi alpha_x alpha_y).
bool isMicrosurfaceRight() {
    const taut::MicroTransform m = taut::microTransformFromAlpha(0.1F, 0.4F);
    return isNear(taut::ggx::distribution(m, taut::Vec3(0, 0, 1)), 1 / (3.14159265358979 * 0.1 * 0.4));
}

bool isMeshRight(const std::string &path) {
    std::ofstream(path) << "v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\nf 1 2 3 4\n";
    taut::Warnings warnings;
    const taut::Mesh mesh = taut::readMesh(path, warnings);
    return mesh.positions.size() == 4 && mesh.faceCount() == 1 && isNear(taut::boundsOf(mesh.positions).upper.y, 3);
}

/// A shear of 0.5: x is displaced by half of y.
bool isDeformerRight() {
    taut::DeformerKeys keys;
    keys.type = taut::DeformerType::Shear;
    keys.axis = 0;
    keys.axis2 = 1;
    keys.amount = taut::Keyed<double>(0.5);
    const taut::DeformedPoint image = taut::deform(taut::deformerAtFrame(keys, 1), taut::DVec3(1, 2, 3));
    return isNear(image.position.x, 2) && isNear(image.position.y, 2) && isNear(image.position.z, 3) && isNear(image.jacobian[1].x, 0.5);
}

} // namespace

int main(int, char **argv) {
    const bool right = isMicrosurfaceRight() && isMeshRight(std::string(argv[0]) + ".obj") && isDeformerRight();
    std::cout << (right ? "consumer: all right" : "consumer: WRONG") << std::endl;
    return right ? 0 : 1;
}

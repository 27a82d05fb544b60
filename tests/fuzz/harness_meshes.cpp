/// The readers of meshes, by way of a file.

#include "harness.h"
#include "harness_list.h"

#include "mesh_samples.h"

#include "taut/mesh/topology.h"

namespace taut::fuzz {

namespace {

/// A mesh that was read can be asked for its topology.
void readMeshFile(const std::string &name, std::string_view bytes) {
    survive([&] {
        Warnings warnings;
        const Mesh mesh = readMesh(scratchFile(name, bytes), warnings);
        test::requireValid(mesh);
        static_cast<void>(topologyOf(mesh, true));
    });
}

} // namespace

void runObj(std::string_view bytes) {
    readMeshFile("fuzz.obj", bytes);
}
void runPly(std::string_view bytes) {
    readMeshFile("fuzz.ply", bytes);
}
void runOff(std::string_view bytes) {
    readMeshFile("fuzz.off", bytes);
}
void runStl(std::string_view bytes) {
    readMeshFile("fuzz.stl", bytes);
}

std::vector<std::string> objSeeds() {
    return {test::objSample(), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nf 1 2 3 4\n", "\xef\xbb\xbfv 0 0 0\rv 1 0 0\rv 0 1 0\rf -1 -2 -3\r"};
}
std::vector<std::string> plySeeds() {
    return {test::plyAsciiSample(), test::plyBinarySample(false), test::plyBinarySample(true),
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n"
            "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
            "0 0 0 1 0 0\n1 1 0\n0 1\n0\n3 0 1 2 6 0 0.5 1 0 1 1\n4 0 1 2 3 8 0 0 1 0 1 1 0 1\n7 0 1 3 2 -1 1 2\n"};
}
std::vector<std::string> offSeeds() {
    return {test::offSample(), "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"};
}
std::vector<std::string> stlSeeds() {
    return {test::stlAsciiSample(), test::stlBinarySample()};
}

} // namespace taut::fuzz

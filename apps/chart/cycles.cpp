#include "chart/cycles.h"

#include "taut/base/error.h"
#include "taut/mesh/write_gloss.h"
#include "taut/render/image_file.h"
#include "taut/scene/gloss_export.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <sstream>

namespace taut::chart {

namespace {

namespace fs = std::filesystem;

const fs::path kScript = fs::path(TAUT_BLENDER_FOLDER) / "time_export.py";

/// In single quotes, for a shell.
std::string quotedForShell(const std::string &text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

std::string triple(const DVec3 &v) {
    std::ostringstream text;
    text.precision(9);
    text << "[" << v.x << ", " << v.y << ", " << v.z << "]";
    return text.str();
}

/// What render_export.py reads of a scene file.
std::string describe(const Scene &scene, double frame) {
    std::ostringstream text;
    text.precision(9);
    text << "[render]\nwidth = " << scene.render.width << "\nheight = " << scene.render.height
         << "\nmax_events = " << scene.render.maxEvents << "\n\n[camera]\nposition = " << triple(scene.camera.position.at(frame))
         << "\nlook_at = " << triple(scene.camera.lookAt.at(frame)) << "\nup = " << triple(scene.camera.up.at(frame))
         << "\nfov_deg = " << scene.camera.fovY.at(frame) * 180 / 3.14159265358979324 << "\n";
    if (scene.environment) text << "\n[environment]\nradiance = " << triple(DVec3(scene.environment->mean)) << "\n";
    for (const Light &light : scene.lights)
        text << "\n[[light]]\ntype = \"quad\"\ncorner = " << triple(light.corner) << "\nu = " << triple(light.u)
             << "\nv = " << triple(light.v) << "\nradiance = " << triple(DVec3(light.radiance)) << "\n";
    return text.str();
}

std::vector<float> readColours(const fs::path &file) {
    const Image image = readImage(file.string());
    const std::size_t stride = image.channels.size();
    std::array<std::size_t, 3> at{};
    for (std::size_t c = 0; c < 3; ++c) {
        const auto found = std::find(image.channels.begin(), image.channels.end(), std::string(1, "RGB"[c]));
        if (found == image.channels.end()) throw RunError(file.string() + ": Blender wrote no channel R, G or B");
        at[c] = static_cast<std::size_t>(found - image.channels.begin());
    }
    std::vector<float> values(image.values.size() / stride * 4, 1.0F);
    for (std::size_t i = 0; i < values.size() / 4; ++i)
        for (std::size_t c = 0; c < 3; ++c) values[4 * i + c] = image.values[stride * i + at[c]];
    return values;
}

} // namespace

std::string whyNoCycles() {
    if (std::system("blender --version > /dev/null 2>&1") != 0) return "Blender is not installed";
    std::error_code error;
    if (!fs::exists(kScript, error)) return "apps/blender is not where it was when this was built";
    return "";
}

CyclesRenders renderWithCycles(const Scene &scene, double frame, const std::vector<int> &spp, int rounds, const fs::path &folder) {
    fs::create_directories(folder);
    const fs::path description = folder / "scene.toml";
    writeTextFile(description.string(), describe(scene, frame));
    std::string numbers;
    for (const int n : spp) numbers += (numbers.empty() ? "" : ",") + std::to_string(n);
    std::string command = "blender -b -noaudio --factory-startup --python-exit-code 1 --python " + quotedForShell(kScript.string()) +
                          " -- " + quotedForShell(description.string()) + " " + std::to_string(static_cast<int>(frame)) + " " + numbers +
                          " " + std::to_string(rounds) + " " + quotedForShell(folder.string());
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        GlossObject object;
        prepareGlossObject(scene, scene.objects[i], object);
        glossAtFrame(scene, frame, {}, object);
        const fs::path file = folder / ("object" + std::to_string(i) + ".npz");
        writeGlossNpz(file.string(), object.mesh);
        command += " " + quotedForShell(file.string());
    }
    std::FILE *pipe = popen((command + " 2>&1").c_str(), "r");
    if (pipe == nullptr) throw RunError("can't start Blender");
    CyclesRenders renders;
    std::string log;
    std::array<char, 4096> line;
    while (std::fgets(line.data(), static_cast<int>(line.size()), pipe) != nullptr) {
        int samples = 0;
        int round = 0;
        double seconds = 0;
        if (std::sscanf(line.data(), "cycles %d %d %lf", &samples, &round, &seconds) == 3) {
            const fs::path file = folder / (std::to_string(samples) + "-" + std::to_string(round) + ".exr");
            renders.bySamples[samples].push_back({readColours(file), seconds});
        }
        log += line.data();
    }
    if (pclose(pipe) != 0) {
        const fs::path file = folder / "blender.log";
        writeTextFile(file.string(), log);
        throw RunError("Blender failed; what it said is in " + file.string());
    }
    return renders;
}

} // namespace taut::chart

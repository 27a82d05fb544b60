#include "harness.h"

#include "harness_list.h"

#include "taut/base/error.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace taut::fuzz {

namespace fs = std::filesystem;

std::span<const Harness> harnesses() {
    static const std::array kAll{
        Harness{"obj", runObj, objSeeds},
        Harness{"ply", runPly, plySeeds},
        Harness{"off", runOff, offSeeds},
        Harness{"stl", runStl, stlSeeds},
        Harness{"gltf", runGltf, gltfSeeds, Grammar::Json},
        Harness{"glb", runGlb, glbSeeds, Grammar::Glb},
        Harness{"pc2", runPc2, pc2Seeds},
        Harness{"mdd", runMdd, mddSeeds},
        Harness{"frames", runFrames, frameSeeds},
        Harness{"toml", runToml, tomlSeeds, Grammar::Toml},
        Harness{"scene", runScene, sceneSeeds, Grammar::Toml},
        Harness{"film", runFilm, filmSeeds},
        Harness{"restore", runRestore, restoreSeeds},
        Harness{"saved", runSaved, savedSeeds},
        Harness{"image", runImage, imageSeeds},
        Harness{"png", runImage, pngSeeds, Grammar::Png},
        Harness{"environment", runEnvironment, environmentSeeds},
        Harness{"ocio", runOcio, ocioSeeds},
        Harness{"writers", runWriters, writerSeeds, Grammar::Toml},
        Harness{"http", runHttp, httpSeeds},
        Harness{"change", runChange, changeSeeds, Grammar::Json},
        Harness{"picture", runPicture, pictureSeeds},
    };
    return kAll;
}

const Harness &harnessNamed(std::string_view name) {
    std::string names;
    for (const Harness &harness : harnesses()) {
        if (harness.name == name) return harness;
        names += ' ' + std::string(harness.name);
    }
    throw std::invalid_argument("no harness '" + std::string(name) + "' among" + names);
}

void survive(const std::function<void()> &body) {
    static const bool says = std::getenv("TAUT_FUZZ_SAY") != nullptr;
    const auto check = [](const std::string &message) {
        if (says) std::fprintf(stderr, "refused: %s\n", message.c_str());
        require(!message.empty() && message.find('\n') == std::string::npos, "a message is one line: " + message);
    };
    try {
        body();
    } catch (const InputError &error) {
        check(error.what());
    } catch (const RunError &error) {
        check(error.what());
    }
}

void require(bool holds, std::string_view promise) {
    if (!holds) throw std::logic_error(std::string(promise));
}

namespace {

/// Removed when the process ends by itself.
struct Scratch {
    std::string path;
    Scratch() {
        const fs::path memory = "/dev/shm";
        const fs::path parent = fs::is_directory(memory) ? memory : fs::temp_directory_path();
        path = (parent / ("taut-fuzz-" + std::to_string(getpid()))).string();
        fs::create_directories(path);
    }
    Scratch(const Scratch &) = delete;
    Scratch &operator=(const Scratch &) = delete;
    ~Scratch() {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
};

} // namespace

const std::string &scratchFolder() {
    static const Scratch scratch;
    return scratch.path;
}

std::string scratchFile(const std::string &name, std::string_view bytes) {
    std::string path = scratchFolder() + '/' + name;
    std::FILE *file = std::fopen(path.c_str(), "wb");
    require(file != nullptr && (bytes.empty() || std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size()), "the scratch folder can be written");
    std::fclose(file);
    return path;
}

} // namespace taut::fuzz

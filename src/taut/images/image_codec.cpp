#include "taut/images/image_codec.h"

#include "taut/base/error.h"

#include <dlfcn.h>

#include <filesystem>
#include <mutex>
#include <thread>

namespace taut {

namespace {

namespace fs = std::filesystem;

constexpr const char *kFileName = "taut_images.so";
constexpr const char *kEntry = "tautImageCodec";

/// Places beside the program or library that this code is part of.
std::vector<std::string> placesBeside() {
    Dl_info self{};
    if (dladdr(reinterpret_cast<const void *>(&imageCodec), &self) == 0 || self.dli_fname == nullptr) return {};
    std::error_code error;
    fs::path file(self.dli_fname);
    // A program is known by the words it was called with, which may be found along PATH.
    if (!fs::exists(file, error)) file = fs::read_symlink("/proc/self/exe", error);
    const fs::path folder = fs::weakly_canonical(file, error).parent_path();
    std::vector<std::string> places;
    for (const fs::path &place : {folder, folder / "taut", folder / "../lib/taut", folder / TAUT_LIBRARY_FROM_PROGRAM / "taut"})
        places.push_back((place / kFileName).lexically_normal());
    return places;
}

void *openModule(std::string &tried) {
    std::vector<std::string> places = placesBeside();
    places.emplace_back(kFileName); // along the run path
    for (const std::string &place : places) {
        std::error_code error;
        const bool isName = place == kFileName;
        if (!isName && !fs::exists(place, error)) continue;
        if (void *module = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL); module != nullptr) return module;
        const char *reason = dlerror();
        tried += (tried.empty() ? "" : "; ") + std::string(reason != nullptr ? reason : place.c_str());
    }
    return nullptr;
}

const ImageCodec &load() {
    std::string tried;
    void *module = openModule(tried);
    void *entry = module != nullptr ? dlsym(module, kEntry) : nullptr;
    if (entry == nullptr)
        throw RunError("the module that reads and writes images was not found (" + tried + "), expected " + kFileName +
                       " beside the program or in lib/taut of its installation");
    return reinterpret_cast<const ImageCodec &(*)()>(entry)();
}

std::jthread &preloading() {
    static std::jthread thread;
    return thread;
}

} // namespace

const ImageCodec &imageCodec() {
    static const ImageCodec &codec = load();
    return codec;
}

void preloadImageCodec() {
    static std::once_flag once;
    std::call_once(once, [] {
        preloading() = std::jthread([] {
            try {
                imageCodec();
            } catch (const std::exception &) { // said again where an image is asked for
            }
        });
    });
}

void awaitImageCodec() {
    if (preloading().joinable()) preloading().join();
}

} // namespace taut

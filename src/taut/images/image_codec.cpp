#include "taut/images/image_codec.h"

#include "taut/base/error.h"

#include <dlfcn.h>
#include <link.h>

#include <cstddef>
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

/// Places along the run path of the program or library that this code is part of, as the system reads it. That path goes with whoever
/// calls dlopen(), which is a sanitizer's runtime where that stands in between.
std::vector<std::string> placesAlongRunPath() {
    Dl_info self{};
    link_map *map = nullptr;
    if (dladdr1(reinterpret_cast<const void *>(&imageCodec), &self, reinterpret_cast<void **>(&map), RTLD_DL_LINKMAP) == 0) return {};
    const bool isProgram = map->l_name == nullptr || *map->l_name == '\0';
    void *handle = dlopen(isProgram ? nullptr : map->l_name, RTLD_LAZY | RTLD_NOLOAD);
    if (handle == nullptr) return {};
    std::vector<std::string> places;
    if (Dl_serinfo size{}; dlinfo(handle, RTLD_DI_SERINFOSIZE, &size) == 0) {
        std::vector<std::max_align_t> room(size.dls_size / sizeof(std::max_align_t) + 1);
        auto *found = reinterpret_cast<Dl_serinfo *>(room.data());
        *found = size;
        if (dlinfo(handle, RTLD_DI_SERINFO, found) == 0)
            for (unsigned i = 0; i < found->dls_cnt; ++i) places.push_back(fs::path(found->dls_serpath[i].dls_name) / kFileName);
    }
    dlclose(handle);
    return places;
}

void *openModule(std::string &tried) {
    std::vector<std::string> places = placesBeside();
    for (std::string &place : placesAlongRunPath()) places.push_back(std::move(place));
    places.emplace_back(kFileName); // where else the system looks
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

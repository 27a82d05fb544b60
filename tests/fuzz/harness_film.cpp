/// Films and frames that were saved, and are read back.

#include "harness.h"
#include "harness_list.h"

#include "render_fixtures.h"

#include "taut/base/checked_stream.h"
#include "taut/base/file_bytes.h"
#include "taut/render/denoise.h"
#include "taut/render/saved_frame.h"

#include <sstream>

namespace taut::fuzz {

namespace {

std::string saved(const Film &film) {
    std::ostringstream out;
    film.save(out);
    return out.str();
}

const RenderScene &smallRender() {
    static const RenderScene *const ready = [] {
        Scene scene = test::smallScene(test::makeObject(makeTorus(6, 5, 0.7F, 0.25F)), test::ggxMaterial(0.1F, 0.3F), 4);
        auto *render = new RenderScene(std::move(scene), false);
        StageTimes times;
        render->setFrame(1, times);
        return render;
    }();
    return *ready;
}

FrameOptions smallOptions(bool adaptive) {
    FrameOptions options;
    options.spp = 4;
    options.seed = 1;
    if (adaptive) options.noise = 0.1;
    return options;
}

std::string savedFrame(bool adaptive, int samples) {
    FrameRender render(smallRender(), smallOptions(adaptive));
    FrameBudget budget;
    budget.samples = samples;
    if (samples > 0) render.advance(budget);
    std::ostringstream out;
    render.save(out);
    return out.str();
}

} // namespace

void runFilm(std::string_view bytes) {
    survive([&] {
        std::istringstream in{std::string(bytes)};
        Film film = Film::load(in);
        require(film.resolve().size() == film.channelNames().size() * static_cast<std::size_t>(film.window().width()) *
                                             static_cast<std::size_t>(film.window().height()),
                "a film has a value for each channel of each pixel");
        std::istringstream again(saved(film));
        require(Film::load(again) == film, "what is saved is read back");
        Film both = film;
        both.merge(film);
        if (both.denoiseSums() != nullptr) static_cast<void>(denoise(both));
    });
}

/// The first byte: adaptive or not.
void runRestore(std::string_view bytes) {
    if (bytes.empty()) return;
    survive([&] {
        FrameRender render(smallRender(), smallOptions((bytes.front() & 1) != 0));
        std::istringstream in{std::string(bytes.substr(1))};
        try {
            render.restore(in);
        } catch (const InputError &) {
            require(render.share() == 0, "what is refused leaves things as they were");
            throw;
        }
        FrameBudget budget;
        budget.samples = 1;
        render.advance(budget);
        static_cast<void>(render.film());
    });
}

/// Files of frames, the hash at their end made right. The first two bytes: how long the first of two is.
void runSaved(std::string_view bytes) {
    if (bytes.size() < 2) return;
    const auto byte = [&](std::size_t i) { return static_cast<std::size_t>(static_cast<unsigned char>(bytes[i])); };
    const std::size_t first = std::min(byte(0) << 8U | byte(1), bytes.size() - 2);
    std::vector<std::string> paths;
    for (const std::string_view content : {bytes.substr(2, first), bytes.substr(2 + first)}) {
        if (content.empty()) continue;
        paths.push_back(scratchFolder() + "/saved" + std::to_string(paths.size()) + ".shard");
        CheckedWriter writer(paths.back());
        writer.stream() << content;
        writer.finish();
    }
    if (paths.empty()) return;
    survive([&] {
        FrameRender render(smallRender(), smallOptions(false));
        resumeSavedFrame(paths.front(), readSavedHead(paths.front()), render);
        static_cast<void>(render.film());
    });
    survive([&] {
        const MergedFrame merged = mergeShards(paths);
        require(merged.film.window() == merged.head.window, "merged shards fill the window");
    });
}

std::vector<std::string> savedSeeds() {
    const auto file = [&](int part, int parts) {
        const FrameOptions whole = smallOptions(false);
        SavedHead head;
        head.part = {SplitBy::Samples, part, parts};
        FrameRender render(smallRender(), optionsOfPart(whole, head.part, smallRender().scene().render));
        render.advance();
        head.facts = settingFacts(smallRender().scene(), whole, 1);
        head.width = head.height = 4;
        head.window = {0, 0, 4, 4};
        head.done = true;
        const std::string path = scratchFolder() + "/seed.shard";
        writeSavedFrame(path, head, render);
        const std::string bytes = readFileBytes(path);
        constexpr std::size_t kHash = 32; // of its end (checked_stream.h)
        return bytes.substr(0, bytes.size() - kHash);
    };
    const auto joined = [](const std::string &a, const std::string &b) {
        return std::string{static_cast<char>(a.size() >> 8U), static_cast<char>(a.size() & 0xffU)} + a + b;
    };
    return {joined(file(1, 1), ""), joined(file(1, 2), file(2, 2)), joined(file(2, 3), file(1, 2))};
}

std::vector<std::string> filmSeeds() {
    Film plain({0, 0, 2, 1}, {});
    plain.add(1, 0, Vec3(1, 2, 3), 1, nullptr);
    const std::string_view names[] = {"depth", "normal"};
    Film named({3, 4, 5, 5}, aovsNamed(names, "seed"));
    const float values[] = {1, 0, 0, 1};
    named.add(4, 4, Vec3(0.5F), 1, values);
    FilmLayers layers;
    layers.objects = layers.lights = layers.variance = true;
    layers.lightGroups = {"emission", "key"};
    Film layered({0, 0, 2, 1}, {}, layers);
    const Vec3 lights[] = {Vec3(0.25F), Vec3(0.5F)};
    layered.add(1, 0, Vec3(0.75F), 1, nullptr);
    layered.addLayers(1, 0, Vec3(0.75F), {0x3f800000, 0, lights});
    Film halves({0, 0, 2, 1}, {}, {}, 2);
    halves.add(1, 0, Vec3(0.5F), 1, nullptr);
    halves.denoiseSums()->add(1, 0, 0, Vec3(0.5F), true);
    FeatureMeans means;
    means.addNothing(true, true);
    halves.denoiseSums()->tell(1, 0, means.rounded(true));
    Film shared({0, 0, 2, 1}, {}, {}, 0, true);
    shared.add(1, 0, Vec3(0.5F), 1, nullptr);
    shared.sharedSums()->add(1, 0, sharedSample(shared.window(), 1, 0, Vec2(0.5F)), Vec3(0.5F), 1);
    return {saved(plain), saved(named), saved(layered), saved(halves), saved(shared)};
}

std::vector<std::string> restoreSeeds() {
    return {std::string(1, '\0') + savedFrame(false, 0), std::string(1, '\0') + savedFrame(false, 2), '\1' + savedFrame(true, 0),
            '\1' + savedFrame(true, 1)};
}

} // namespace taut::fuzz

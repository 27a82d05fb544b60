/// Films and frames that were saved, and are read back.

#include "harness.h"
#include "harness_list.h"

#include "render_fixtures.h"

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

std::vector<std::string> filmSeeds() {
    Film plain({0, 0, 2, 1}, {});
    plain.add(1, 0, Vec3(1, 2, 3), 1, nullptr);
    const std::string_view names[] = {"depth", "normal"};
    Film named({3, 4, 5, 5}, aovsNamed(names, "seed"));
    const float values[] = {1, 0, 0, 1};
    named.add(4, 4, Vec3(0.5F), 1, values);
    return {saved(plain), saved(named)};
}
std::vector<std::string> restoreSeeds() {
    return {std::string(1, '\0') + savedFrame(false, 0), std::string(1, '\0') + savedFrame(false, 2), '\1' + savedFrame(true, 0),
            '\1' + savedFrame(true, 1)};
}

} // namespace taut::fuzz

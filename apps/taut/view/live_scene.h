#pragma once
/// A scene that is rendered while its keys change: what a change touches is brought up to date, the rest stays as it is. Its picture is
/// that of `taut render` for the same keys once settle() has planned anew.

#include "../scene_arguments.h"

#include "taut/render/render_scene.h"

#include <memory>
#include <set>
#include <string>

namespace taut::app {

/// The parts of a scene that changed keys decide.
struct Touched {
    bool camera = false, lights = false, environment = false, motion = false;
    bool everything = false; ///< a key that a scene is built from
    std::set<std::string> materials;

    /// Takes in a key such as mesh.0.deform.1.amount.
    void add(const std::string &key);
    Touched &operator+=(const Touched &other);
    [[nodiscard]] bool any() const { return camera || lights || environment || motion || everything || !materials.empty(); }
};

class LiveScene {
  public:
    explicit LiveScene(ModelArguments model) : model_(std::move(model)) {}

    /// The scene as it is now, read with its environment where that or a light is touched. Throws InputError.
    void take(Scene next, const Touched &touched);
    /// Plans for the scene as it is. True where that changes its picture.
    bool settle();
    [[nodiscard]] bool isSettled() const { return settled_; }

    [[nodiscard]] bool isThere() const { return ready_ != nullptr; }
    [[nodiscard]] RenderScene &ready() { return *ready_; }
    /// Of how many scenes it was built so far: a change that builds nothing leaves it.
    [[nodiscard]] int built() const { return built_; }

  private:
    void build(Scene scene);
    [[nodiscard]] bool fits(const Scene &next, const Touched &touched) const;

    ModelArguments model_;
    std::unique_ptr<RenderScene> ready_;
    bool settled_ = false;
    int built_ = 0;
};

} // namespace taut::app

/// The section [image] of a scene file: how its pictures are seen and stored.

#include "taut/scene/load_context.h"

namespace taut {

namespace {

/// One of "half", "float", 8 and 16.
void readBits(const TomlValue &value, ImageSettings &settings) {
    setBits(value.kind == TomlValue::Kind::Integer ? std::to_string(value.integer) : toText(value), value.where, settings);
}

} // namespace

void loadImage(LoadContext &context, const TomlValue &section) {
    ImageSettings &settings = context.scene.image;
    ViewSettings &view = settings.view;
    TableReader table(section, "[image]", {"exposure", "view", "display", "look", "ocio", "space", "bits", "compression"});
    table.read("exposure", view.exposure, numberIn(kStops));
    table.read("view", view.view);
    table.read("display", view.display);
    table.read("look", view.look);
    table.read("ocio", view.config, [&](const TomlValue &value) { return filePath(context, value); });
    table.read("space", view.space);
    if (const TomlValue *bits = table.find("bits")) {
        if (bits->kind != TomlValue::Kind::Array) readBits(*bits, settings);
        for (const TomlValue &item : bits->items) readBits(item, settings); // of PNG and of EXR
    }
    if (const TomlValue *compression = table.find("compression")) {
        checkCompression(toText(*compression), compression->where);
        settings.exrCompression = compression->text;
    }
    table.finish();
}

ImageSettings readImageSettings(const TomlValue &section, ImageSettings settings, const std::string &folder) {
    Warnings warnings;
    SceneCache cache;
    LoadContext context(warnings, cache);
    context.folder = folder;
    context.scene.image = std::move(settings);
    loadImage(context, section);
    return context.scene.image;
}

} // namespace taut

#pragma once
/// Every harness and its seeds; the table of them is in harness.cpp.

#include "taut/images/image_settings.h"

#include <string>
#include <string_view>
#include <vector>

namespace taut::fuzz {

// harness_meshes.cpp
void runObj(std::string_view bytes);
void runPly(std::string_view bytes);
void runOff(std::string_view bytes);
void runStl(std::string_view bytes);
std::vector<std::string> objSeeds();
std::vector<std::string> plySeeds();
std::vector<std::string> offSeeds();
std::vector<std::string> stlSeeds();

// harness_gltf.cpp
void runGltf(std::string_view bytes);
void runGlb(std::string_view bytes);
std::vector<std::string> gltfSeeds();
std::vector<std::string> glbSeeds();

// harness_motion.cpp: point caches and frame sets
void runPc2(std::string_view bytes);
void runMdd(std::string_view bytes);
void runFrames(std::string_view bytes);
std::vector<std::string> pc2Seeds();
std::vector<std::string> mddSeeds();
std::vector<std::string> frameSeeds();

// harness_scene.cpp
void runToml(std::string_view bytes);
void runScene(std::string_view bytes);
void runWriters(std::string_view bytes);
std::vector<std::string> tomlSeeds();
std::vector<std::string> sceneSeeds();
std::vector<std::string> writerSeeds();

// harness_film.cpp
void runFilm(std::string_view bytes);
void runRestore(std::string_view bytes);
void runSaved(std::string_view bytes);
std::vector<std::string> filmSeeds();
std::vector<std::string> restoreSeeds();
std::vector<std::string> savedSeeds();

// harness_images.cpp
void runImage(std::string_view bytes);
void runEnvironment(std::string_view bytes);
std::vector<std::string> imageSeeds();
std::vector<std::string> pngSeeds();
std::vector<std::string> environmentSeeds();

// harness_colours.cpp
/// Makes the view and shows some colours through it, those that are none among them.
void checkColours(const ViewSettings &settings);
void runOcio(std::string_view bytes);
std::vector<std::string> ocioSeeds();

// harness_picture.cpp
void runPicture(std::string_view bytes);
std::vector<std::string> pictureSeeds();

// harness_view.cpp
void runHttp(std::string_view bytes);
void runChange(std::string_view bytes);
std::vector<std::string> httpSeeds();
std::vector<std::string> changeSeeds();

} // namespace taut::fuzz

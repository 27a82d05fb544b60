#pragma once
/// The files of the page, compiled in (cmake/TautEmbed.cmake makes the list from apps/taut/view/page).

#include <span>
#include <string_view>

namespace taut::app {

struct PageFile {
    std::string_view name;
    std::string_view type; ///< Content-Type
    std::string_view text;
};
std::span<const PageFile> pageFiles();

} // namespace taut::app

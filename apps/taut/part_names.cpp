#include "part_names.h"

#include "taut/base/distinct_names.h"
#include "taut/base/utf8.h"

namespace taut::app {

namespace {

std::string keptCharacters(const std::string &name) {
    std::string out;
    for (std::size_t i = 0; i < name.size();) {
        const std::size_t length = utf8Length(std::string_view(name).substr(i));
        const char c = name[i];
        const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' || c == '-';
        const bool control = length == 2 && c == '\xc2' && static_cast<unsigned char>(name[i + 1]) < 0xa0; // U+0080 to U+009F
        if (plain || (length > 1 && !control))
            out += name.substr(i, length);
        else
            out += '_';
        i += length == 0 ? 1 : length;
    }
    return out.empty() ? "_" : out;
}

} // namespace

std::vector<std::string> partNames(const std::vector<std::string> &names, std::size_t longest) {
    std::vector<std::string> out;
    DistinctNames unique;
    for (const std::string &name : names) out.push_back(unique.add(keptCharacters(name), longest, foldedCase, utf8Front));
    return out;
}

} // namespace taut::app

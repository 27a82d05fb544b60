#pragma once
/// JSON as text.

#include <nlohmann/json.hpp>

#include <string>

namespace taut::app {

/// `indent`: -1 for one line. Names of files may be any bytes and JSON is UTF-8 (RFC 8259, section 8.1): a byte that is not becomes
/// U+FFFD. The files themselves keep their names.
inline std::string jsonText(const nlohmann::json &value, int indent) {
    return value.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

} // namespace taut::app

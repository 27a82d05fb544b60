#pragma once
/// OpenEXR headers that ask for more than their file can hold: attributes, windows and tables of chunks are allocated by what their
/// sizes say before anything is read into them. The layout is that of "OpenEXR File Layout", Academy Software Foundation.

#include "taut/scene/image_header.h"

#include <string>

namespace taut {

/// What is wrong with the headers; empty: nothing.
std::string damageOfExr(std::string_view bytes);

/// The largest part, and what the library allocates for all of them.
AnnouncedSize sizeOfExr(std::string_view bytes);

} // namespace taut

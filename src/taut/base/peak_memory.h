#pragma once
/// Memory that this process has held at most.

namespace taut {

/// Peak resident memory since the process began, megabytes of 2^20 bytes.
double peakMegabytes();

} // namespace taut

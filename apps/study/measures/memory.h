#pragma once
/// Memory of this process, in megabytes.

namespace taut::chart {

/// The most that was resident since the start or since resetPeak().
double peakMegabytes();
/// Gives free memory back and counts anew from what is left (Linux; elsewhere the peak stays that since the start).
void resetPeak();
/// What is allocated, Embree's memory included.
double allocatedMegabytes();

} // namespace taut::chart

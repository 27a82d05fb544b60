#pragma once
/// Times that can be compared on a busy machine: every row is run once per round, so that what else runs slows all rows alike, and the
/// median over the rounds is kept with half the distance between its quartiles.

#include "study/chart.h"

#include <tbb/global_control.h>
#include <time.h>

#include <algorithm>
#include <functional>
#include <span>

namespace taut::chart {

/// Median and quartiles, those of few values the values outside them: of three the least and the greatest. The values are not empty.
struct Quartiles {
    double lower = 0, median = 0, upper = 0;
};
inline Quartiles quartilesOf(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t last = values.size() - 1;
    return {values[last / 4], values[(last + 1) / 2], values[last - last / 4]};
}
/// The median and half the distance between the quartiles.
inline Measured medianOf(const std::vector<double> &values) {
    const Quartiles q = quartilesOf(values);
    return {q.median, (q.upper - q.lower) / 2, static_cast<int>(values.size())};
}

inline Measured operator*(const Measured &m, double factor) {
    return {m.value * factor, m.spread * factor, m.repetitions};
}

/// What a row is timed by: the wall, or the processor time of the calling thread, which leaves out what other programs take. Rows that use
/// several threads need the wall.
enum class Clock { Wall, Thread };

/// Seconds of a clock since some moment.
inline double secondsOf(Clock clock) {
    timespec now{};
    clock_gettime(clock == Clock::Wall ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Seconds of each row, from `rounds` rounds over all of them after one that is not counted. A row runs for long enough to be timed
/// (a millisecond or more).
inline std::vector<Measured> timeInterleaved(std::span<const std::function<void()>> rows, int rounds, Clock clock = Clock::Wall) {
    std::vector<std::vector<double>> seconds(rows.size());
    for (int round = -1; round < rounds; ++round)
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const double start = secondsOf(clock);
            rows[i]();
            if (round >= 0) seconds[i].push_back(secondsOf(clock) - start);
        }
    std::vector<Measured> medians;
    for (const std::vector<double> &row : seconds) medians.push_back(medianOf(row));
    return medians;
}

/// Those of rows that would use several threads: on one, by its processor time.
inline std::vector<Measured> timeOnOneThread(std::span<const std::function<void()>> rows, int rounds) {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    return timeInterleaved(rows, rounds, Clock::Thread);
}

/// A choice of a plot, run once a round; a run returns its error, whose random numbers `seed` names: 1 is the round that is not counted.
struct Choice {
    std::string series, label;
    bool isDefault;
    std::function<double(std::uint32_t seed)> run;
};
/// Points of choices that take turns: time in units of `unit` seconds against the median of the errors.
enum class Threads { All, One };
inline std::vector<Point> timeChoices(const std::vector<Choice> &choices, int rounds, Threads threads, double unit = 1) {
    std::vector<std::vector<double>> errors(choices.size());
    std::vector<std::function<void()>> rows;
    for (std::size_t i = 0; i < choices.size(); ++i)
        rows.emplace_back(
            [&choice = choices[i], &own = errors[i]] { own.push_back(choice.run(static_cast<std::uint32_t>(own.size() + 1))); });
    const std::vector<Measured> seconds = threads == Threads::One ? timeOnOneThread(rows, rounds) : timeInterleaved(rows, rounds);
    std::vector<Point> points;
    for (std::size_t i = 0; i < choices.size(); ++i)
        points.push_back({choices[i].series, choices[i].label, seconds[i] * (1 / unit), medianOf(errors[i]), choices[i].isDefault});
    return points;
}

} // namespace taut::chart

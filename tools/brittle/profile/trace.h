// A time line for Perfetto (https://ui.perfetto.dev) or chrome://tracing: slices of the main thread, of the thread that
// breaks the mesh, of the threads that share its work, and of the devices that draw and classify, on one clock.
//
//     Trace trace;
//     trace.add(Track::main, 0, "frame", begin, end);        // nanoseconds of std::chrono::steady_clock
//     trace.add(Track::main, 1, "physics", begin, middle);
//     write(trace.json({{"device", "..."}}));
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace brittle::tools {

// Returns the current time in nanoseconds of steady_clock.
[[nodiscard]] inline int64_t trace_clock() {
    return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Tracks of threads that share the work of a fracture follow the last one: share_track().
enum class Track { main = 1, worker, device, classifier, share };
[[nodiscard]] inline Track share_track(size_t thread) {
    return static_cast<Track>(static_cast<int>(Track::share) + static_cast<int>(thread));
}

[[nodiscard]] inline double milliseconds_between(int64_t begin, int64_t end) {
    return static_cast<double>(end - begin) * 1e-6;
}

class Trace {
  public:
    // Adds a slice of time. A slice of depth d + 1 belongs to the slice of depth d in which it begins; depth 0 is
    // outermost.
    void add(Track track, int depth, const std::string& name, int64_t begin, int64_t end);
    // Adds a slice with the range of items worked on, shown as the slice's arguments "from" and "to".
    void add(Track track, int depth, const std::string& name, int64_t begin, int64_t end, uint32_t from_item,
             uint32_t to_item);
    // Adds consecutive slices from `begin`, each of the given duration.
    struct Step {
        std::string name;
        double milliseconds = 0.0;
    };
    void add_steps(Track track, int depth, const std::vector<Step>& steps, int64_t begin);
    // Marks a moment across all tracks.
    void mark(const std::string& name, int64_t at);

    // Returns the JSON object of the Trace Event Format, with times in microseconds from the first begin, rounded to an
    // eighth. Where clocks disagree by a rounding error, slices are cut so that they nest in the slice above and follow
    // the one before. `metadata` becomes otherData.
    [[nodiscard]] nlohmann::ordered_json json(const nlohmann::ordered_json& metadata) const;

  private:
    struct Slice {
        Track track;
        int depth;
        std::string name;
        int64_t begin, end; // ns
        std::optional<std::pair<uint32_t, uint32_t>> items{};
    };
    struct Mark {
        std::string name;
        int64_t at; // ns
    };
    std::vector<Slice> slices_;
    std::vector<Mark> marks_;
};

} // namespace brittle::tools

#include "tools/brittle/profile/trace.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

constexpr int process = 1;
constexpr int max_depth = 8;

std::string name_of(Track track) {
    switch (track) {
    case Track::main:
        return "main thread";
    case Track::worker:
        return "fracture thread";
    case Track::device:
        return "Vulkan device, drawing";
    case Track::classifier:
        return "Vulkan device, classifying";
    case Track::share:
        break;
    }
    return "worker " + std::to_string(static_cast<int>(track) - static_cast<int>(Track::share));
}

// Rounds down to an eighth, which a double holds exactly: for a reader ts + dur then meets the next ts.
double microseconds(int64_t nanoseconds) {
    return static_cast<double>(nanoseconds / 125) / 8.0;
}

Json name_event(const char* what, const std::string& name, int thread) {
    return {{"name", what}, {"ph", "M"}, {"pid", process}, {"tid", thread}, {"args", {{"name", name}}}};
}

} // namespace

void Trace::add(Track track, int depth, const std::string& name, int64_t begin, int64_t end) {
    slices_.push_back({track, std::clamp(depth, 0, max_depth - 1), name, begin, std::max(begin, end), {}});
}

void Trace::add(Track track, int depth, const std::string& name, int64_t begin, int64_t end, uint32_t from_item,
                uint32_t to_item) {
    add(track, depth, name, begin, end);
    slices_.back().items = {from_item, to_item};
}

void Trace::add_steps(Track track, int depth, const std::vector<Step>& steps, int64_t begin) {
    double after = 0.0; // ms
    for (const Step& step : steps) {
        const auto from = begin + std::llround(after * 1e6);
        after += step.milliseconds;
        add(track, depth, step.name, from, begin + std::llround(after * 1e6));
    }
}

void Trace::mark(const std::string& name, int64_t at) {
    marks_.push_back({name, at});
}

Json Trace::json(const Json& metadata) const {
    std::vector<Slice> slices = slices_;
    const auto order = [](const Slice& s) { return std::tuple(s.track, s.begin, s.depth); };
    std::stable_sort(slices.begin(), slices.end(), [&](const Slice& a, const Slice& b) { return order(a) < order(b); });
    int64_t origin = std::numeric_limits<int64_t>::max();
    for (const Slice& slice : slices) origin = std::min(origin, slice.begin);
    for (const Mark& mark : marks_) origin = std::min(origin, mark.at);

    Json events = Json::array();
    events.push_back(name_event("process_name", "brittle profile", 0));
    for (size_t i = 0; i < slices.size(); ++i)
        if (i == 0 || slices[i - 1].track != slices[i].track)
            events.push_back(name_event("thread_name", name_of(slices[i].track), static_cast<int>(slices[i].track)));

    // The last slice of each depth on the current track.
    std::array<Slice, max_depth> last;
    for (size_t i = 0; i < slices.size(); ++i) {
        Slice& slice = slices[i];
        const auto depth = static_cast<size_t>(slice.depth);
        if (i == 0 || slices[i - 1].track != slice.track)
            last.fill(
                {slice.track, 0, "", std::numeric_limits<int64_t>::min(), std::numeric_limits<int64_t>::min(), {}});
        const bool has_parent = depth > 0 && slice.begin <= last[depth - 1].end;
        if (has_parent) slice.end = std::min(slice.end, last[depth - 1].end);
        for (size_t d = depth; d < max_depth; ++d) slice.begin = std::max(slice.begin, last[d].end);
        slice.end = std::max(slice.begin, slice.end);
        if (has_parent && slice.begin > last[depth - 1].end) continue; // the slice would be empty
        last[depth] = slice;
        events.push_back({{"name", slice.name},
                          {"cat", slice.track == Track::device || slice.track == Track::classifier ? "device" : "cpu"},
                          {"ph", "X"},
                          {"ts", microseconds(slice.begin - origin)},
                          {"dur", microseconds(slice.end - origin) - microseconds(slice.begin - origin)},
                          {"pid", process},
                          {"tid", static_cast<int>(slice.track)}});
        if (slice.items) events.back()["args"] = {{"from", slice.items->first}, {"to", slice.items->second}};
    }
    for (const Mark& mark : marks_)
        events.push_back({{"name", mark.name},
                          {"cat", "cpu"},
                          {"ph", "i"},
                          {"s", "g"},
                          {"ts", microseconds(mark.at - origin)},
                          {"pid", process},
                          {"tid", static_cast<int>(Track::main)}});
    return {{"traceEvents", events}, {"displayTimeUnit", "ms"}, {"otherData", metadata}};
}

} // namespace brittle::tools

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
constexpr int most_depth = 8;

constexpr std::array<std::pair<Track, const char*>, 4> tracks{{{Track::main, "main thread"},
                                                               {Track::worker, "fracture thread"},
                                                               {Track::device, "Vulkan device, drawing"},
                                                               {Track::classifier, "Vulkan device, classifying"}}};

// Down to an eighth, which a double holds exactly: a reader's ts + dur meets the next ts.
double microseconds(int64_t nanoseconds) {
    return static_cast<double>(nanoseconds / 125) / 8.0;
}

Json name_event(const char* what, const char* name, int thread) {
    return {{"name", what}, {"ph", "M"}, {"pid", process}, {"tid", thread}, {"args", {{"name", name}}}};
}

} // namespace

void Trace::add(Track track, int depth, const std::string& name, int64_t begin, int64_t end) {
    slices_.push_back({track, std::clamp(depth, 0, most_depth - 1), name, begin, std::max(begin, end)});
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
    std::stable_sort(slices.begin(), slices.end(),
                     [&](const Slice& a, const Slice& b) { return order(a) < order(b); });
    int64_t origin = std::numeric_limits<int64_t>::max();
    for (const Slice& slice : slices) origin = std::min(origin, slice.begin);
    for (const Mark& mark : marks_) origin = std::min(origin, mark.at);

    Json events = Json::array();
    events.push_back(name_event("process_name", "brittle profile", 0));
    for (const auto& [track, name] : tracks)
        if (std::any_of(slices.begin(), slices.end(), [&](const Slice& s) { return s.track == track; }))
            events.push_back(name_event("thread_name", name, static_cast<int>(track)));

    // Of the track at hand: the last slice of each depth.
    std::array<Slice, most_depth> last;
    for (size_t i = 0; i < slices.size(); ++i) {
        Slice& slice = slices[i];
        const auto depth = static_cast<size_t>(slice.depth);
        if (i == 0 || slices[i - 1].track != slice.track)
            last.fill({slice.track, 0, "", std::numeric_limits<int64_t>::min(), std::numeric_limits<int64_t>::min()});
        const bool has_parent = depth > 0 && slice.begin <= last[depth - 1].end;
        if (has_parent) slice.end = std::min(slice.end, last[depth - 1].end);
        for (size_t d = depth; d < most_depth; ++d) slice.begin = std::max(slice.begin, last[d].end);
        slice.end = std::max(slice.begin, slice.end);
        if (has_parent && slice.begin > last[depth - 1].end) continue; // nothing of it is left
        last[depth] = slice;
        events.push_back({{"name", slice.name},
                          {"cat", slice.track >= Track::device ? "device" : "cpu"},
                          {"ph", "X"},
                          {"ts", microseconds(slice.begin - origin)},
                          {"dur", microseconds(slice.end - origin) - microseconds(slice.begin - origin)},
                          {"pid", process},
                          {"tid", static_cast<int>(slice.track)}});
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

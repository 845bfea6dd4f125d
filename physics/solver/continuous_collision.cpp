#include "physics/solver/continuous_collision.h"

#include <algorithm>

namespace brittle::physics {

namespace {

// A body is fast when a point of it may move by this part of its thickness in a step.
constexpr float fast_part = 0.25f;
// Two moving bodies are searched when they may get deeper into each other than this part of both: only then are they
// pushed apart on the wrong side.
constexpr float half = 0.5f;
// m, shortest path that is searched: bodies that settle in a heap are skipped, however thin. 0.4 m/s at 120 Hz.
constexpr float min_way = 0.0033f;
// A body whose reach is below this part of another's thickness is a crumb and does not stop it.
constexpr float crumb_part = 0.25f;
// Fewer pairs than this, that may touch or are only near, and fewer bodies are not worth waking another thread for.
constexpr uint32_t min_pairs = 8, min_near = 256, min_bodies = 256;

// Whether a path in one step exceeds both a length and min_way.
bool exceeds(float way, float length) {
    return way > std::max(length, min_way);
}

// The longest path of any point of the body, m.
float way_of(const Body& body, float seconds) {
    return (glm::length(body.motion.linear) + glm::length(body.motion.angular) * body.reach) * seconds;
}

// The longest path of a point of the body by rotation alone, m.
float rotation_way(const Body& body, const Trajectory& trajectory) {
    return glm::length(trajectory.velocity.angular) * body.reach * trajectory.stop;
}

glm::vec3 linear_at(const Trajectory& trajectory, float seconds) {
    return seconds < trajectory.stop ? trajectory.velocity.linear : glm::vec3(0.0f);
}

// Calls visit with each hull of the body that may be in the bounds, given in the world as the body is when the step
// begins.
template<class Visit>
void for_each_hull(const Body& body, const Trajectory& trajectory, const Bounds& bounds, const Visit& visit) {
    if (!body.compound) return visit(MovingHull{&body.hull(), Transform{}, &trajectory});
    body.compound->tree().for_each_overlap(bounds.in(trajectory.start.inverse()), [&](uint32_t part) {
        const CompoundShape::Child& child = body.compound->children()[part];
        visit(MovingHull{&child.shape(), child.frame, &trajectory});
    });
}

} // namespace

std::span<const ContinuousCollision::Stop> ContinuousCollision::find(std::span<Body* const> awake, float seconds) {
    stops_.clear();
    if (std::ranges::any_of(awake, [&](const Body* body) { return is_fast(*body, seconds); })) find_stops(seconds);
    return stops_;
}

void ContinuousCollision::find_stops(float seconds) {
    find_fast(seconds);
    if (fixed_.empty() && crossing_.empty()) return; // nothing to pass through
    find_trajectories(seconds);
    grow_crossing();
    for (const uint32_t body : fast_) pair_with_fixed(body);
    pair_crossing();
    add_events(0.0f);
    while (!events_.empty()) {
        std::pop_heap(events_.begin(), events_.end());
        const Event event = events_.back();
        events_.pop_back();
        // If one of the two has stopped since, a newer event replaces this one.
        if (trajectories_[event.first].stop != event.first_stop
            || trajectories_[event.second].stop != event.second_stop)
            continue;
        const bool first = may_be_stopped(event.first, event.second);
        const bool second = may_be_stopped(event.second, event.first);
        if (first) stop(event.first, event.second, event.seconds);
        if (second) stop(event.second, event.first, event.seconds);
        if (first) pair_with_moving(event.first, event.seconds);
        if (second) pair_with_moving(event.second, event.seconds);
        add_events(event.seconds);
    }
}

bool ContinuousCollision::is_fast(const Body& body, float seconds) {
    return exceeds(way_of(body, seconds), fast_part * body.thickness);
}

void ContinuousCollision::find_fast(float seconds) {
    end_ = seconds;
    slow_way_ = 0.0f;
    const auto count = static_cast<uint32_t>(bodies_.size());
    summaries_.resize(count);
    threads_.for_chunks(count, min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) summaries_[i] = summary_of(*bodies_[i], seconds);
    });
    is_fast_.assign(count, 0);
    is_crossing_.assign(count, 0);
    for (std::vector<uint32_t>* list : {&fast_, &crossing_, &fixed_}) list->clear();
    const glm::vec3 common = common_velocity();
    for (uint32_t i = 0; i < count; ++i) {
        const Summary& summary = summaries_[i];
        if (summary.fixed) {
            fixed_.push_back(i);
            continue;
        }
        is_crossing_[i] = !summary.debris && glm::length(summary.linear - common) * seconds > summary.crossing_way;
        if (is_crossing_[i]) crossing_.push_back(i);
        is_fast_[i] = summary.fast;
        if (is_fast_[i]) fast_.push_back(i);
        if (!is_crossing_[i] && !summary.debris) slow_way_ = std::max(slow_way_, summary.way);
    }
}

void ContinuousCollision::find_trajectories(float seconds) {
    const auto count = static_cast<uint32_t>(bodies_.size());
    trajectories_.resize(count);
    threads_.for_chunks(count, min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            const Body& body = *bodies_[i];
            const bool awake = summaries_[i].awake;
            trajectories_[i] = {.start = body.frame,
                                .velocity = {summaries_[i].linear, awake ? body.motion.angular : glm::vec3(0.0f)},
                                .moments = body.moments,
                                .stop = awake ? seconds : 0.0f};
        }
    });
}

void ContinuousCollision::grow_crossing() {
    for (const uint32_t i : crossing_) broadphase_.set_bounds(*bodies_[i]->proxy, swept(i).grown({}, slow_way_));
}

ContinuousCollision::Summary ContinuousCollision::summary_of(const Body& body, float seconds) {
    const bool awake = body.awake();
    return {.linear = awake ? body.motion.linear : glm::vec3(0.0f),
            .way = awake ? way_of(body, seconds) : 0.0f,
            .crossing_way = std::max(half * body.thickness, half * min_way),
            .fixed = body.fixed,
            .awake = awake,
            .debris = body.debris,
            .fast = awake && is_fast(body, seconds)};
}

glm::vec3 ContinuousCollision::common_velocity() const {
    glm::vec3 sum(0.0f);
    float moving = 0.0f, resting = 0.0f;
    for (const Summary& summary : summaries_) {
        if (summary.fixed || summary.debris) continue;
        if (summary.awake)
            sum += summary.linear, moving += 1.0f;
        else
            resting += 1.0f;
    }
    return moving > resting ? sum * (1.0f / moving) : glm::vec3(0.0f);
}

Bounds ContinuousCollision::swept(uint32_t body) const {
    const Trajectory& path = trajectories_[body];
    return bodies_[body]
        ->bounds(path.start)
        .grown(path.velocity.linear * path.stop, rotation_way(*bodies_[body], path));
}

void ContinuousCollision::pair_with_fixed(uint32_t body) {
    if (fixed_.empty()) return;
    const Bounds bounds = swept(body);
    for (const uint32_t other : fixed_)
        if (bounds.overlaps(bodies_[other]->proxy->bounds) && may_touch(body, other, 0.0f))
            kept_.push_back({body, other});
}

void ContinuousCollision::pair_with_moving(uint32_t body, float from) {
    if (crossing_.empty()) return;
    near_.clear();
    const SweptProxy& own = *bodies_[body]->proxy;
    broadphase_.for_each_overlap(swept(body).grown({}, slow_way_), [&](const SweptProxy& proxy) {
        if (&proxy != &own && !proxy.fixed) near_.push_back(proxy.body->index);
    });
    for (const uint32_t other : near_)
        if (may_touch(body, other, from)) kept_.push_back({body, other});
}

void ContinuousCollision::pair_crossing() {
    if (crossing_.empty()) return;
    const std::span<const SweptPairs::Key> keys = broadphase_.find_set();
    const auto count = static_cast<uint32_t>(keys.size());
    std::vector<std::vector<Two>> kept(threads_.chunks(count, min_near));
    threads_.for_chunks(count, min_near, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        for (const SweptPairs::Key key : keys.subspan(begin, end - begin)) {
            const SweptProxy &a = broadphase_.proxy(key >> 32), &b = broadphase_.proxy(static_cast<uint32_t>(key));
            if (a.fixed || b.fixed) continue;
            Two two{std::min(a.body->index, b.body->index), std::max(a.body->index, b.body->index)};
            if (!is_crossing_[two.first]) std::swap(two.first, two.second);
            if (may_touch(two.first, two.second, 0.0f)) kept[chunk].push_back(two);
        }
    });
    for (const std::vector<Two>& some : kept) kept_.insert(kept_.end(), some.begin(), some.end());
}

bool ContinuousCollision::may_touch(uint32_t first, uint32_t second, float from) const {
    if (!may_be_stopped(first, second) && !may_be_stopped(second, first)) return false;
    const Body &a = *bodies_[first], &b = *bodies_[second];
    const Trajectory &path_a = trajectories_[first], &path_b = trajectories_[second];
    const float turning = rotation_way(a, path_a) + rotation_way(b, path_b);
    const float way = glm::length(linear_at(path_a, from) - linear_at(path_b, from)) * (end_ - from);
    return a.fixed || b.fixed ? exceeds(way + turning, fast_part * std::min(a.thickness, b.thickness))
                              : exceeds(way, half * (a.thickness + b.thickness));
}

void ContinuousCollision::add_events(float from) {
    for (const Two& two : kept_) {
        trajectories_[two.first].find_end();
        trajectories_[two.second].find_end();
    }
    found_.resize(kept_.size());
    threads_.for_chunks(static_cast<uint32_t>(kept_.size()), min_pairs, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) found_[i] = event_of(kept_[i].first, kept_[i].second, from);
    });
    for (const Event& event : found_) {
        if (event.seconds >= end_) continue;
        events_.push_back(event);
        std::push_heap(events_.begin(), events_.end());
    }
    kept_.clear();
}

ContinuousCollision::Event ContinuousCollision::event_of(uint32_t first, uint32_t second, float from) const {
    const Body &a = *bodies_[first], &b = *bodies_[second];
    const Trajectory &path_a = trajectories_[first], &path_b = trajectories_[second];
    const float turning_a = rotation_way(a, path_a), turning_b = rotation_way(b, path_b);
    Event event{end_, first, second, path_a.stop, path_b.stop};
    const glm::vec3 way_a = path_a.velocity.linear * path_a.stop, way_b = path_b.velocity.linear * path_b.stop;
    // Where hulls of the first must be as the step begins to meet the second.
    for_each_hull(a, path_a, swept(second).grown(-way_a, turning_a), [&](const MovingHull& hull) {
        const Bounds near =
            hull.shape->bounds(path_a.start * hull.local).grown(way_a, turning_a).grown(-way_b, turning_b);
        for_each_hull(b, path_b, near, [&](const MovingHull& other) {
            if (const auto touch = time_of_impact(hull, other, from, event.seconds)) event.seconds = *touch;
        });
    });
    return event;
}

void ContinuousCollision::stop(uint32_t body, uint32_t by, float seconds) {
    trajectories_[body].stop = seconds;
    trajectories_[body].find_end();
    stops_.push_back({bodies_[body].get(), seconds, bodies_[by]->id});
}

bool ContinuousCollision::may_be_stopped(uint32_t body, uint32_t by) const {
    if (!is_fast_[body] || trajectories_[body].stop < end_ || bodies_[body]->is_apart_from(*bodies_[by])) return false;
    if (bodies_[by]->fixed) return true;
    if (bodies_[body]->debris || bodies_[by]->debris) return false;
    return bodies_[by]->reach > crumb_part * bodies_[body]->thickness && !is_light(by, body);
}

bool ContinuousCollision::is_light(uint32_t body, uint32_t against) const {
    return !bodies_[body]->fixed && bodies_[body]->mass < light_part * bodies_[against]->mass;
}

} // namespace brittle::physics

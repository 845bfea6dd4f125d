#include "physics/solver/step_stops.h"

#include <algorithm>

#include <BulletCollision/BroadphaseCollision/btDbvt.h>

namespace brittle::physics {

namespace {

// A body is fast when a point of it may move by this part of its thickness in a step: fixed ones, which stand for ever, are
// looked at then, however thin it is.
constexpr btScalar fast_part = 0.25f;
// Two that move are looked at when they may get deeper into each other than this part of both: only then are they told apart on
// the wrong side. In a heap that forms, looking at more costs more than all its contacts.
constexpr btScalar half = 0.5f;
// And in any case a way must be longer than this, m: what settles in a heap is left alone, however thin. At 120 Hz 0.4 m/s.
constexpr btScalar min_way = 0.0033f * bullet_units;
// What reaches no farther than this part of a body's thickness does not stop it.
constexpr btScalar crumb_part = 0.25f;
// Fewer pairs than this, that may touch or are only near, and fewer bodies are not worth waking another thread for.
constexpr uint32_t min_pairs = 8, min_near = 256, min_bodies = 256;

using Box = StepStops::Box;

// To hold what it holds while that moves: by a way, and by so much to all sides.
Box grown(Box box, const btVector3& way, btScalar by) {
    for (int axis = 0; axis < 3; ++axis) {
        box.low[axis] += std::min<btScalar>(way[axis], 0.0f) - by;
        box.high[axis] += std::max<btScalar>(way[axis], 0.0f) + by;
    }
    return box;
}

Box box_of(const btCollisionShape& shape, const btTransform& frame) {
    Box box;
    shape.getAabb(frame, box.low, box.high);
    return box;
}

// Whether a way in one step is more than so long, and not only what settles in a heap.
bool exceeds(btScalar way, btScalar least) {
    return way > std::max(least, min_way);
}

// The longest way of any of its points.
btScalar way_of(const BodyRecord& body, btScalar seconds) {
    return (body.rigid->getLinearVelocity().length() + body.rigid->getAngularVelocity().length() * body.reach)
           * seconds;
}

// How far turning takes a point of the body at most.
btScalar turning_way(const BodyRecord& body, const Flight& flight) {
    return flight.angular.length() * body.reach * flight.stop;
}

btVector3 linear_at(const Flight& flight, btScalar seconds) {
    return seconds < flight.stop ? flight.linear : btVector3(0, 0, 0);
}

bool is_fixed(const btBroadphaseProxy& proxy) {
    return proxy.m_collisionFilterGroup == btBroadphaseProxy::StaticFilter;
}

uint32_t index_of(const btBroadphaseProxy& proxy) {
    return static_cast<uint32_t>(static_cast<const btCollisionObject*>(proxy.m_clientObject)->getUserIndex());
}

// Others that move, or may, and that a body meets.
struct Collect final : btBroadphaseAabbCallback {
    const SweepBroadphase& among;
    const btBroadphaseProxy& own;
    std::vector<uint32_t>& found;
    Collect(const SweepBroadphase& all, const btBroadphaseProxy& of, std::vector<uint32_t>& to)
        : among(all), own(of), found(to) {}
    bool process(const btBroadphaseProxy* proxy) override {
        if (proxy != &own && among.may_meet(own, *proxy) && !is_fixed(*proxy)) found.push_back(index_of(*proxy));
        return true;
    }
};

// Calls with each hull of the body that may be in the box, given in the world as the body is when the step begins.
template<class Call>
void visit_hulls(const BodyRecord& body, const Flight& flight, const Box& box, const Call& call) {
    if (!body.compound) return call(FlyingHull{&*body.form->shape, btTransform::getIdentity(), &flight});
    Box local;
    btTransformAabb(box.low, box.high, 0.0f, flight.from.inverse(), local.low, local.high);
    struct Leaves final : btDbvt::ICollide {
        const Call& call;
        const btCompoundShape& compound;
        const Flight& flight;
        Leaves(const Call& to, const btCompoundShape& of, const Flight& with) : call(to), compound(of), flight(with) {}
        void Process(const btDbvtNode* leaf) override {
            const int child = leaf->dataAsInt;
            call(FlyingHull{static_cast<const HullShape*>(compound.getChildShape(child)),
                            compound.getChildTransform(child), &flight});
        }
    } leaves(call, *body.compound, flight);
    const btDbvt& tree = *body.compound->getDynamicAabbTree();
    tree.collideTV(tree.m_root, btDbvtVolume::FromMM(local.low, local.high), leaves);
}

} // namespace

std::span<const StepStops::Stop> StepStops::find(std::span<BodyRecord* const> awake, btScalar seconds,
                                                 btDispatcher& dispatcher) {
    stops_.clear();
    const bool some_fast = std::ranges::any_of(awake, [&](const BodyRecord* body) { return is_fast(*body, seconds); });
    if (some_fast) find_stops(seconds, dispatcher);
    return stops_;
}

void StepStops::find_stops(btScalar seconds, btDispatcher& dispatcher) {
    find_fast(seconds);
    if (fixed_.empty() && wild_.empty()) return; // nothing to pass through
    find_flights(seconds);
    swell_wild(dispatcher);
    for (const uint32_t body : fast_) meet_fixed(body);
    meet_wild();
    add_events(0.0f);
    while (!events_.empty()) {
        std::pop_heap(events_.begin(), events_.end());
        const Event event = events_.back();
        events_.pop_back();
        // What was known of two of which one has stopped since has been looked at anew.
        if (flights_[event.first].stop != event.first_stop || flights_[event.second].stop != event.second_stop)
            continue;
        const bool first = may_be_stopped(event.first, event.second),
                   second = may_be_stopped(event.second, event.first);
        if (first) stop(event.first, event.seconds);
        if (second) stop(event.second, event.seconds);
        if (first) meet_moving(event.first, event.seconds);
        if (second) meet_moving(event.second, event.seconds);
        add_events(event.seconds);
    }
}

bool StepStops::is_fast(const BodyRecord& body, btScalar seconds) {
    return exceeds(way_of(body, seconds), fast_part * body.thickness);
}

void StepStops::find_fast(btScalar seconds) {
    end_ = seconds;
    slow_way_ = 0.0f;
    const auto count = static_cast<uint32_t>(bodies_.size());
    glances_.resize(count);
    threads_.for_chunks(count, min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) glances_[i] = glance_at(*bodies_[i], seconds);
    });
    is_fast_.assign(count, 0);
    is_wild_.assign(count, 0);
    for (std::vector<uint32_t>* list : {&fast_, &wild_, &fixed_}) list->clear();
    const btVector3 common = common_velocity();
    for (uint32_t i = 0; i < count; ++i) {
        const Glance& glance = glances_[i];
        if (glance.fixed) {
            fixed_.push_back(i);
            continue;
        }
        is_wild_[i] = !glance.debris && (glance.linear - common).length() * seconds > glance.wild_way;
        if (is_wild_[i]) wild_.push_back(i);
        is_fast_[i] = glance.fast;
        if (is_fast_[i]) fast_.push_back(i);
        if (!is_wild_[i] && !glance.debris) slow_way_ = std::max(slow_way_, glance.way);
    }
}

void StepStops::find_flights(btScalar seconds) {
    const auto count = static_cast<uint32_t>(bodies_.size());
    flights_.resize(count);
    threads_.for_chunks(count, min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            const BodyRecord& body = *bodies_[i];
            const bool awake = glances_[i].awake;
            flights_[i] = {body.rigid->getWorldTransform(), glances_[i].linear,
                           awake ? body.rigid->getAngularVelocity() : btVector3(0, 0, 0), body.moments,
                           awake ? seconds : 0.0f};
        }
    });
}

void StepStops::swell_wild(btDispatcher& dispatcher) {
    for (const uint32_t i : wild_) {
        const Box box = grown(swept(i), {0, 0, 0}, slow_way_);
        broadphase_.setAabb(bodies_[i]->rigid->getBroadphaseProxy(), box.low, box.high, &dispatcher);
    }
}

StepStops::Glance StepStops::glance_at(const BodyRecord& body, btScalar seconds) {
    const bool awake = body.awake();
    return {.linear = awake ? body.rigid->getLinearVelocity() : btVector3(0, 0, 0),
            .way = awake ? way_of(body, seconds) : 0.0f,
            .wild_way = std::max(half * body.thickness, half * min_way),
            .fixed = body.fixed,
            .awake = awake,
            .debris = body.debris,
            .fast = awake && is_fast(body, seconds)};
}

btVector3 StepStops::common_velocity() const {
    btVector3 sum(0, 0, 0);
    btScalar moving = 0.0f, resting = 0.0f;
    for (const Glance& glance : glances_) {
        if (glance.fixed || glance.debris) continue;
        if (glance.awake)
            sum += glance.linear, moving += 1.0f;
        else
            resting += 1.0f;
    }
    return moving > resting ? sum / moving : btVector3(0, 0, 0);
}

StepStops::Box StepStops::swept(uint32_t body) const {
    const Box box = box_of(*bodies_[body]->collision_shape(), flights_[body].from);
    return grown(box, flights_[body].linear * flights_[body].stop, turning_way(*bodies_[body], flights_[body]));
}

void StepStops::meet_fixed(uint32_t body) {
    if (fixed_.empty()) return;
    const Box box = swept(body);
    for (const uint32_t other : fixed_) {
        const btBroadphaseProxy& proxy = *bodies_[other]->rigid->getBroadphaseProxy();
        if (TestAabbAgainstAabb2(box.low, box.high, proxy.m_aabbMin, proxy.m_aabbMax) && may_touch(body, other, 0.0f))
            kept_.push_back({body, other});
    }
}

void StepStops::meet_moving(uint32_t body, btScalar from) {
    if (wild_.empty()) return;
    near_.clear();
    Collect collect(broadphase_, *bodies_[body]->rigid->getBroadphaseProxy(), near_);
    const Box box = grown(swept(body), {0, 0, 0}, slow_way_);
    broadphase_.aabbTest(box.low, box.high, collect);
    for (const uint32_t other : near_)
        if (may_touch(body, other, from)) kept_.push_back({body, other});
}

void StepStops::meet_wild() {
    if (wild_.empty()) return;
    const std::span<const SweptPairs::Key> keys = broadphase_.find_set();
    const auto count = static_cast<uint32_t>(keys.size());
    std::vector<std::vector<Two>> kept(threads_.chunks(count, min_near));
    threads_.for_chunks(count, min_near, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        for (const SweptPairs::Key key : keys.subspan(begin, end - begin)) {
            const btBroadphaseProxy &a = broadphase_.proxy(key >> 32),
                                    &b = broadphase_.proxy(static_cast<uint32_t>(key));
            if (is_fixed(a) || is_fixed(b)) continue;
            Two two{std::min(index_of(a), index_of(b)), std::max(index_of(a), index_of(b))};
            if (!is_wild_[two.first]) std::swap(two.first, two.second);
            if (may_touch(two.first, two.second, 0.0f)) kept[chunk].push_back(two);
        }
    });
    for (const std::vector<Two>& some : kept) kept_.insert(kept_.end(), some.begin(), some.end());
}

bool StepStops::may_touch(uint32_t first, uint32_t second, btScalar from) const {
    if (!may_be_stopped(first, second) && !may_be_stopped(second, first)) return false;
    const BodyRecord &a = *bodies_[first], &b = *bodies_[second];
    const Flight &flight_a = flights_[first], &flight_b = flights_[second];
    const btScalar turning = turning_way(a, flight_a) + turning_way(b, flight_b);
    const btScalar way = (linear_at(flight_a, from) - linear_at(flight_b, from)).length() * (end_ - from);
    return a.fixed || b.fixed ? exceeds(way + turning, fast_part * std::min(a.thickness, b.thickness))
                              : exceeds(way, half * (a.thickness + b.thickness));
}

void StepStops::add_events(btScalar from) {
    for (const Two& two : kept_) {
        flights_[two.first].find_end();
        flights_[two.second].find_end();
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

StepStops::Event StepStops::event_of(uint32_t first, uint32_t second, btScalar from) const {
    const BodyRecord &a = *bodies_[first], &b = *bodies_[second];
    const Flight &flight_a = flights_[first], &flight_b = flights_[second];
    const btScalar turning_a = turning_way(a, flight_a), turning_b = turning_way(b, flight_b);
    Event event{end_, first, second, flight_a.stop, flight_b.stop};
    const btVector3 way_a = flight_a.linear * flight_a.stop, way_b = flight_b.linear * flight_b.stop;
    // Where hulls of the one must be when the step begins to meet the other.
    visit_hulls(a, flight_a, grown(swept(second), -way_a, turning_a), [&](const FlyingHull& hull) {
        const Box near =
            grown(grown(box_of(*hull.shape, flight_a.from * hull.local), way_a, turning_a), -way_b, turning_b);
        visit_hulls(b, flight_b, near, [&](const FlyingHull& other) {
            if (const auto touch = first_touch(hull, other, from, event.seconds)) event.seconds = *touch;
        });
    });
    return event;
}

void StepStops::stop(uint32_t body, btScalar seconds) {
    flights_[body].stop = seconds;
    flights_[body].find_end();
    stops_.push_back({bodies_[body].get(), seconds});
}

bool StepStops::may_be_stopped(uint32_t body, uint32_t by) const {
    if (!is_fast_[body] || flights_[body].stop < end_) return false;
    if (bodies_[by]->fixed) return true;
    if (bodies_[body]->debris || bodies_[by]->debris) return false;
    return bodies_[by]->reach > crumb_part * bodies_[body]->thickness && !is_light(by, body);
}

bool StepStops::is_light(uint32_t body, uint32_t against) const {
    return !bodies_[body]->fixed && bodies_[body]->mass < light_part * bodies_[against]->mass;
}

} // namespace brittle::physics

#include "physics/bullet/sweep_broadphase.h"

#include <algorithm>
#include <bit>
#include <limits>

#include <LinearMath/btAabbUtil2.h>


namespace brittle::physics {

namespace {

// Another axis is taken when boxes spread by this factor more along it: what is sorted along the old one is lost.
constexpr float worth_another_axis = 1.25f;

constexpr float infinite = std::numeric_limits<float>::infinity();

SweptProxy& swept(btBroadphaseProxy* proxy) {
    return *static_cast<SweptProxy*>(proxy);
}

SweptPairs::Key key_of(uint32_t first, uint32_t second) {
    return static_cast<SweptPairs::Key>(std::min(first, second)) << 32 | std::max(first, second);
}

bool meet(const btBroadphaseProxy& a, const btBroadphaseProxy& b) {
    return (a.m_collisionFilterGroup & b.m_collisionFilterMask) != 0
           && (b.m_collisionFilterGroup & a.m_collisionFilterMask) != 0;
}

} // namespace

void SweptPairs::update(const std::vector<Key>& found, const std::vector<std::unique_ptr<SweptProxy>>& proxies,
                        btDispatcher* dispatcher) {
    next_.resizeNoInitialize(0);
    set_.clear();
    int old = 0;
    // Pairs before a key: those of two boxes that were not set stay.
    const auto pass = [&](Key until) {
        for (; old < pairs_.size(); ++old) {
            btBroadphasePair& pair = pairs_[old];
            const SweptProxy &first = swept(pair.m_pProxy0), &second = swept(pair.m_pProxy1);
            if (!first.gone && !second.gone) {
                if (key_of(first.rank, second.rank) >= until) return;
                if (!first.set && !second.set) {
                    next_.push_back(pair);
                    continue;
                }
            }
            cleanOverlappingPair(pair, dispatcher);
        }
    };
    for (const Key key : found) {
        pass(key);
        set_.push_back(next_.size());
        const auto first = static_cast<uint32_t>(key >> 32), second = static_cast<uint32_t>(key);
        if (old < pairs_.size() && key_of(swept(pairs_[old].m_pProxy0).rank, swept(pairs_[old].m_pProxy1).rank) == key)
            next_.push_back(pairs_[old++]);
        else
            next_.push_back(btBroadphasePair(*proxies[first], *proxies[second]));
    }
    pass(std::numeric_limits<Key>::max());
    std::swap(pairs_, next_);
}

void SweptPairs::cleanOverlappingPair(btBroadphasePair& pair, btDispatcher* dispatcher) {
    if (!pair.m_algorithm || !dispatcher) return;
    pair.m_algorithm->~btCollisionAlgorithm();
    dispatcher->freeCollisionAlgorithm(pair.m_algorithm);
    pair.m_algorithm = nullptr;
}

void SweptPairs::cleanProxyFromPairs(btBroadphaseProxy* proxy, btDispatcher* dispatcher) {
    for (int i = 0; i < pairs_.size(); ++i)
        if (pairs_[i].m_pProxy0 == proxy || pairs_[i].m_pProxy1 == proxy) cleanOverlappingPair(pairs_[i], dispatcher);
}

void SweptPairs::processAllOverlappingPairs(btOverlapCallback* callback, btDispatcher*) {
    for (int i = 0; i < pairs_.size(); ++i) callback->processOverlap(pairs_[i]);
}

void SweptPairs::processAllOverlappingPairs(btOverlapCallback* callback, btDispatcher*, const btDispatcherInfo&) {
    const auto fetch = [this](size_t place) {
        const btBroadphasePair& pair = pairs_[set_[place]];
        for (const void* const at : {static_cast<const void*>(pair.m_algorithm), static_cast<const void*>(pair.m_pProxy1->m_clientObject)})
            for (size_t line = 0; at && line < 5; ++line) __builtin_prefetch(static_cast<const char*>(at) + 64 * line);
    };
    for (size_t i = 0; i < set_.size(); ++i) {
        if (i + 4 < set_.size()) fetch(i + 4);
        callback->processOverlap(pairs_[set_[i]]);
    }
}

bool SweptPairs::needsBroadphaseCollision(btBroadphaseProxy* first, btBroadphaseProxy* second) const {
    return meet(*first, *second);
}

btBroadphasePair* SweptPairs::findPair(btBroadphaseProxy* first, btBroadphaseProxy* second) {
    for (int i = 0; i < pairs_.size(); ++i)
        if (std::minmax(pairs_[i].m_pProxy0, pairs_[i].m_pProxy1) == std::minmax(first, second)) return &pairs_[i];
    return nullptr;
}

void SweepBroadphase::Boxes::resize(size_t count) {
    for (int axis = 0; axis < 3; ++axis) {
        low[static_cast<size_t>(axis)].assign(count + 3, infinite);
        high[static_cast<size_t>(axis)].assign(count + 3, -infinite);
    }
}

void SweepBroadphase::Boxes::set(size_t place, const btVector3& from, const btVector3& to) {
    for (size_t axis = 0; axis < 3; ++axis) {
        low[axis][place] = from[static_cast<int>(axis)];
        high[axis][place] = to[static_cast<int>(axis)];
    }
}

SweepBroadphase::Box4::Box4(const btVector3& from, const btVector3& to) {
    for (size_t axis = 0; axis < 3; ++axis) {
        low[axis] = Float4::all(from[static_cast<int>(axis)]);
        high[axis] = Float4::all(to[static_cast<int>(axis)]);
    }
}

uint32_t SweepBroadphase::Boxes::overlaps(size_t first, const Box4& box) const {
    const auto begins = [&](size_t axis) { return Float4::load(low[axis].data() + first); };
    const auto ends = [&](size_t axis) { return Float4::load(high[axis].data() + first); };
    return all_less_equal(begins(0), box.high[0], begins(1), box.high[1], begins(2), box.high[2])
           & all_less_equal(box.low[0], ends(0), box.low[1], ends(1), box.low[2], ends(2));
}

btBroadphaseProxy* SweepBroadphase::createProxy(const btVector3& low, const btVector3& high, int, void* object,
                                                int group, int mask, btDispatcher*) {
    auto proxy = std::make_unique<SweptProxy>();
    proxy->m_aabbMin = low;
    proxy->m_aabbMax = high;
    proxy->m_clientObject = object;
    proxy->m_collisionFilterGroup = group;
    proxy->m_collisionFilterMask = mask;
    proxy->m_uniqueId = next_uid_++;
    proxy->rank = static_cast<uint32_t>(proxies_.size());
    if (proxies_.empty()) boxes_.resize(0);
    for (size_t axis = 0; axis < 3; ++axis) {
        boxes_.low[axis].push_back(infinite);
        boxes_.high[axis].push_back(-infinite);
    }
    boxes_.set(proxy->rank, low, high);
    proxies_.push_back(std::move(proxy));
    return proxies_.back().get();
}

// Constant in time, so that many can go at once. Bullet has cleaned the proxy's pairs before.
void SweepBroadphase::destroyProxy(btBroadphaseProxy* proxy, btDispatcher*) {
    SweptProxy& leaving = swept(proxy);
    leaving.gone = true;
    boxes_.set(leaving.rank, {infinite, infinite, infinite}, {-infinite, -infinite, -infinite});
    some_gone_ = true;
}

void SweepBroadphase::setAabb(btBroadphaseProxy* proxy, const btVector3& low, const btVector3& high, btDispatcher*) {
    SweptProxy& moved = swept(proxy);
    moved.m_aabbMin = low;
    moved.m_aabbMax = high;
    moved.set = true;
    boxes_.set(moved.rank, low, high);
}

void SweepBroadphase::getAabb(btBroadphaseProxy* proxy, btVector3& low, btVector3& high) const {
    low = proxy->m_aabbMin;
    high = proxy->m_aabbMax;
}

void SweepBroadphase::rayTest(const btVector3& from, const btVector3& to, btBroadphaseRayCallback& callback,
                              const btVector3& low, const btVector3& high) {
    btVector3 start = from, end = from;
    start.setMin(to);
    end.setMax(to);
    start += low;
    end += high;
    const Box4 around(start, end);
    for (size_t first = 0; first < proxies_.size(); first += 4)
        for (uint32_t lanes = boxes_.overlaps(first, around); lanes != 0; lanes &= lanes - 1) {
            const SweptProxy& proxy = *proxies_[first + static_cast<size_t>(std::countr_zero(lanes))];
            const btVector3 bounds[2] = {proxy.m_aabbMin - high, proxy.m_aabbMax - low};
            btScalar where = 0.0f;
            if (btRayAabb2(from, callback.m_rayDirectionInverse, callback.m_signs, bounds, where, 0.0f,
                           callback.m_lambda_max))
                callback.process(&proxy);
        }
}

void SweepBroadphase::aabbTest(const btVector3& low, const btVector3& high, btBroadphaseAabbCallback& callback) {
    const Box4 around(low, high);
    for (size_t first = 0; first < proxies_.size(); first += 4)
        for (uint32_t lanes = boxes_.overlaps(first, around); lanes != 0; lanes &= lanes - 1)
            callback.process(proxies_[first + static_cast<size_t>(std::countr_zero(lanes))].get());
}

void SweepBroadphase::calculateOverlappingPairs(btDispatcher* dispatcher) {
    found_.clear();
    if (!proxies_.empty()) {
        sweep();
        sort_found();
    }
    pairs_.update(found_, proxies_, dispatcher);
    if (some_gone_) forget_gone();
    for (const auto& proxy : proxies_) proxy->set = false;
}

void SweepBroadphase::getBroadphaseAabb(btVector3& low, btVector3& high) const {
    low.setValue(infinite, infinite, infinite);
    high = -low;
    for (const auto& proxy : proxies_) {
        if (proxy->gone) continue;
        low.setMin(proxy->m_aabbMin);
        high.setMax(proxy->m_aabbMax);
    }
}

void SweepBroadphase::forget_gone() {
    std::erase_if(proxies_, [](const auto& proxy) { return proxy->gone; });
    boxes_.resize(proxies_.size());
    for (size_t rank = 0; rank < proxies_.size(); ++rank) {
        proxies_[rank]->rank = static_cast<uint32_t>(rank);
        boxes_.set(rank, proxies_[rank]->m_aabbMin, proxies_[rank]->m_aabbMax);
    }
    still_ranks_.clear(); // they are named anew
    still_.ranks.clear();
    some_gone_ = false;
}

// The axis on which boxes that were set spread most; one that is about as good is kept.
int SweepBroadphase::widest_axis() const {
    btVector3 low(infinite, infinite, infinite), high = -low;
    for (const uint32_t rank : moving_.ranks) {
        const btVector3 middle = 0.5f * (proxies_[rank]->m_aabbMin + proxies_[rank]->m_aabbMax);
        low.setMin(middle);
        high.setMax(middle);
    }
    const btVector3 spread = high - low;
    return spread[spread.maxAxis()] > worth_another_axis * spread[axis_] ? spread.maxAxis() : axis_;
}

void SweepBroadphase::sort(Sorted& sorted) {
    const std::vector<float>& begin = boxes_.low[static_cast<size_t>(axis_)];
    std::ranges::sort(sorted.ranks, [&](uint32_t a, uint32_t b) {
        return begin[a] != begin[b] ? begin[a] < begin[b] : a < b;
    });
    sorted.boxes.resize(sorted.ranks.size());
    for (size_t place = 0; place < sorted.ranks.size(); ++place) {
        const SweptProxy& proxy = *proxies_[sorted.ranks[place]];
        sorted.boxes.set(place, proxy.m_aabbMin, proxy.m_aabbMax);
    }
}

void SweepBroadphase::find_moving() {
    moving_.ranks.clear();
    ranks_.clear();
    for (const auto& proxy : proxies_)
        if (!proxy->gone) (proxy->set ? moving_.ranks : ranks_).push_back(proxy->rank);
    const int axis = widest_axis();
    const bool same = axis == axis_ && ranks_ == still_ranks_;
    axis_ = axis;
    sort(moving_);
    if (same) return;
    std::swap(still_ranks_, ranks_);
    still_.ranks = still_ranks_;
    sort(still_);
}

void SweepBroadphase::sweep() {
    find_moving();
    for (size_t i = 0; i < moving_.ranks.size(); ++i) sweep_one(moving_.ranks[i], moving_, i + 1);
    // A still box that begins where a moving one is, or the other way round.
    const auto axis = static_cast<size_t>(axis_);
    const auto &moving_begin = moving_.boxes.low[axis], &still_begin = still_.boxes.low[axis];
    for (size_t i = 0, from = 0; i < moving_.ranks.size(); ++i) {
        while (from < still_.ranks.size() && still_begin[from] < moving_begin[i]) ++from;
        sweep_one(moving_.ranks[i], still_, from);
    }
    for (size_t i = 0, from = 0; i < still_.ranks.size(); ++i) {
        while (from < moving_.ranks.size() && moving_begin[from] <= still_begin[i]) ++from;
        sweep_one(still_.ranks[i], moving_, from);
    }
}

void SweepBroadphase::sweep_one(uint32_t rank, const Sorted& others, size_t from) {
    const SweptProxy& proxy = *proxies_[rank];
    const std::vector<float>& begin = others.boxes.low[static_cast<size_t>(axis_)];
    const float end = proxy.m_aabbMax[axis_];
    const Box4 box(proxy.m_aabbMin, proxy.m_aabbMax);
    for (size_t first = from; first < others.ranks.size() && begin[first] <= end; first += 4)
        for (uint32_t lanes = others.boxes.overlaps(first, box); lanes != 0; lanes &= lanes - 1) {
            const uint32_t other = others.ranks[first + static_cast<size_t>(std::countr_zero(lanes))];
            if (meet(proxy, *proxies_[other])) found_.push_back(key_of(rank, other));
        }
}

// By counting the lower rank: what is left to compare is the few partners of each.
void SweepBroadphase::sort_found() {
    starts_.assign(proxies_.size() + 1, 0);
    for (const SweptPairs::Key key : found_) ++starts_[(key >> 32) + 1];
    for (size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    scratch_.resize(found_.size());
    for (const SweptPairs::Key key : found_) scratch_[starts_[key >> 32]++] = key;
    // starts_[i] is now where the run of i ends.
    for (size_t i = 0, begin = 0; i < proxies_.size(); begin = starts_[i++])
        std::sort(scratch_.begin() + static_cast<std::ptrdiff_t>(begin),
                  scratch_.begin() + static_cast<std::ptrdiff_t>(starts_[i]));
    std::swap(found_, scratch_);
}

} // namespace brittle::physics

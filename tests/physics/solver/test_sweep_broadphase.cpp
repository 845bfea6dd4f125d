#include "physics/solver/sweep_broadphase.h"

#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <LinearMath/btAabbUtil2.h>
#include <doctest/doctest.h>

using namespace brittle::physics;

namespace {

// A broadphase beside a plain list of what is in it, to compare with.
struct Boxes {
    struct One {
        btBroadphaseProxy* proxy;
        int group, mask;
        float size = 1e18f, min_partner = 0.0f;
    };
    brittle::fracture::Threads threads{2};
    SweepBroadphase sweep{threads};
    std::vector<One> boxes;
    std::map<std::pair<int, int>, int> ages; // of the pairs that overlapped when pairs were last found
    std::mt19937 random{7};

    ~Boxes() {
        while (!boxes.empty()) remove(0);
    }
    float number(float low, float high) { return low + (high - low) * static_cast<float>(random() >> 8) / 16777216.0f; }
    btVector3 corner(float low, float high) {
        btVector3 point(0, 0, 0);
        for (int axis = 0; axis < 3; ++axis) point[axis] = number(low, high);
        return point;
    }

    btBroadphaseProxy* add(const btVector3& low, const btVector3& high, int group = 1, int mask = -1) {
        boxes.push_back({sweep.createProxy(low, high, 0, nullptr, group, mask, nullptr), group, mask});
        return boxes.back().proxy;
    }
    btBroadphaseProxy* add_random(float space, float size, int group = 1, int mask = -1) {
        const btVector3 low = corner(-space, space);
        return add(low, low + corner(0.0f, size), group, mask);
    }
    btBroadphaseProxy* add_sized(float space, float size, float factor) { // of what it meets
        const int group = factor > 0.0f ? btBroadphaseProxy::DebrisFilter : btBroadphaseProxy::DefaultFilter;
        const int mask = factor > 0.0f ? ~btBroadphaseProxy::DebrisFilter : btBroadphaseProxy::AllFilter;
        const btVector3 low = corner(-space, space), sides = corner(0.0f, size);
        const float longest = sides[sides.maxAxis()];
        auto proxy = SweepBroadphase::make_proxy(low, low + sides, nullptr, group, mask, longest, factor * longest);
        boxes.push_back({proxy.get(), group, mask, longest, factor * longest});
        sweep.put_in(std::move(proxy));
        return boxes.back().proxy;
    }
    void move(size_t which, float by) {
        btBroadphaseProxy* proxy = boxes[which].proxy;
        const btVector3 step = corner(-by, by);
        sweep.setAabb(proxy, proxy->m_aabbMin + step, proxy->m_aabbMax + step, nullptr);
    }
    void remove(size_t which) {
        btBroadphaseProxy* proxy = boxes[which].proxy;
        std::erase_if(ages, [&](const auto& pair) {
            return pair.first.first == proxy->m_uniqueId || pair.first.second == proxy->m_uniqueId;
        });
        sweep.getOverlappingPairCache()->cleanProxyFromPairs(proxy, nullptr);
        sweep.destroyProxy(proxy, nullptr);
        boxes.erase(boxes.begin() + static_cast<std::ptrdiff_t>(which));
    }

    // Every pair of boxes that overlap and may meet, by comparing all with all.
    [[nodiscard]] std::map<std::pair<int, int>, int> expected() const {
        std::map<std::pair<int, int>, int> pairs;
        for (size_t i = 0; i < boxes.size(); ++i)
            for (size_t j = 0; j < i; ++j) {
                const btBroadphaseProxy &a = *boxes[j].proxy, &b = *boxes[i].proxy;
                bool overlap = (boxes[i].group & boxes[j].mask) != 0 && (boxes[j].group & boxes[i].mask) != 0;
                overlap = overlap && boxes[i].size >= boxes[j].min_partner && boxes[j].size >= boxes[i].min_partner;
                CHECK(sweep.may_meet(a, b) == overlap);
                CHECK(sweep.may_meet(b, a) == overlap);
                for (int axis = 0; axis < 3; ++axis)
                    overlap =
                        overlap && a.m_aabbMin[axis] <= b.m_aabbMax[axis] && b.m_aabbMin[axis] <= a.m_aabbMax[axis];
                if (overlap) pairs[{a.m_uniqueId, b.m_uniqueId}] = 0;
            }
        return pairs;
    }

    // Finds pairs; they must be the expected ones, ascending, and a pair that was there before the same one still: it
    // counts in what Bullet leaves to its user how often it was found.
    void check() {
        sweep.calculateOverlappingPairs(nullptr);
        std::map<std::pair<int, int>, int> now = expected();
        for (auto& [pair, age] : now)
            if (const auto before = ages.find(pair); before != ages.end()) age = before->second + 1;
        ages = now;
        std::map<std::pair<int, int>, int> found;
        std::pair<int, int> last{-1, -1};
        btBroadphasePairArray& pairs = sweep.getOverlappingPairCache()->getOverlappingPairArray();
        for (int i = 0; i < pairs.size(); ++i) {
            const std::pair<int, int> names{pairs[i].m_pProxy0->m_uniqueId, pairs[i].m_pProxy1->m_uniqueId};
            CHECK(last < names);
            last = names;
            found[names] = pairs[i].m_internalTmpValue++;
        }
        CHECK(found == now);
    }
};

} // namespace

TEST_CASE("a broadphase of nothing has no pairs, and one box has none") {
    Boxes boxes;
    boxes.check();
    boxes.add({0, 0, 0}, {1, 1, 1});
    boxes.check();
    CHECK(boxes.sweep.getOverlappingPairCache()->getNumOverlappingPairs() == 0);
}

TEST_CASE("boxes that are equal, flat, points or touch in a corner overlap") {
    Boxes boxes;
    for (int i = 0; i < 5; ++i) boxes.add({0, 0, 0}, {1, 1, 1});
    boxes.add({1, 1, 1}, {2, 2, 2});
    boxes.add({0, 0, 1}, {1, 1, 1});
    boxes.add({1, 1, 1}, {1, 1, 1});
    boxes.check();
    CHECK(boxes.sweep.getOverlappingPairCache()->getNumOverlappingPairs() == 8 * 7 / 2);
}

TEST_CASE("a box without bounds meets every other, whichever of them moves") {
    Boxes boxes;
    boxes.add({-1e18f, -1e18f, -1e18f}, {1e18f, 1e18f, 1e18f});
    for (int i = 0; i < 30; ++i) boxes.add_random(5.0f, 1.0f);
    boxes.check();
    for (size_t i = 1; i < 10; ++i) boxes.move(i, 3.0f);
    boxes.check();
    CHECK(boxes.sweep.getOverlappingPairCache()->getNumOverlappingPairs() >= 30);
}

TEST_CASE("pairs are those that comparing all with all finds, while boxes move, rest, come and go") {
    Boxes boxes;
    for (int i = 0; i < 150; ++i) boxes.add_random(2.0f, 1.5f);
    for (int round = 0; round < 60; ++round) {
        // All of them, some, or none.
        for (size_t i = 0; i < boxes.boxes.size(); ++i)
            if (round % 4 == 0 || (round % 4 != 3 && boxes.random() % 5 == 0)) boxes.move(i, 0.2f);
        if (round % 3 == 1)
            for (int i = 0; i < 5; ++i) boxes.remove(boxes.random() % boxes.boxes.size());
        if (round % 5 == 2)
            for (int i = 0; i < 8; ++i) boxes.add_random(2.0f, 1.5f);
        boxes.check();
    }
}

TEST_CASE("what spreads along another axis than before is still found") {
    Boxes boxes;
    for (int axis = 0; axis < 3; ++axis) {
        for (int i = 0; i < 40; ++i) {
            btVector3 low = boxes.corner(-0.5f, 0.5f);
            low[axis] *= 40.0f;
            boxes.add(low, low + btVector3(1, 1, 1));
        }
        boxes.check();
        for (size_t i = 0; i < boxes.boxes.size(); i += 2) boxes.move(i, 0.5f);
        boxes.check();
    }
}

TEST_CASE("debris that sleeps is still found where what moves spreads along another axis than before") {
    Boxes boxes;
    const int group = btBroadphaseProxy::DebrisFilter;
    for (int axis = 0; axis < 3; ++axis) {
        for (int i = 0; i < 300; ++i) {
            btVector3 low = boxes.corner(-0.5f, 0.5f);
            low[axis] *= 40.0f;
            const bool debris = i % 2 == 0;
            boxes.add(low, low + btVector3(1, 1, 1), debris ? group : 1, debris ? ~group : -1);
        }
        boxes.check();
        for (size_t i = 1; i < boxes.boxes.size(); i += 2) boxes.move(i, 0.5f); // no debris
        boxes.check();
    }
}

TEST_CASE("boxes meet as their groups say") {
    Boxes boxes;
    for (int i = 0; i < 60; ++i) {
        const int group = 1 << (i % 3);
        boxes.add_random(1.0f, 1.0f, group, i % 2 ? ~group : -1);
    }
    boxes.check();
    for (size_t i = 0; i < boxes.boxes.size(); i += 3) boxes.move(i, 0.5f);
    boxes.check();
}

TEST_CASE("debris meets all but debris, whoever of them moves, rests, comes or goes") {
    Boxes boxes;
    const int group = btBroadphaseProxy::DebrisFilter;
    boxes.add({-1e18f, -1e18f, -1e18f}, {1e18f, 1e18f, 1e18f});
    for (int i = 0; i < 40; ++i) boxes.add_random(2.0f, 1.5f, group, ~group);
    boxes.check(); // nobody else
    for (int i = 0; i < 80; ++i) boxes.add_random(2.0f, 1.5f, i % 2 ? group : 1, i % 2 ? ~group : -1);
    for (int i = 0; i < 5; ++i) boxes.add_random(2.0f, 1.5f, group); // that meets its like
    for (int round = 0; round < 30; ++round) {
        for (size_t i = 1; i < boxes.boxes.size(); ++i) // all, only debris, only the others, some
            if (round % 4 == 0
                || (round % 4 == 3 ? boxes.random() % 5 == 0 : (boxes.boxes[i].group == group) == (round % 4 == 1)))
                boxes.move(i, 0.3f);
        if (round % 3 == 1)
            for (int i = 0; i < 4; ++i) boxes.remove(1 + boxes.random() % (boxes.boxes.size() - 1));
        if (round % 5 == 2)
            for (int i = 0; i < 6; ++i) boxes.add_random(2.0f, 1.5f, i % 2 ? group : 1, i % 2 ? ~group : -1);
        boxes.check();
    }
}

TEST_CASE("boxes that say so meet only what is as large as they ask for, whoever of them moves, rests, comes or goes") {
    Boxes boxes;
    boxes.add({-1e18f, -1e18f, -1e18f}, {1e18f, 1e18f, 1e18f}); // larger than all
    for (int i = 0; i < 120; ++i) boxes.add_sized(1.5f, 1.5f, i % 2 ? 2.0f : 0.0f);
    boxes.check();
    size_t left_out = 0; // that overlap
    for (size_t i = 1; i < boxes.boxes.size(); i += 2)
        for (size_t j = 2; j < boxes.boxes.size(); j += 2) {
            const btBroadphaseProxy &a = *boxes.boxes[i].proxy, &b = *boxes.boxes[j].proxy;
            left_out +=
                !boxes.sweep.may_meet(a, b) && TestAabbAgainstAabb2(a.m_aabbMin, a.m_aabbMax, b.m_aabbMin, b.m_aabbMax);
        }
    CHECK(left_out > 100);
    for (int round = 0; round < 30; ++round) {
        for (size_t i = 1; i < boxes.boxes.size(); ++i)
            if (round % 3 == 0 || (round % 3 == 1 ? boxes.random() % 5 == 0 : i % 2 == 0)) boxes.move(i, 0.3f);
        if (round % 3 == 1)
            for (int i = 0; i < 4; ++i) boxes.remove(1 + boxes.random() % (boxes.boxes.size() - 1));
        if (round % 5 == 2)
            for (int i = 0; i < 6; ++i) boxes.add_sized(1.5f, 1.5f, i % 2 ? 2.0f : 0.0f);
        boxes.check();
    }
}

TEST_CASE("boxes meet only where both are as large as the other asks for") {
    Boxes boxes;
    for (const float asked : {0.0f, 0.5f, 0.9f})
        for (int i = 0; i < 60; ++i) {
            const btVector3 low = boxes.corner(-1.5f, 1.5f), sides = boxes.corner(0.2f, 1.5f);
            const float longest = sides[sides.maxAxis()];
            auto proxy = SweepBroadphase::make_proxy(low, low + sides, nullptr, 1, -1, longest, asked * longest);
            boxes.boxes.push_back({proxy.get(), 1, -1, longest, asked * longest});
            boxes.sweep.put_in(std::move(proxy));
        }
    boxes.check();
    for (size_t i = 0; i < boxes.boxes.size(); i += 3) boxes.move(i, 0.3f);
    boxes.check();
}

TEST_CASE("only pairs with a box that was set are looked at") {
    Boxes boxes;
    for (int i = 0; i < 40; ++i) boxes.add_random(1.0f, 1.0f);
    boxes.check();
    boxes.move(11, 0.1f);
    boxes.check();
    const btBroadphasePair* const pairs = boxes.sweep.pairs().getOverlappingPairArrayPtr();
    for (const int index : boxes.sweep.pairs().set())
        CHECK((pairs[index].m_pProxy0->m_uniqueId == 11 || pairs[index].m_pProxy1->m_uniqueId == 11));
    int of_it = 0;
    for (const auto& [names, age] : boxes.expected()) of_it += names.first == 11 || names.second == 11;
    CHECK(of_it > 0);
    CHECK(boxes.sweep.pairs().set().size() == static_cast<size_t>(of_it));
}

TEST_CASE("boxes that are set after pairs were found are found with all that they overlap") {
    Boxes boxes;
    const int debris = btBroadphaseProxy::DebrisFilter;
    for (int i = 0; i < 200; ++i) boxes.add_random(1.0f, 0.5f, i % 3 ? 1 : debris, i % 3 ? -1 : ~debris);
    boxes.check();
    boxes.remove(31); // its place is taken by others
    for (size_t i = 0; i < 120; ++i) boxes.move(i, 0.3f);
    boxes.check();
    std::set<int> set;
    for (size_t i = 0; i < boxes.boxes.size(); i += 7) { // of those that were set before, and of others
        boxes.move(i, 0.3f);
        set.insert(boxes.boxes[i].proxy->m_uniqueId);
    }
    std::vector<std::pair<int, int>> found, expected;
    for (const SweptPairs::Key key : boxes.sweep.find_set())
        found.emplace_back(boxes.sweep.proxy(key >> 32).m_uniqueId,
                           boxes.sweep.proxy(static_cast<uint32_t>(key)).m_uniqueId);
    for (const auto& [names, age] : boxes.expected())
        if (set.contains(names.first) || set.contains(names.second)) expected.push_back(names);
    CHECK(expected.size() > 20);
    CHECK(found == expected);
    boxes.check(); // and pairs are found as ever
}

TEST_CASE("what boxes reach over others that pass is what hops from pair to pair reach, whether few or many") {
    size_t few = 0, many = 0, alone = 0;
    for (const float size : {0.3f, 0.9f, 1.4f}) {
        Boxes boxes;
        for (int i = 0; i < 300; ++i) boxes.add_random(4.0f, size);
        boxes.check();
        for (int i = 0; i < 30; ++i)
            boxes.remove(static_cast<size_t>(7 * i)); // ranks are not the order in which they came
        boxes.check();
        const auto rank_of = [](const btBroadphaseProxy* proxy) { return static_cast<const SweptProxy*>(proxy)->rank; };
        const auto passes = [](const btBroadphaseProxy& proxy) { return proxy.m_uniqueId % 5 != 0; };
        const btBroadphasePairArray& pairs = boxes.sweep.getOverlappingPairCache()->getOverlappingPairArray();
        for (size_t start = 0; start < boxes.boxes.size(); start += 3) {
            std::set<uint32_t> reached;
            for (const size_t one : {start, (start * 7) % boxes.boxes.size()})
                if (passes(*boxes.boxes[one].proxy)) reached.insert(rank_of(boxes.boxes[one].proxy));
            const std::vector<uint32_t> from(reached.begin(), reached.end());
            std::set<int> kept;
            for (size_t before = SIZE_MAX; before != reached.size() + kept.size();) {
                before = reached.size() + kept.size();
                for (int i = 0; i < pairs.size(); ++i)
                    for (const auto& [one, other] : {std::pair(pairs[i].m_pProxy0, pairs[i].m_pProxy1),
                                                     std::pair(pairs[i].m_pProxy1, pairs[i].m_pProxy0)}) {
                        if (!reached.contains(rank_of(one))) continue;
                        kept.insert(i);
                        if (passes(*other)) reached.insert(rank_of(other));
                    }
            }
            const SweepBroadphase::Reached& found = boxes.sweep.reach(from, passes);
            CHECK(found.ranks == std::vector<uint32_t>(reached.begin(), reached.end()));
            CHECK(found.pairs == std::vector<int>(kept.begin(), kept.end()));
            ++(reached.size() < 3 ? alone : reached.size() < 10 ? few : many);
        }
    }
    CHECK(alone > 20);
    CHECK(few > 20);
    CHECK(many > 20);
}

TEST_CASE("pairs of one box are those that have it, in their order") {
    Boxes boxes;
    for (int i = 0; i < 150; ++i) boxes.add_random(4.0f, 3.0f);
    boxes.add({-9, -9, -9}, {9, 9, 9}); // meets all
    for (int round = 0; round < 4; ++round) {
        boxes.sweep.calculateOverlappingPairs(nullptr);
        const btBroadphaseProxy* const late = boxes.add_random(4.0f, 3.0f);
        SweptPairs& pairs = boxes.sweep.pairs();
        CHECK(pairs.pairs_of(*late).empty()); // until pairs are found
        size_t sum = 0;
        for (const Boxes::One& one : boxes.boxes) {
            std::vector<int> expected;
            for (int i = 0; i < pairs.getNumOverlappingPairs(); ++i) {
                const btBroadphasePair& pair = pairs.getOverlappingPairArrayPtr()[i];
                if (pair.m_pProxy0 == one.proxy || pair.m_pProxy1 == one.proxy) expected.push_back(i);
            }
            CHECK(pairs.pairs_of(*one.proxy) == expected);
            sum += expected.size();
        }
        CHECK(sum == 2 * static_cast<size_t>(pairs.getNumOverlappingPairs()));
        CHECK(sum > 600);
        for (int i = 0; i < 10; ++i) boxes.remove(static_cast<size_t>(7 * i));
    }
}

TEST_CASE("a query finds the boxes that overlap it, those that came since pairs were found among them") {
    Boxes boxes;
    for (int i = 0; i < 50; ++i) boxes.add_random(2.0f, 1.0f);
    boxes.check();
    boxes.remove(13);
    for (int i = 0; i < 5; ++i) boxes.add_random(2.0f, 1.0f);
    struct Met final : btBroadphaseAabbCallback {
        std::vector<int> names;
        bool process(const btBroadphaseProxy* proxy) override {
            names.push_back(proxy->m_uniqueId);
            return true;
        }
    } met;
    const btVector3 low(-0.5f, -0.5f, -0.5f), high(0.7f, 0.7f, 0.7f);
    boxes.sweep.aabbTest(low, high, met);
    std::vector<int> expected;
    for (const auto& box : boxes.boxes) {
        bool overlap = true;
        for (int axis = 0; axis < 3; ++axis)
            overlap = overlap && box.proxy->m_aabbMin[axis] <= high[axis] && low[axis] <= box.proxy->m_aabbMax[axis];
        if (overlap) expected.push_back(box.proxy->m_uniqueId);
    }
    CHECK(expected.size() > 3);
    CHECK(met.names == expected);
}

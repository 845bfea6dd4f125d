#include "physics/solver/sweep_broadphase.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

using namespace brittle::physics;

namespace {

constexpr Bounds everywhere{glm::vec3(-unbounded), glm::vec3(unbounded)};

// Contacts that count how often their pair was found.
struct Age final : PairContacts {
    explicit Age(int& living) : alive(living) { ++alive; }
    ~Age() override { --alive; }
    void update(const ContactStep&) override {}
    void refresh() override {}
    void collect(std::vector<AnyManifold>&) const override {}

    int found = 0;
    int& alive;
};

// A broadphase beside a plain list of its boxes, whose pairs are found by comparing all with all.
struct Boxes {
    struct One {
        SweptProxy* proxy;
        int name; // in the order of addition
    };
    using Names = std::pair<int, int>; // ascending

    int alive = 0; // contacts
    brittle::fracture::Threads threads{2};
    SweepBroadphase sweep{threads};
    std::vector<One> boxes;
    std::map<const SweptProxy*, int> names;
    std::map<Names, int> ages; // of the pairs that overlapped when pairs were last found
    int next_name = 0;
    std::mt19937 random{7};
    float grid = 0.0f; // random coordinates are its multiples, exactly; 0: any

    float number(float low, float high) {
        const float any = low + (high - low) * static_cast<float>(random() >> 8) / 16777216.0f;
        return grid > 0.0f ? grid * std::round(any / grid) : any;
    }
    glm::vec3 corner(float low, float high) {
        glm::vec3 point;
        for (int axis = 0; axis < 3; ++axis) point[axis] = number(low, high);
        return point;
    }

    SweptProxy& add(const SweptProxy& like) {
        auto proxy = std::make_unique<SweptProxy>(like);
        boxes.push_back({proxy.get(), next_name});
        names[proxy.get()] = next_name++;
        sweep.add(std::move(proxy));
        return *boxes.back().proxy;
    }
    SweptProxy& add(const Bounds& bounds, bool fixed = false) {
        return add(SweptProxy{.bounds = bounds, .fixed = fixed});
    }
    SweptProxy& add_random(float space, float size, bool fixed = false) {
        const glm::vec3 low = corner(-space, space);
        return add({low, low + corner(0.0f, size)}, fixed);
    }
    void move(size_t which, float by) {
        SweptProxy& proxy = *boxes[which].proxy;
        const glm::vec3 step = corner(-by, by);
        sweep.set_bounds(proxy, {proxy.bounds.low + step, proxy.bounds.high + step});
    }
    void remove(size_t which) {
        const One one = boxes[which];
        std::erase_if(ages,
                      [&](const auto& pair) { return pair.first.first == one.name || pair.first.second == one.name; });
        sweep.remove(*one.proxy);
        boxes.erase(boxes.begin() + static_cast<std::ptrdiff_t>(which));
    }
    [[nodiscard]] int name_of(const SweptProxy& proxy) const { return names.at(&proxy); }
    [[nodiscard]] Names names_of(const SweptPair& pair) const { return {name_of(*pair.a), name_of(*pair.b)}; }

    // Every pair of boxes that overlap and may collide.
    [[nodiscard]] std::map<Names, int> expected() const {
        std::map<Names, int> pairs;
        for (size_t i = 0; i < boxes.size(); ++i)
            for (size_t j = 0; j < i; ++j) {
                const SweptProxy &a = *boxes[j].proxy, &b = *boxes[i].proxy;
                bool overlap = true;
                for (int axis = 0; axis < 3; ++axis)
                    overlap = overlap && a.bounds.low[axis] <= b.bounds.high[axis]
                              && b.bounds.low[axis] <= a.bounds.high[axis];
                CHECK(a.bounds.overlaps(b.bounds) == overlap);
                if (!(a.fixed && b.fixed) && overlap) pairs[{boxes[j].name, boxes[i].name}] = 0;
            }
        return pairs;
    }

    // Finds pairs, which must be the expected ones in ascending order. A pair that was there before keeps its contacts.
    void check() {
        sweep.find_pairs();
        std::map<Names, int> now = expected();
        for (auto& [pair, age] : now)
            if (const auto before = ages.find(pair); before != ages.end()) age = before->second + 1;
        ages = now;
        std::map<Names, int> found;
        Names last{-1, -1};
        SweptPairs& pairs = sweep.pairs();
        for (uint32_t i = 0; i < pairs.size(); ++i) {
            SweptPair& pair = pairs.at(i);
            CHECK(pair.a->rank < pair.b->rank);
            CHECK(last < names_of(pair));
            last = names_of(pair);
            if (!pair.contacts) pair.contacts = std::make_unique<Age>(alive);
            found[last] = static_cast<Age&>(*pair.contacts).found++;
        }
        CHECK(found == now);
        CHECK(static_cast<size_t>(alive) == now.size());
    }
};

} // namespace

TEST_CASE("broadphase: without boxes and with one box there are no pairs") {
    Boxes boxes;
    boxes.check();
    boxes.add({{0, 0, 0}, {1, 1, 1}});
    boxes.check();
    CHECK(boxes.sweep.pairs().size() == 0);
    boxes.remove(0);
    boxes.check();
    CHECK(boxes.sweep.pairs().size() == 0);
}

TEST_CASE("broadphase: boxes that are equal, flat, single points or touch in a corner overlap") {
    Boxes boxes;
    for (int i = 0; i < 5; ++i) boxes.add({{0, 0, 0}, {1, 1, 1}});
    boxes.add({{1, 1, 1}, {2, 2, 2}});
    boxes.add({{0, 0, 1}, {1, 1, 1}});
    boxes.add({{1, 1, 1}, {1, 1, 1}});
    boxes.check();
    CHECK(boxes.sweep.pairs().size() == 8 * 7 / 2);
}

TEST_CASE("broadphase: an unbounded box overlaps every other, whichever of them moves") {
    Boxes boxes;
    boxes.add(everywhere);
    for (int i = 0; i < 30; ++i) boxes.add_random(5.0f, 1.0f);
    boxes.check();
    for (size_t i = 1; i < 10; ++i) boxes.move(i, 3.0f);
    boxes.check();
    CHECK(boxes.sweep.pairs().size() >= 30);
}

TEST_CASE("broadphase: pairs match a comparison of all with all while boxes move, rest, come and go") {
    for (const float grid : {0.0f, 0.25f}) { // on a grid many boxes begin at equal coordinates
        CAPTURE(grid);
        Boxes boxes;
        boxes.grid = grid;
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
}

TEST_CASE("broadphase: the contacts of a removed box end at once, its pairs with the next search") {
    Boxes boxes;
    for (int i = 0; i < 4; ++i) boxes.add({{0, 0, 0}, {1, 1, 1}});
    boxes.check();
    CHECK(boxes.alive == 6);
    boxes.remove(1);
    CHECK(boxes.alive == 3);
    CHECK(boxes.sweep.pairs().size() == 6);
    boxes.check();
    CHECK(boxes.sweep.pairs().size() == 3);
}

TEST_CASE("broadphase: a change of the axis on which boxes spread most loses no pair") {
    Boxes boxes;
    for (int axis = 0; axis < 3; ++axis) {
        for (int i = 0; i < 40; ++i) {
            glm::vec3 low = boxes.corner(-0.5f, 0.5f);
            low[axis] *= 40.0f;
            boxes.add({low, low + glm::vec3(1.0f)});
        }
        boxes.check();
        for (size_t i = 0; i < boxes.boxes.size(); i += 2) boxes.move(i, 0.5f);
        boxes.check();
    }
}

TEST_CASE("broadphase: a change of the sweep axis loses no pair of resting boxes") {
    Boxes boxes;
    for (int axis = 0; axis < 3; ++axis) {
        for (int i = 0; i < 300; ++i) {
            glm::vec3 low = boxes.corner(-0.5f, 0.5f);
            low[axis] *= 40.0f;
            boxes.add({low, low + glm::vec3(1.0f)}, i % 4 == 0);
        }
        boxes.check();
        for (size_t i = 1; i < boxes.boxes.size(); i += 2) boxes.move(i, 0.5f); // no fixed ones
        boxes.check();
    }
}

TEST_CASE("broadphase: two fixed boxes make no pair, all others do") {
    for (const bool a : {false, true})
        for (const bool b : {false, true}) {
            Boxes boxes;
            boxes.add({{0, 0, 0}, {1, 1, 1}}, a);
            boxes.add({{0, 0, 0}, {1, 1, 1}}, b);
            boxes.check();
            CHECK((boxes.sweep.pairs().size() == 1) == !(a && b));
        }
    Boxes boxes;
    for (int i = 0; i < 90; ++i) boxes.add_random(1.0f, 1.0f, i % 3 == 0);
    boxes.check();
    for (size_t i = 0; i < boxes.boxes.size(); i += 4) boxes.move(i, 0.5f);
    boxes.check();
}

TEST_CASE("broadphase: the pairs to visit are those of the boxes that were set") {
    Boxes boxes;
    for (int i = 0; i < 40; ++i) boxes.add_random(1.0f, 1.0f);
    boxes.check();
    boxes.move(11, 0.1f);
    boxes.check();
    const SweptPairs& pairs = boxes.sweep.pairs();
    CHECK(std::ranges::is_sorted(pairs.set()));
    for (const uint32_t index : pairs.set()) {
        const Boxes::Names names = boxes.names_of(pairs.at(index));
        CHECK((names.first == 11 || names.second == 11));
    }
    size_t expected = 0;
    for (const auto& [names, age] : boxes.expected()) expected += names.first == 11 || names.second == 11;
    CHECK(expected > 0);
    CHECK(pairs.set().size() == expected);
}

TEST_CASE("broadphase: boxes that are set after a search are found with all that they overlap") {
    Boxes boxes;
    for (int i = 0; i < 200; ++i) boxes.add_random(1.0f, 0.5f, i % 3 == 0);
    boxes.check();
    boxes.remove(31); // later boxes move up in rank
    for (size_t i = 0; i < 120; ++i) boxes.move(i, 0.3f);
    boxes.check();
    std::set<int> set;
    for (size_t i = 0; i < boxes.boxes.size(); i += 7) { // some were set before that search, some were not
        boxes.move(i, 0.3f);
        set.insert(boxes.boxes[i].name);
    }
    std::vector<Boxes::Names> found, expected;
    for (const SweptPairs::Key key : boxes.sweep.find_set())
        found.emplace_back(boxes.name_of(boxes.sweep.proxy(static_cast<uint32_t>(key >> 32))),
                           boxes.name_of(boxes.sweep.proxy(static_cast<uint32_t>(key))));
    for (const auto& [names, age] : boxes.expected())
        if (set.contains(names.first) || set.contains(names.second)) expected.push_back(names);
    CHECK(expected.size() > 20);
    CHECK(found == expected);
    boxes.check(); // the next search is right, too
}

TEST_CASE("broadphase: connected boxes match a walk from pair to pair, for few boxes and for many") {
    size_t few = 0, many = 0, alone = 0;
    for (const float size : {0.3f, 0.9f, 1.4f}) {
        Boxes boxes;
        for (int i = 0; i < 300; ++i) boxes.add_random(4.0f, size);
        boxes.check();
        for (int i = 0; i < 30; ++i) boxes.remove(static_cast<size_t>(7 * i)); // ranks differ from names
        boxes.check();
        const auto passes = [&](const SweptProxy& proxy) { return boxes.name_of(proxy) % 5 != 0; };
        const SweptPairs& pairs = boxes.sweep.pairs();
        for (size_t start = 0; start < boxes.boxes.size(); start += 3) {
            std::set<uint32_t> ranks;
            for (const size_t one : {start, (start * 7) % boxes.boxes.size()})
                if (passes(*boxes.boxes[one].proxy)) ranks.insert(boxes.boxes[one].proxy->rank);
            const std::vector<uint32_t> from(ranks.begin(), ranks.end());
            std::set<uint32_t> indices;
            for (size_t before = SIZE_MAX; before != ranks.size() + indices.size();) {
                before = ranks.size() + indices.size();
                for (uint32_t i = 0; i < pairs.size(); ++i)
                    for (const auto& [one, other] :
                         {std::pair(pairs.at(i).a, pairs.at(i).b), std::pair(pairs.at(i).b, pairs.at(i).a)}) {
                        if (!ranks.contains(one->rank)) continue;
                        indices.insert(i);
                        if (passes(*other)) ranks.insert(other->rank);
                    }
            }
            const SweepBroadphase::Connected& found = boxes.sweep.connected(from, passes);
            CHECK(found.ranks == std::vector<uint32_t>(ranks.begin(), ranks.end()));
            CHECK(found.pairs == std::vector<uint32_t>(indices.begin(), indices.end()));
            ++(ranks.size() < 3 ? alone : ranks.size() < 10 ? few : many);
        }
    }
    CHECK(alone > 20);
    CHECK(few > 20);
    CHECK(many > 20);
}

TEST_CASE("broadphase: the pairs of one box, in their order") {
    Boxes boxes;
    for (int i = 0; i < 150; ++i) boxes.add_random(4.0f, 3.0f);
    boxes.add({glm::vec3(-9.0f), glm::vec3(9.0f)}); // overlaps all
    for (int round = 0; round < 4; ++round) {
        boxes.sweep.find_pairs();
        const SweptProxy& late = boxes.add_random(4.0f, 3.0f);
        SweptPairs& pairs = boxes.sweep.pairs();
        CHECK(pairs.pairs_of(late).empty()); // until the next search
        size_t sum = 0;
        for (const Boxes::One& one : boxes.boxes) {
            std::vector<uint32_t> expected;
            for (uint32_t i = 0; i < pairs.size(); ++i)
                if (pairs.at(i).a == one.proxy || pairs.at(i).b == one.proxy) expected.push_back(i);
            CHECK(pairs.pairs_of(*one.proxy) == expected);
            sum += expected.size();
        }
        CHECK(sum == 2 * pairs.size());
        CHECK(sum > 600);
        for (int i = 0; i < 10; ++i) boxes.remove(static_cast<size_t>(7 * i));
    }
}

TEST_CASE("broadphase: a query finds the boxes that overlap it, also those added since the last search") {
    Boxes boxes;
    for (int i = 0; i < 50; ++i) boxes.add_random(2.0f, 1.0f);
    boxes.check();
    boxes.remove(13);
    for (int i = 0; i < 5; ++i) boxes.add_random(2.0f, 1.0f);
    const Bounds query{glm::vec3(-0.5f), glm::vec3(0.7f)};
    std::vector<int> found, expected;
    boxes.sweep.for_each_overlap(query, [&](const SweptProxy& proxy) { found.push_back(boxes.name_of(proxy)); });
    for (const Boxes::One& box : boxes.boxes)
        if (box.proxy->bounds.overlaps(query)) expected.push_back(box.name);
    CHECK(expected.size() > 3);
    CHECK(found == expected);
}

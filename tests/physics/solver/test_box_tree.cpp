// The tree of bounds against a comparison with every box.
#include "physics/solver/box_tree.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>
#include <glm/common.hpp>

#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

Bounds random_box(test::Random& random, float size) {
    const glm::vec3 low(random.point(glm::dvec3(-1.0), glm::dvec3(1.0)));
    return {low, low + size * glm::vec3(random.point(glm::dvec3(0.0), glm::dvec3(1.0)))};
}

std::vector<uint32_t> found(const BoxTree& tree, const Bounds& query) {
    std::vector<uint32_t> indices;
    tree.for_each_overlap(query, [&](uint32_t index) { indices.push_back(index); });
    return indices;
}

// Queries by random boxes, by each of the boxes, by a point, and by a box around all.
void check(const std::vector<Bounds>& boxes) {
    CAPTURE(boxes.size());
    const BoxTree tree(boxes);
    Bounds all = boxes.front();
    for (const Bounds& box : boxes) all = both(all, box);
    CHECK(tree.bounds().low == all.low);
    CHECK(tree.bounds().high == all.high);

    test::Random random(9);
    std::vector<Bounds> queries{all, all.grown({}, 1.0f), {all.low, all.low}, {glm::vec3(50.0f), glm::vec3(51.0f)}};
    for (int i = 0; i < 100; ++i) queries.push_back(random_box(random, i % 2 ? 0.2f : 1.5f));
    for (size_t i = 0; i < boxes.size(); i += 1 + boxes.size() / 50) queries.push_back(boxes[i]);
    for (const Bounds& query : queries) {
        std::vector<uint32_t> expected;
        for (uint32_t i = 0; i < boxes.size(); ++i)
            if (boxes[i].overlaps(query)) expected.push_back(i);
        std::vector<uint32_t> visited = found(tree, query);
        CHECK(found(tree, query) == visited); // a fixed order
        std::ranges::sort(visited);
        CHECK(visited == expected); // each once
    }
}

} // namespace

TEST_CASE("box tree: an empty tree has no overlaps") {
    const Bounds everywhere{glm::vec3(-unbounded), glm::vec3(unbounded)};
    CHECK(found(BoxTree(), everywhere).empty());
    CHECK(found(BoxTree(std::vector<Bounds>{}), everywhere).empty());
}

TEST_CASE("box tree: equal boxes, points and flat boxes are all found") {
    for (const size_t count : {1u, 2u, 3u, 64u, 1000u}) {
        check(std::vector<Bounds>(count, Bounds{glm::vec3(-0.5f), glm::vec3(0.5f)}));
        check(std::vector<Bounds>(count, Bounds{glm::vec3(0.25f), glm::vec3(0.25f)}));
    }
    test::Random random(1);
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<Bounds> flat, in_one_plane;
        for (int i = 0; i < 300; ++i) {
            flat.push_back(random_box(random, 0.5f));
            flat.back().high[axis] = flat.back().low[axis];
            in_one_plane.push_back(flat.back());
            in_one_plane.back().low[axis] = in_one_plane.back().high[axis] = 0.0f;
        }
        check(flat);
        check(in_one_plane);
    }
}

TEST_CASE("box tree: random boxes, few and many, small and large, are found as by a loop over all") {
    test::Random random(2);
    for (const int count : {1, 2, 3, 4, 5, 7, 8, 9, 31, 1000})
        for (const float size : {0.01f, 0.3f, 2.0f}) {
            std::vector<Bounds> boxes;
            for (int i = 0; i < count; ++i) boxes.push_back(random_box(random, size));
            check(boxes);
        }
}

TEST_CASE("box tree: boxes in a row, sorted, reversed and nested in each other") {
    std::vector<Bounds> row, nested;
    for (int i = 0; i < 200; ++i) {
        const auto x = static_cast<float>(i);
        row.push_back({{x, 0, 0}, {x + 1.0f, 1, 1}}); // neighbours touch
        nested.push_back({glm::vec3(-0.01f * x), glm::vec3(0.01f * x)});
    }
    check(row);
    CHECK(found(BoxTree(row), {{10.5f, 0, 0}, {12.0f, 1, 1}}).size() == 3); // 10, 11, and 12 by its face
    std::ranges::reverse(row);
    check(row);
    check(nested);
}

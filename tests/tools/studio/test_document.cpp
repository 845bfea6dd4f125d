#include "tools/brittle/studio/document.h"

#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "fracture/base/random.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"

using namespace brittle;
using namespace brittle::tools;

namespace {

FractureOptions plain() {
    FractureOptions options;
    options.mesh = "shape:cube";
    return options;
}

const std::vector<glm::dvec3> three{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 2.0, 0.0}};
const std::vector<PlacedSite> placed_three = placed_sites({three, {}, {}});

Document with_sites() {
    FractureOptions options = plain();
    options.points = placed_three;
    return Document(options);
}

std::vector<glm::dvec3> sites(const Document& document) {
    std::vector<glm::dvec3> sites;
    for (const PlacedSite& site : document.recipe().points) sites.push_back(site.at);
    return sites;
}

} // namespace

TEST_CASE("document: there is nothing to undo or redo at first, and an edit without effect leaves no trace") {
    Document document(plain());
    CHECK_FALSE(document.undo());
    CHECK_FALSE(document.redo());
    CHECK(document.undo_name().empty());
    CHECK_FALSE(document.apply(SetPattern{document.recipe().pattern}));
    CHECK_FALSE(document.apply(ClearStrikes{}));
    CHECK_FALSE(document.apply(MoveSites{{0, 7}, {1.0, 0.0, 0.0}}));
    CHECK_FALSE(document.apply(RemoveSites{{0}}));
    CHECK_FALSE(document.can_undo());
    CHECK(document.version() == 0);
    CHECK(document.saved());
}

TEST_CASE("document: indices of missing sites are skipped, and the last site stays") {
    Document document = with_sites();
    document.apply(MoveSites{{2, 2, 9, UINT32_MAX}, {0.0, 0.0, 1.0}});
    CHECK(sites(document)[2] == glm::dvec3(0.0, 2.0, 1.0)); // moved once, although it is listed twice
    document.apply(RemoveSites{{0, 1, 2, 3}});
    REQUIRE(sites(document).size() == 1);
    CHECK(sites(document)[0] == glm::dvec3(0.0, 2.0, 1.0));
}

TEST_CASE("document: sites are placed, moved, duplicated, mirrored and deleted") {
    Document document = with_sites();
    document.apply(AddSite{{3.0, 3.0, 3.0}});
    CHECK(sites(document).size() == 4);
    document.apply(DuplicateSites{{3, 0}, {0.5, 0.0, 0.0}});
    CHECK(sites(document)[4] == glm::dvec3(0.5, 0.0, 0.0));
    CHECK(sites(document)[5] == glm::dvec3(3.5, 3.0, 3.0));
    document.apply(MirrorSites{{0, 1}, 0, 0.0}); // the first lies in the plane
    REQUIRE(sites(document).size() == 7);
    CHECK(sites(document)[6] == glm::dvec3(-1.0, 0.0, 0.0));
    document.apply(RemoveSites{{5, 1}});
    CHECK(sites(document).size() == 5);
    CHECK(sites(document)[1] == three[2]);
}

TEST_CASE("document: sites are weighted and grouped, undone by gestures, and copies keep weights and groups") {
    Document document = with_sites();
    const auto points = [&] { return document.recipe().points; };
    CHECK_FALSE(document.apply(SetSiteWeight{{}, 1.0}));
    CHECK_FALSE(document.apply(SetSiteWeight{{0, 1, 2}, 0.0}));
    CHECK_FALSE(document.apply(SetSiteGroup{{9}, 4}));
    document.apply(AddStrike{});
    const uint64_t drag = document.begin_gesture();
    for (int k = 1; k <= 5; ++k) document.apply(SetSiteWeight{{1, 1, 7}, 0.1 * k}, drag);
    CHECK(points()[1].weight == 0.5);
    CHECK(points()[0].weight == 0.0);
    CHECK(document.recipe().strikes.empty());
    document.undo();
    CHECK(points() == placed_three);
    document.redo();
    document.apply(SetSiteWeight{{2}, -1e99});
    CHECK(points()[2].weight == -max_weight);
    document.undo();
    document.apply(SetSiteGroup{{0, 1}, 7});
    CHECK(document.undo_name() == "group sites");
    document.apply(SetSiteGroup{{2}, UINT32_MAX});
    CHECK(points()[2].group == max_group);
    document.undo();
    // Copies and images of one group form a group of their own. A copy of a site without a group has none.
    document.apply(DuplicateSites{{0, 1, 2}, {0.0, 0.0, 1.0}});
    REQUIRE(points().size() == 6);
    CHECK(points()[4].weight == 0.5);
    CHECK(points()[3].group == points()[4].group);
    CHECK(points()[3].group != 0);
    CHECK(points()[3].group != 7);
    CHECK(points()[5].group == 0);
    document.apply(MirrorSites{{1, 3}, 2, -3.0});
    REQUIRE(points().size() == 8);
    CHECK(points()[6].weight == 0.5);
    CHECK(std::set<uint32_t>{7, points()[3].group, points()[6].group, points()[7].group, 0}.size() == 5);
    document.apply(SetSiteGroup{{0, 1, 2, 3, 4, 5, 6, 7}, 0});
    for (const PlacedSite& site : points()) CHECK(site.group == 0);
}

TEST_CASE("document: roughness is set, undone by gestures, brought by a material, and keeps sites and strikes") {
    Document document = with_sites();
    document.apply(AddStrike{});
    const auto rough = [&] { return document.recipe().rough; };
    CHECK_FALSE(document.apply(SetRoughness{rough()}));
    const uint64_t drag = document.begin_gesture();
    for (int k = 1; k <= 5; ++k) document.apply(SetRoughness{{.amount = 0.1 * k, .wavelength = 0.25}}, drag);
    CHECK(document.undo_name() == "change the roughness");
    CHECK(rough().amount == 0.5);
    CHECK(rough().wavelength == 0.25);
    CHECK(sites(document) == three);
    CHECK(document.recipe().strikes.size() == 1);
    document.undo();
    CHECK(rough().is_flat());
    document.redo();
    CHECK(rough().amount == 0.5);
    document.apply(SetMaterial{"wood"});
    CHECK(rough().grain == glm::dvec3(0.0, 4.0, 0.0));
    CHECK(rough().wavelength == 0.25);
    // The grain follows the pattern's axis until it is set by hand.
    fracture::Pattern pattern = document.recipe().pattern;
    pattern.axis = {0.0, 0.0, 1.0};
    document.apply(SetPattern{pattern});
    CHECK(rough().grain == glm::dvec3(0.0, 0.0, 4.0));
    document.apply(SetRoughness{{.amount = 0.5, .grain = {2.0, 0.0, 0.0}}});
    pattern.axis = {0.0, 1.0, 0.0};
    document.apply(SetPattern{pattern});
    CHECK(rough().grain == glm::dvec3(2.0, 0.0, 0.0));
    document.undo();
    document.undo();
    CHECK(rough().grain == glm::dvec3(0.0, 0.0, 4.0));
    document.apply(SetMaterial{"glass"});
    CHECK(rough().is_flat());
    CHECK(rough().grain == glm::dvec3(0.0));
}

TEST_CASE("document: anchors are added, removed by index, undone by strokes, and removed with the mesh") {
    Document document(plain());
    const uint64_t stroke = document.begin_gesture();
    for (int k = 0; k < 3; ++k) document.apply(AddAnchor{{{0.1 * k, 1.0, 0.0}, 0.2}}, stroke);
    const auto anchors = [&] { return document.recipe().world.anchors; };
    REQUIRE(anchors().size() == 3);
    document.apply(RemoveAnchors{{1, 1, 7}});
    REQUIRE(anchors().size() == 2);
    CHECK(anchors()[1] == Anchor{{0.2, 1.0, 0.0}, 0.2});
    CHECK_FALSE(document.apply(RemoveAnchors{{}}));
    document.undo();
    CHECK(anchors().size() == 3);
    document.undo(); // the whole stroke
    CHECK(anchors().empty());
    document.redo();
    document.apply(SetMesh{"shape:torus"});
    CHECK(anchors().empty());
    for (size_t k = 0; k < max_anchors; ++k)
        document.apply(AddAnchor{{{0.0, 1.0 * static_cast<double>(k), 0.0}, 0.1}}, stroke);
    CHECK_THROWS_AS(document.apply(AddAnchor{}), Failure);
    CHECK(anchors().size() == max_anchors);
}

TEST_CASE("document: a pattern replaces sites, sites replace a pattern, and both remove strikes") {
    Document document = with_sites();
    document.apply(AddStrike{{.at = {1.0, 1.0, 1.0}}});
    CHECK(sites(document) == three); // they return when the strike is undone
    document.apply(MoveSites{{0}, {1.0, 0.0, 0.0}});
    CHECK(document.recipe().strikes.empty());
    document.apply(AddStrike{});
    document.apply(SetPattern{{.count = 5}});
    CHECK(document.recipe().strikes.empty());
    CHECK(sites(document).empty());
    document.apply(SetSites{placed_three});
    CHECK(sites(document) == three);
    document.apply(SetMesh{"shape:torus", false});
    CHECK(sites(document).empty());
    CHECK(document.recipe().mesh == "shape:torus");
}

TEST_CASE("document: a material sets its pattern, and an unknown material changes nothing") {
    Document document(plain());
    document.apply(SetMaterial{"wood"});
    CHECK(document.recipe().pattern.kind == fracture::PatternKind::splinters);
    CHECK_THROWS_AS(document.apply(SetMaterial{"cheese"}), Failure);
    CHECK(document.recipe().material == "wood");
    CHECK(document.undo_name() == "change the material");
    document.undo();
    CHECK_FALSE(document.can_undo());
}

TEST_CASE("document: more sites than a recipe can hold are refused") {
    Document document(plain());
    CHECK_THROWS_AS(document.apply(SetSites{std::vector<PlacedSite>(max_points + 1)}), Failure);
    CHECK(sites(document).empty());
}

TEST_CASE("document: the edits of one gesture are one step, which another gesture or an undo ends") {
    Document document = with_sites();
    const uint64_t drag = document.begin_gesture();
    for (int k = 0; k < 10; ++k) document.apply(MoveSites{{1}, {0.0, 0.25, 0.0}}, drag);
    CHECK(sites(document)[1].y == 2.5);
    document.undo();
    CHECK(sites(document) == three);
    document.redo();
    CHECK(sites(document)[1].y == 2.5);
    document.apply(MoveSites{{1}, {0.0, 0.25, 0.0}}, drag); // after undo and redo the edit is a step of its own
    document.undo();
    CHECK(sites(document)[1].y == 2.5);
    const uint64_t next = document.begin_gesture();
    CHECK(next != drag);
    document.apply(MoveSites{{1}, {1.0, 0.0, 0.0}}, next);
    document.apply(AddSite{{9.0, 9.0, 9.0}});
    document.apply(MoveSites{{1}, {1.0, 0.0, 0.0}}, next);
    document.undo();
    document.undo();
    CHECK(sites(document).size() == 3);
    CHECK(sites(document)[1].x == 2.0);
}

TEST_CASE("document: a new edit discards the undone edits") {
    Document document = with_sites();
    document.apply(AddSite{{1.0, 1.0, 1.0}});
    document.undo();
    WorldOptions world;
    world.anchored = true;
    document.apply(SetWorld{world});
    CHECK_FALSE(document.redo());
    CHECK(sites(document).size() == 3);
}

TEST_CASE("document: the picture is not part of the history") {
    Document document = with_sites();
    document.apply(AddSite{{1.0, 1.0, 1.0}});
    document.picture().azimuth = 77.0f;
    document.undo();
    CHECK(document.recipe().picture.azimuth == 77.0f);
    document.redo();
    CHECK(document.recipe().picture.azimuth == 77.0f);
}

TEST_CASE("document: it reports whether it is saved") {
    Document document = with_sites();
    document.apply(AddSite{{1.0, 1.0, 1.0}});
    CHECK_FALSE(document.saved());
    document.mark_saved();
    CHECK(document.saved());
    document.undo();
    CHECK_FALSE(document.saved());
}

TEST_CASE("document: after any edits, undo goes back through every state and redo forth again") {
    for (uint64_t seed = 1; seed <= 20; ++seed) {
        CAPTURE(seed);
        fracture::Random random(seed);
        const auto point = [&] { return glm::dvec3(random.uniform(), random.uniform(), random.uniform()); };
        const auto some = [&] {
            return std::vector{static_cast<uint32_t>(random.uniform() * 8.0),
                               static_cast<uint32_t>(random.uniform() * 8.0)};
        };
        Document document = with_sites();
        std::vector<std::string> states{recipe_json(document.recipe())};
        for (int k = 0; k < 60; ++k) {
            const std::vector<Edit> edits{
                AddSite{point()},
                MoveSites{some(), point()},
                RemoveSites{some()},
                DuplicateSites{some(), point()},
                MirrorSites{some(), static_cast<int>(random.uniform() * 3.0), random.uniform()},
                SetSiteWeight{some(), random.uniform()},
                SetSiteGroup{some(), static_cast<uint32_t>(random.uniform() * 3.0)},
                AddStrike{{.at = point()}},
                SetPattern{{.count = static_cast<uint32_t>(1.0 + random.uniform() * 9.0)}},
                SetMaterial{random.uniform() < 0.5 ? "glass" : ""},
                SetMesh{random.uniform() < 0.5 ? "shape:torus" : "shape:cube", false}};
            if (document.apply(edits[static_cast<size_t>(random.uniform() * static_cast<double>(edits.size()))]))
                states.push_back(recipe_json(document.recipe()));
        }
        for (size_t k = states.size(); k-- > 1;) {
            CHECK(recipe_json(document.recipe()) == states[k]);
            REQUIRE(document.undo());
        }
        CHECK_FALSE(document.can_undo());
        for (size_t k = 0; k + 1 < states.size(); ++k) {
            CHECK(recipe_json(document.recipe()) == states[k]);
            REQUIRE(document.redo());
        }
        CHECK(recipe_json(document.recipe()) == states.back());
    }
}

#include "tools/scenario/recipe/strike.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"

using namespace brittle;
using namespace brittle::tools;
using fracture::PatternKind;

namespace {

fracture::Fragments broken(const fracture::TriangleMesh& mesh, const std::vector<Strike>& strikes,
                           const fracture::Pattern& pattern = {}) {
    const auto sites = strike_sites(strikes, pattern);
    REQUIRE(sites);
    auto fragments = fracture::fracture(mesh, sites->sites, {.groups = sites->groups, .weights = sites->weights});
    REQUIRE(fragments);
    return *std::move(fragments);
}

} // namespace

TEST_CASE("strike: invalid values are refused by name") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto fault_of = [](const Strike& strike) {
        const auto sites = strike_sites(std::vector{Strike{}, strike}, {});
        REQUIRE(!sites);
        CHECK(sites.error().status == fracture::Status::invalid_setting);
        return sites.error().message;
    };
    CHECK(fault_of({.radius = 0.0}).find("strike 1: its radius") == 0);
    CHECK(fault_of({.radius = nan}).find("strike 1: its radius") == 0);
    CHECK(fault_of({.at = {nan, 0.0, 0.0}}).find("strike 1: its point") == 0);
    CHECK(fault_of({.direction = glm::dvec3(0.0)}).find("strike 1: its direction") == 0);
    CHECK(fault_of({.pieces = 0}).find("strike 1: its number of pieces is 0; it must be from 1") == 0);
}

TEST_CASE("strike: no strike gives no sites, and a strike that misses leaves one piece") {
    CHECK(strike_sites({}, {})->sites.empty());
    const fracture::Fragments fragments = broken(fracture::cube(), {{.at = {10.0, 0.0, 0.0}, .radius = 0.5}});
    CHECK(fragments.pieces.size() == 1);
}

TEST_CASE("strike: every pattern breaks the solid near the point, and the rest stays one piece") {
    const fracture::TriangleMesh mesh = fracture::icosphere(3);
    const Strike strike{.at = {0.0, 1.0, 0.0}, .direction = {0.0, -1.0, 0.0}, .radius = 0.4, .pieces = 24};
    for (size_t kind = 0; kind < fracture::pattern_names().size(); ++kind) {
        CAPTURE(fracture::pattern_names()[kind]);
        const fracture::Fragments fragments = broken(mesh, {strike}, {.kind = static_cast<PatternKind>(kind)});
        const fracture::Certificate certificate = fracture::certify(mesh, fragments);
        CHECK(certificate.closed);
        CHECK(certificate.volume_error < 1e-12);
        CHECK(fragments.pieces.size() > 1);
        // One piece holds nearly all of the ball, far from the blow. No other piece reaches beyond 1.6 radii.
        size_t large = 0;
        for (const fracture::Piece& piece : fragments.pieces) {
            if (piece.mass.volume > 0.5 * certificate.volume_input) {
                ++large;
                continue;
            }
            for (const glm::dvec3& p : fragments.positions_of(piece))
                CHECK(glm::distance(p, strike.at) < 1.6 * strike.radius);
        }
        CHECK(large == 1);
    }
}

TEST_CASE("strike: equal strikes give equal pieces, and a second strike breaks another place") {
    const fracture::TriangleMesh mesh = fracture::cube();
    const Strike first{.at = {-1.0, 0.0, 0.0}, .radius = 0.3}, second{.at = {1.0, 0.0, 0.0}, .radius = 0.3};
    const fracture::Fragments one = broken(mesh, {first}), again = broken(mesh, {first}),
                              two = broken(mesh, {first, second});
    CHECK(fracture::hash(one) == fracture::hash(again));
    const auto beyond = [](const fracture::Fragments& fragments) {
        size_t count = 0;
        for (const fracture::Piece& piece : fragments.pieces) count += piece.mass.centre_of_mass.x > 0.5 ? 1 : 0;
        return count;
    };
    CHECK(beyond(one) == 0);
    CHECK(beyond(two) > 2);
}

#include "fracture/certificate.h"
#include "fracture/exact/exact.h"
#include "fracture/shapes.h"
#include "fracture/sites.h"
#include <doctest/doctest.h>
using namespace brittle::fracture;
TEST_CASE("first light") {
    for (uint32_t n : {1u, 2u, 3u, 5u, 10u, 100u, 500u}) {
        const auto mesh = icosphere(4);
        const auto sites = uniform_sites(bounds(mesh), n, 1);
        const auto r = exact::fracture_exact(mesh, sites);
        REQUIRE_MESSAGE(r, (r ? "" : r.error().message));
        const auto c = certify(mesh, *r);
        CHECK(c.closed);
        CHECK(c.volume_error < 1e-12);
        MESSAGE(n, " pieces ", c.pieces, " open ", c.open_pieces, " err ", c.volume_error, " bonds ",
                r->bonds.size());
    }
}

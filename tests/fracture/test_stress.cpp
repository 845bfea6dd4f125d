#include <algorithm>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "fracture/fracture.h"
#include "fracture/io/atomic_file.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tests/fracture/mesh_checks.h"
#include "tools/stress/case.h"
#include "tools/stress/check.h"

using namespace brittle;
using namespace brittle::fracture;

TEST_CASE("every case of the corpus passes the stress checks" * doctest::test_suite("long")) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(BRITTLE_CORPUS "/fractures"))
        files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    REQUIRE(files.size() >= 5);
    for (const auto& file : files) {
        CAPTURE(file);
        const auto c = stress::read_case(file);
        REQUIRE_MESSAGE(c, (c ? std::string() : c.error().message));
        CHECK(stress::complaint(*c) == "");
    }
}

TEST_CASE("random cases of every family pass the stress checks" * doctest::test_suite("long")) {
    for (const std::string_view family : stress::mesh_families()) {
        for (uint64_t seed = 1; seed <= 15; ++seed) {
            CAPTURE(family);
            CAPTURE(seed);
            CHECK(stress::complaint(stress::random_case(seed, family)) == "");
        }
    }
}

TEST_CASE("the checks of the stress driver detect unexpected outcomes") {
    stress::Case c;
    c.mesh = icosphere(1);
    c.sites = uniform_sites(bounds(c.mesh), 5, 1);
    c.generic = true;
    CHECK(stress::complaint(c) == "");
    c.expect = stress::Expect::refusal;
    CHECK(stress::complaint(c) == "not refused");
    c.expect = stress::Expect::pieces;
    c.mesh.triangles.pop_back();
    CHECK(stress::complaint(c).starts_with("refused: "));
}

TEST_CASE("a case is written and read back bit for bit") {
    const test::Folder folder;
    for (uint64_t seed = 1; seed <= 30; ++seed) {
        const stress::Case c = stress::random_case(seed);
        const auto file = folder.path / "case.txt";
        const std::string text = stress::to_text(c);
        REQUIRE(write_file_atomically(file, std::as_bytes(std::span(text))));
        const auto again = stress::read_case(file);
        REQUIRE(again);
        CHECK(stress::to_text(*again) == text);
    }
}

TEST_CASE("more than 65,536 sites are supported") {
    const TriangleMesh ball = icosphere(2);
    const auto sites = uniform_sites(bounds(ball), 70'000, 1);
    const auto fragments = fracture::fracture(ball, sites);
    REQUIRE(fragments);
    const Certificate certificate = certify(ball, *fragments);
    CHECK(certificate.closed);
    CHECK(certificate.volume_error < 1e-12);
    CHECK(certificate.pieces > 25'000);
    CHECK(std::any_of(fragments->pieces.begin(), fragments->pieces.end(),
                      [](const Piece& piece) { return piece.site > 65'536; }));
}

#include "tools/scenario/recipe/placement.h"

#include <cmath>

#include <doctest/doctest.h>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/base/random.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/shapes/shapes.h"

using namespace brittle;
using namespace brittle::tools;

namespace {

// Distance between the images of the corners of a cube, by the placement's definition and by the matrix.
double difference(const ObjectPlacement& placement, const glm::dmat4& transform) {
    double most = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p(corner & 1, corner >> 1 & 1, corner >> 2);
        const glm::dvec3 scaled = placement.scale * p, &h = placement.shear;
        glm::dvec4 at(scaled.x + h.x * scaled.y + h.y * scaled.z, scaled.y + h.z * scaled.z, scaled.z, 1.0);
        glm::dmat4 turn = glm::translate(glm::dmat4(1.0), placement.translation);
        turn = glm::rotate(turn, glm::radians(placement.rotation.z), {0.0, 0.0, 1.0});
        turn = glm::rotate(turn, glm::radians(placement.rotation.y), {0.0, 1.0, 0.0});
        turn = glm::rotate(turn, glm::radians(placement.rotation.x), {1.0, 0.0, 0.0});
        most = std::max(most, glm::length(turn * at - transform * glm::dvec4(p, 1.0)));
    }
    return most;
}

} // namespace

TEST_CASE("placement: a transform that flattens, or is not finite or out of range, has none") {
    CHECK_FALSE(placement_of(glm::dmat4(0.0)));
    for (int axis = 0; axis < 3; ++axis) {
        glm::dmat4 flat(1.0);
        flat[axis][axis] = 0.0;
        CHECK_FALSE(placement_of(flat));
        flat[axis][axis] = NAN;
        CHECK_FALSE(placement_of(flat));
        flat[axis][axis] = 1e10;
        CHECK_FALSE(placement_of(flat));
    }
    glm::dmat4 folded(1.0);
    folded[2] = folded[0] + folded[1];
    CHECK_FALSE(placement_of(folded));
}

TEST_CASE("placement: a rotated, scaled and mirrored transform has no shear, at 90 degrees about Y too") {
    CHECK(placement_of(glm::dmat4(1.0)) == ObjectPlacement{});
    for (const double y : {-90.0, -89.9999999, -30.0, 0.0, 60.0, 90.0})
        for (const double x : {0.0, 25.0, -170.0}) {
            glm::dmat4 transform = glm::translate(glm::dmat4(1.0), {3.0, -4.0, 5.0});
            transform = glm::rotate(transform, glm::radians(80.0), {0.0, 0.0, 1.0});
            transform = glm::rotate(transform, glm::radians(y), {0.0, 1.0, 0.0});
            transform = glm::rotate(transform, glm::radians(x), {1.0, 0.0, 0.0});
            for (const glm::dvec3& scale : {glm::dvec3(1.0), {0.5, 2.0, 3.0}, {-1.0, 1.0, 1.0}, {-2.0, -1.0, -3.0}}) {
                const glm::dmat4 scaled = glm::scale(transform, scale);
                const std::optional<ObjectPlacement> placement = placement_of(scaled);
                REQUIRE(placement);
                CHECK(placement->shear == glm::dvec3(0.0));
                CHECK(glm::abs(placement->scale) == glm::abs(scale)); // to the last bit
                CHECK((placement->scale.x * placement->scale.y * placement->scale.z < 0.0)
                      == (scale.x * scale.y * scale.z < 0.0));
                CHECK(difference(*placement, scaled) < 1e-11);
            }
        }
}

TEST_CASE("placement: any other affine transform is kept by its shear, and linear_part() gives it back") {
    fracture::Random random(5);
    for (int round = 0; round < 200; ++round) {
        glm::dmat4 transform(1.0);
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 3; ++row) transform[column][row] = 4.0 * random.uniform() - 2.0;
        const std::optional<ObjectPlacement> placement = placement_of(transform);
        REQUIRE(placement);
        CHECK(placement->shear != glm::dvec3(0.0));
        CHECK(difference(*placement, transform) < 1e-10);
        const glm::dmat3 linear = linear_part(*placement);
        for (int axis = 0; axis < 3; ++axis) CHECK(glm::length(linear[axis] - glm::dvec3(transform[axis])) < 1e-10);

        fracture::TriangleMesh mesh = fracture::cuboid({1.0, 2.0, 3.0});
        deform(mesh, 0.5, *placement);
        CHECK(fracture::signed_volume(mesh.positions, mesh.triangles)
              == doctest::Approx(6.0 / 8.0 * std::abs(glm::determinant(linear)))); // positive: outside out
    }
}

TEST_CASE("placement: shear that is rounding of single precision is none") {
    const glm::quat single = glm::normalize(glm::quat(0.3f, -0.5f, 0.7f, 0.2f)); // a unit to seven digits
    const glm::dmat4 transform(glm::mat4(glm::mat3_cast(single)));
    const std::optional<ObjectPlacement> placement = placement_of(transform);
    REQUIRE(placement);
    CHECK(placement->shear == glm::dvec3(0.0));
    CHECK(glm::length(placement->scale - 1.0) < 1e-6);
    CHECK(difference(*placement, transform) < 1e-6);
}

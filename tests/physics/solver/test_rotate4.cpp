#include "physics/solver/rotate4.h"

#include <array>
#include <bit>
#include <cstdint>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

std::array<uint32_t, 3> bits(const glm::vec3& v) {
    return std::bit_cast<std::array<uint32_t, 3>>(v);
}

} // namespace

TEST_CASE("rotate4: four vectors rotated at once equal glm rotating each alone, bit for bit, with the signs of zeros") {
    test::Random random(9);
    const auto number = [&] {
        const double one = random.uniform(-1.0, 1.0);
        return static_cast<float>(one > 0.8 ? 0.0 : one < -0.8 ? -0.0 : one * (one > 0.6 ? 1e6 : 1.0));
    };
    for (int i = 0; i < 500; ++i) {
        glm::quat rotation(number(), number(), number(), number());
        if (i % 10 == 0) rotation = glm::quat(1.0f, 0.0f, 0.0f, 0.0f);
        if (i % 10 == 1) rotation = glm::quat(0.0f, -0.0f, 1.0f, 0.0f);
        std::array<glm::vec3, 4> v;
        for (glm::vec3& one : v) one = {number(), number(), number()};
        const Vector4 four = rotated(rotation, Vector4::of(v[0], v[1], v[2], v[3]));
        std::array<float, 4> x, y, z;
        four.x.store(x.data()), four.y.store(y.data()), four.z.store(z.data());
        for (size_t lane = 0; lane < 4; ++lane) CHECK(bits({x[lane], y[lane], z[lane]}) == bits(rotation * v[lane]));
    }
}

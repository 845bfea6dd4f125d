#include "physics/bonds/rewound_contacts.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

namespace brittle::physics {

namespace {

constexpr int sweeps = 20;

constexpr uint32_t fixed_body = 0; // index of the entry that stands for every fixed body

struct MovedBody {
    BodyId id;
    glm::vec3 centre{0.0f};
    glm::vec3 linear{0.0f}, angular{0.0f};
    float inverse_mass = 0.0f;
    glm::mat3 inverse_inertia{0.0f}; // world axes
};

// The contact's row. An impulse of 1 N s changes the spins by the turns.
struct Row {
    size_t contact;
    uint32_t a, b;
    glm::vec3 normal, arm_a, arm_b; // arm x normal
    glm::vec3 turn_a, turn_b;       // 1/(kg m)
    float inverse_mass_a, inverse_mass_b;
    float effective_mass; // kg
    float closing, max_impulse;
    float impulse = 0.0f;
};

class Rows {
  public:
    Rows(const World& world, std::span<const RewoundContact> contacts) {
        std::vector<BodyId> ids;
        for (const RewoundContact& contact : contacts)
            for (const BodyId id : {contact.a, contact.b})
                if (world.contains(id) && !world.fixed(id)) ids.push_back(id);
        std::ranges::sort(ids);
        ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
        bodies_.emplace_back();
        for (const BodyId id : ids)
            bodies_.push_back({id, world.pose(id).position, world.linear_velocity(id), world.angular_velocity(id),
                               1.0f / world.mass(id), world.inverse_inertia(id)});
        const auto index_of = [&](BodyId id) {
            const auto at = std::ranges::lower_bound(ids, id);
            return at != ids.end() && *at == id ? static_cast<uint32_t>(at - ids.begin()) + 1 : fixed_body;
        };
        for (size_t i = 0; i < contacts.size(); ++i)
            add(i, contacts[i], index_of(contacts[i].a), index_of(contacts[i].b));
        std::stable_partition(rows_.begin(), rows_.end(),
                              [](const Row& row) { return row.a != fixed_body && row.b != fixed_body; });
    }

    void sweep() {
        for (Row& row : rows_) {
            MovedBody &a = bodies_[row.a], &b = bodies_[row.b];
            const float approach = glm::dot(row.normal, b.linear - a.linear) + glm::dot(row.arm_b, b.angular)
                                   - glm::dot(row.arm_a, a.angular) - row.closing;
            const float before = std::exchange(
                row.impulse, std::clamp(row.impulse + approach * row.effective_mass, 0.0f, row.max_impulse));
            const float change = row.impulse - before;
            a.linear += (change * row.inverse_mass_a) * row.normal;
            b.linear -= (change * row.inverse_mass_b) * row.normal;
            a.angular += change * row.turn_a;
            b.angular -= change * row.turn_b;
        }
    }

    void write(World& world, std::span<RewoundContact> contacts) const {
        for (const Row& row : rows_) contacts[row.contact].impulse = row.impulse;
        for (const MovedBody& body : std::span(bodies_).subspan(1))
            world.set_velocity(body.id, body.linear, body.angular);
    }

  private:
    void add(size_t index, const RewoundContact& contact, uint32_t a, uint32_t b) {
        const glm::vec3& normal = contact.normal;
        const glm::vec3 arm_a = glm::cross(contact.point - bodies_[a].centre, normal),
                        arm_b = glm::cross(contact.point - bodies_[b].centre, normal);
        const glm::vec3 turn_a = bodies_[a].inverse_inertia * arm_a, turn_b = bodies_[b].inverse_inertia * arm_b;
        const float response =
            bodies_[a].inverse_mass + glm::dot(turn_a, arm_a) + bodies_[b].inverse_mass + glm::dot(turn_b, arm_b);
        if (!(response > 0.0f)) return;
        rows_.push_back({index, a, b, normal, arm_a, arm_b, turn_a, turn_b, bodies_[a].inverse_mass,
                         bodies_[b].inverse_mass, 1.0f / response, contact.closing, contact.max_impulse});
    }

    std::vector<MovedBody> bodies_; // the first stands for every fixed body
    std::vector<Row> rows_;
};

} // namespace

void solve_rewound(World& world, std::span<RewoundContact> contacts) {
    for (RewoundContact& contact : contacts) contact.impulse = 0.0f;
    Rows rows(world, contacts);
    for (int i = 0; i < sweeps; ++i) rows.sweep();
    rows.write(world, contacts);
}

} // namespace brittle::physics

#include "fracture/io/rigid_body_json.h"

#include <glm/gtc/quaternion.hpp>

#include "fracture/mesh/principal_axes.h"

namespace brittle::fracture {

nlohmann::ordered_json rigid_body_json(const MassProperties& mass, double density, std::optional<size_t> mesh) {
    nlohmann::ordered_json json;
    nlohmann::ordered_json& motion = json["motion"] = nlohmann::ordered_json::object();
    if (const double kilograms = mass.volume * density; kilograms > 0.0) {
        const PrincipalAxes principal = principal_axes(mass.inertia);
        const glm::dquat turn = glm::normalize(glm::quat_cast(principal.axes));
        const glm::dvec3 moments = principal.moments * density;
        motion = {{"mass", kilograms},
                  {"inertiaDiagonal", {moments.x, moments.y, moments.z}},
                  {"inertiaOrientation", {turn.x, turn.y, turn.z, turn.w}}};
    }
    if (mesh) json.update(collider_json(*mesh));
    return json;
}

nlohmann::ordered_json collider_json(size_t mesh) {
    nlohmann::ordered_json json;
    json["collider"]["geometry"] = {{"mesh", mesh}, {"convexHull", true}};
    return json;
}

nlohmann::ordered_json surface_collider_json(size_t mesh) {
    nlohmann::ordered_json json;
    json["collider"]["geometry"] = {{"mesh", mesh}};
    return json;
}

} // namespace brittle::fracture

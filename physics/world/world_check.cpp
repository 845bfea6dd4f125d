#include "physics/world/world_check.h"

#include <algorithm>
#include <limits>
#include <span>

#include "physics/world/piece_mass.h"

namespace brittle::physics {

namespace {

// Least ratio of a body's smallest to its largest principal moment. Below it, the single-precision rows of a needle
// that spins about its own axis diverge.
constexpr double min_moment_ratio = 1e-4;
constexpr float min_joint_length = 1e-3f; // m; a shorter rope or rod has no steady direction

fracture::Error bad_setting(std::string message) {
    return {fracture::Status::invalid_setting, std::move(message)};
}

std::string fault_of(const CollisionHull& hull) {
    if (hull.points.size() < 4) return text("its hull has ", hull.points.size(), " points, at least 4 are needed");
    glm::vec3 none(0.0f); // becomes NaN if a point is not finite; avoids a branch per point
    for (const glm::vec3& point : hull.points) none += point - point;
    for (size_t i = 0; none != glm::vec3(0.0f) && i < hull.points.size(); ++i)
        if (!finite(hull.points[i])) return text("point ", i, " of its hull is not finite");
    if (!(hull.margin > 0.0f) || !std::isfinite(hull.margin))
        return text("its hull's margin is ", hull.margin, " m, it must be positive");
    return {};
}

std::string fault_of(std::span<const BodyPart> parts) {
    for (size_t i = 0; i < parts.size(); ++i) {
        if (!parts[i].hull) return text("its part ", i, " has no hull");
        if (!finite(parts[i].offset)) return text("the offset of its part ", i, " is not finite");
        if (const std::string fault = fault_of(*parts[i].hull); !fault.empty()) return text("part ", i, ": ", fault);
    }
    return {};
}

// Raises moments below min_moment_ratio of the largest. Returns what is wrong, or an empty string.
std::string settle_moments(glm::dvec3& moments) {
    const double largest = std::max({moments.x, moments.y, moments.z});
    const double smallest = std::min({moments.x, moments.y, moments.z});
    const double sum = moments.x + moments.y + moments.z;
    if (!(largest >= min_moment && largest <= greatest_moment) || smallest < -moment_slack * largest
        || 2.0 * largest > sum * (1.0 + moment_slack))
        return text("no body has the principal moments of inertia ", moments.x, ", ", moments.y, ", ", moments.z,
                    " kg m^2");
    moments = glm::max(moments, glm::dvec3(largest * min_moment_ratio));
    return {};
}

} // namespace

std::string fault_of_form(const BodyDesc& desc, fracture::PrincipalAxes& principal) {
    if (std::string fault = desc.parts.empty() ? fault_of(desc.hull) : fault_of(desc.parts); !fault.empty())
        return fault;
    if (!(desc.mass >= min_mass && desc.mass <= greatest_mass))
        return text("its mass is ", desc.mass, " kg; it must be between ", min_mass, " and ", greatest_mass, " kg");
    for (int column = 0; column < 3 && !desc.fixed; ++column)
        if (!finite(desc.inertia[column])) return "its inertia tensor is not finite";
    if (desc.fixed) return {};
    principal = fracture::principal_axes(glm::dmat3(desc.inertia));
    return settle_moments(principal.moments);
}

std::string fault_of_place(const BodyDesc& desc) {
    if (!finite(desc.pose.position) || !finite(desc.linear_velocity) || !finite(desc.angular_velocity))
        return "its position or velocity is not finite";
    const Pose previous = desc.previous.value_or(desc.pose);
    if (!finite(previous.position)) return "its previous position is not finite";
    if (!std::isnormal(glm::dot(desc.pose.orientation, desc.pose.orientation))
        || !std::isnormal(glm::dot(previous.orientation, previous.orientation)))
        return "its orientation is no rotation (a quaternion of zero or non-finite length)";
    if (!(desc.friction >= 0.0f) || !(desc.restitution >= 0.0f) || !(desc.restitution <= 1.0f)
        || !std::isfinite(desc.friction))
        return text("its friction ", desc.friction, " or restitution ", desc.restitution,
                    " is out of range (0 or more; 0 to 1)");
    return {};
}

std::string fault_of(const JointDesc& desc) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    if (!finite(desc.anchor_a)) return "its anchor_a is not finite";
    if (!(desc.max_force > 0.0f)) return text("its max_force is ", desc.max_force, " N; it must be above 0");
    if (!(desc.max_torque > 0.0f)) return text("its max_torque is ", desc.max_torque, " N m; it must be above 0");
    const bool has_axis = desc.kind == JointKind::hinge || desc.kind == JointKind::fixed;
    if (has_axis && !(finite(desc.axis) && std::isnormal(glm::dot(desc.axis, desc.axis))))
        return text("its axis (", desc.axis.x, ", ", desc.axis.y, ", ", desc.axis.z,
                    ") is no direction; give a finite vector with a length");
    if (desc.kind != JointKind::distance) return {};
    if (!finite(desc.anchor_b)) return "its anchor_b is not finite";
    if (!(desc.min_length >= 0.0f && desc.min_length < infinity))
        return text("its min_length is ", desc.min_length, " m; it must be 0 or more, and finite");
    if (!(desc.max_length >= min_joint_length && desc.max_length >= desc.min_length))
        return text("its max_length is ", desc.max_length, " m; it must be at least ", min_joint_length,
                    " m and not below min_length, ", desc.min_length, " m");
    if (desc.min_length == 0.0f && desc.max_length == infinity)
        return "it has neither a min_length nor a max_length, and holds nothing; give one of them";
    return {};
}

Result<void> validate(const WorldSettings& settings) {
    const auto outside = [](const char* field, float value, const char* range) {
        return bad_setting(text("world setting ", field, " is ", value, "; it must be ", range));
    };
    const auto in = [](float value, float low, float high) { return value >= low && value <= high; };
    constexpr float far = 1e6f;
    if (!finite(settings.gravity)) return bad_setting("world setting gravity has a component that is not finite");
    if (!in(settings.step, 1e-5f, 0.1f)) return outside("step", settings.step, "between 0.00001 and 0.1 s");
    if (settings.max_substeps < 1 || settings.max_substeps > 1000)
        return outside("max_substeps", static_cast<float>(settings.max_substeps), "between 1 and 1000");
    if (settings.solver_substeps < 1 || settings.solver_substeps > 1000)
        return outside("solver_substeps", static_cast<float>(settings.solver_substeps), "between 1 and 1000");
    if (settings.ground_height && !in(*settings.ground_height, -far, far))
        return outside("ground_height", *settings.ground_height, "between -1000000 and 1000000 m");
    if (!in(settings.ground_friction, 0.0f, far))
        return outside("ground_friction", settings.ground_friction, "0 or more");
    if (!in(settings.ground_restitution, 0.0f, 1.0f))
        return outside("ground_restitution", settings.ground_restitution, "between 0 and 1");
    if (!in(settings.linear_damping, 0.0f, 1.0f))
        return outside("linear_damping", settings.linear_damping, "between 0 and 1");
    if (!in(settings.angular_damping, 0.0f, 1.0f))
        return outside("angular_damping", settings.angular_damping, "between 0 and 1");
    if (!in(settings.air_density, 0.0f, far)) return outside("air_density", settings.air_density, "0 kg/m^3 or more");
    if (!in(settings.separation_speed, 0.0f, far))
        return outside("separation_speed", settings.separation_speed, "0 m/s or more");
    if (!in(settings.debris_size, 0.0f, far)) return outside("debris_size", settings.debris_size, "0 m or more");
    if (!in(settings.sleep_linear_speed, 0.0f, far))
        return outside("sleep_linear_speed", settings.sleep_linear_speed, "0 m/s or more");
    if (!in(settings.sleep_angular_speed, 0.0f, far))
        return outside("sleep_angular_speed", settings.sleep_angular_speed, "0 rad/s or more");
    if (!in(settings.sleep_seconds, 0.0f, far)) return outside("sleep_seconds", settings.sleep_seconds, "0 s or more");
    return {};
}

} // namespace brittle::physics

#include "tools/scenario/run/action.h"

#include <cstdio>

#include "physics/world/magnitude.h"

namespace brittle::tools {

namespace {

constexpr auto largest = static_cast<double>(physics::max_magnitude);

// Collects the first fault of an action's fields.
struct Check {
    size_t piece_count;
    std::string fault;

    void vector(const char* name, const glm::dvec3& v) {
        for (int axis = 0; axis < 3; ++axis)
            number((std::string(name) + "/" + std::to_string(axis)).c_str(), v[axis], -largest, largest);
    }
    void number(const char* name, double value, double low, double high) {
        if (!fault.empty() || (value >= low && value <= high)) return;
        char text[120];
        std::snprintf(text, sizeof text, "%s is %g; it must be from %g to %g", name, value, low, high);
        fault = text;
    }
    void piece(uint32_t index) {
        if (fault.empty() && index >= piece_count)
            fault =
                "piece is " + std::to_string(index) + ", but the number of pieces is " + std::to_string(piece_count);
    }

    void operator()(const Shoot& a) {
        vector("from", a.from);
        vector("velocity", a.velocity);
        number("radius", a.radius, 0.001, 10.0);
        number("density", a.density, 1.0, 1e5);
    }
    void operator()(const Damage& a) {
        vector("point", a.point);
        number("radius", a.radius, 0.0, 1e4);
        number("amount", a.amount, 0.0, 1e6);
    }
    void operator()(const Saw& a) {
        vector("from", a.from);
        vector("to", a.to);
        number("radius", a.radius, 0.0, 1e4);
        number("amount", a.amount, 0.0, 1e6);
    }
    void operator()(const Hammer& a) {
        piece(a.piece);
        vector("point", a.point);
        vector("impulse", a.impulse);
    }
    void operator()(const Release& a) {
        for (const uint32_t p : a.pieces) piece(p);
    }
    void operator()(const Push& a) {
        piece(a.piece);
        vector("point", a.point);
        vector("impulse", a.impulse);
    }
    void operator()(const Grab& a) {
        piece(a.piece);
        vector("point", a.point);
    }
    void operator()(const Drag& a) { vector("to", a.to); }
    void operator()(const LetGo&) {}
    void operator()(const Watch& a) {
        vector("eye", a.eye);
        vector("target", a.target);
        number("fov", a.fov, 1e-3, 3.0);
        number("aspect", a.aspect, 1e-3, 1e3);
    }
};

} // namespace

std::string fault_of(const Action& action, size_t piece_count) {
    Check check{piece_count, {}};
    std::visit(check, action);
    return check.fault;
}

} // namespace brittle::tools

#include "physics/solver/ray_cast.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "physics/solver/float4.h"
#include "physics/world/engine.h"

namespace brittle::physics {

namespace {

// Rays that share a search for bodies near them.
constexpr size_t group_size = 16;
// Bounding spheres and boxes are larger by this share, more than the rounding of single precision.
constexpr double rounding = 1e-5;

Bounds bounds_of(const Ray& ray) {
    return {glm::min(ray.from, ray.to), glm::max(ray.from, ray.to)};
}

// The rays that can be cast, in an order in which neighbours are near each other: along a curve that visits the cells of
// a grid octant by octant (G. M. Morton, 1966).
std::vector<uint32_t> in_order(std::span<const Ray> rays) {
    std::optional<Bounds> around;
    for (const Ray& ray : rays)
        if (can_be_cast(ray)) around = around ? both(*around, bounds_of(ray)) : bounds_of(ray);
    std::vector<uint64_t> keys; // place on the curve, then index
    for (uint32_t i = 0; i < rays.size(); ++i) {
        if (!can_be_cast(rays[i])) continue;
        uint64_t place = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double low = static_cast<double>(around->low[axis]),
                         size = static_cast<double>(around->high[axis]) - low;
            const double middle =
                0.5 * (static_cast<double>(rays[i].from[axis]) + static_cast<double>(rays[i].to[axis]));
            const auto cell = static_cast<uint32_t>(size > 0.0 ? (middle - low) / size * 255.0 : 0.0);
            for (uint32_t bit = 0; bit < 8; ++bit)
                place |= uint64_t{cell >> bit & 1} << (3 * bit + static_cast<uint32_t>(axis));
        }
        keys.push_back(place << 32 | i);
    }
    std::ranges::sort(keys);
    std::vector<uint32_t> order;
    for (const uint64_t key : keys) order.push_back(static_cast<uint32_t>(key));
    return order;
}

// The bodies near some rays, in body order, with boxes around them as arrays of coordinates: four are compared at a time.
// Boxes that overlap nothing fill up the last four.
class NearBodies {
  public:
    // Precondition: `strays` is in body order.
    void find(const SweepBroadphase& broadphase, std::span<const Body* const> strays, const Bounds& box) {
        bodies_.clear();
        broadphase.for_each_overlap(box, [&](const SweptProxy& proxy) {
            if (proxy.body) bodies_.push_back(proxy.body);
        });
        bodies_.insert(bodies_.end(), strays.begin(), strays.end());
        if (!strays.empty()) {
            std::ranges::sort(bodies_, {}, [](const Body* body) { return body->index; });
            bodies_.erase(std::unique(bodies_.begin(), bodies_.end()), bodies_.end());
        }
        for (size_t axis = 0; axis < 3; ++axis) {
            low_[axis].clear();
            high_[axis].clear();
        }
        for (const Body* body : bodies_) {
            const bool strayed = std::ranges::find(strays, body) != strays.end();
            add(strayed ? widened(body->bounds(body->frame)) : body->proxy->bounds);
        }
        constexpr float infinite = std::numeric_limits<float>::infinity();
        while (low_[0].size() % 4 != 0) add({glm::vec3(infinite), glm::vec3(-infinite)});
    }

    // Calls visit for each body whose box overlaps the given one.
    void for_each_overlap(const Bounds& box, const auto& visit) const {
        std::array<Float4, 3> low, high;
        for (size_t axis = 0; axis < 3; ++axis) {
            low[axis] = Float4::all(box.low[static_cast<int>(axis)]);
            high[axis] = Float4::all(box.high[static_cast<int>(axis)]);
        }
        for (size_t first = 0; first < low_[0].size(); first += 4) {
            const auto begins = [&](size_t axis) { return Float4::load(low_[axis].data() + first); };
            const auto ends = [&](size_t axis) { return Float4::load(high_[axis].data() + first); };
            uint32_t lanes = all_less_equal(begins(0), high[0], begins(1), high[1], begins(2), high[2])
                             & all_less_equal(low[0], ends(0), low[1], ends(1), low[2], ends(2));
            for (; lanes != 0; lanes &= lanes - 1)
                visit(*bodies_[first + static_cast<size_t>(std::countr_zero(lanes))]);
        }
    }

  private:
    // Of a box that was rounded.
    static Bounds widened(const Bounds& box) {
        const glm::vec3 far = glm::max(glm::abs(box.low), glm::abs(box.high)), size = box.high - box.low;
        const float slack = static_cast<float>(rounding) * std::max({far.x, far.y, far.z, size.x, size.y, size.z});
        return box.grown(glm::vec3(0.0f), slack);
    }
    void add(const Bounds& box) {
        for (size_t axis = 0; axis < 3; ++axis) {
            low_[axis].push_back(box.low[static_cast<int>(axis)]);
            high_[axis].push_back(box.high[static_cast<int>(axis)]);
        }
    }

    std::vector<const Body*> bodies_;
    std::array<std::vector<float>, 3> low_, high_;
};

// Whether a segment comes as near to the origin as a radius.
bool reaches(const RaySegment& ray, double radius, double until) {
    const double square = glm::dot(ray.along, ray.along);
    const double share = square > 0.0 ? std::clamp(-glm::dot(ray.from, ray.along) / square, 0.0, until) : 0.0;
    const glm::dvec3 nearest = ray.from + share * ray.along;
    return glm::dot(nearest, nearest) <= radius * radius * (1.0 + rounding);
}

struct BodyEntry {
    double share = 2.0; // above 1: none
    uint32_t part = 0;
    glm::vec3 normal{0.0f}; // in the world
};

// Replaces the entry by an earlier one into a body.
void enter(const Body& body, const RaySegment& world, BodyEntry& first, BodyId& entered) {
    const RaySegment beside{world.from - glm::dvec3(body.frame.origin), world.along};
    if (!reaches(beside, static_cast<double>(body.reach), std::min(first.share, 1.0))) return;
    const RaySegment ray = world.in(body.frame);
    if (!body.compound) {
        if (const std::optional<HullEntry> entry = entry_of(ray, body.hull(), first.share)) {
            first = {entry->share, 0, body.frame.basis * entry->normal};
            entered = body.id;
        }
        return;
    }
    const std::vector<CompoundShape::Child>& children = body.compound->children();
    bool own = false; // whether the entry is into this body
    body.compound->tree().for_each_where(
        [&](const Bounds& box) { return ray.crosses(box, std::min(first.share, 1.0)); },
        [&](uint32_t part) {
            const CompoundShape::Child& child = children[part];
            const RaySegment in_child = ray.in(child.frame);
            // Of parts that are entered at the same place, the lowest counts.
            const double below = own && part < first.part ? std::nextafter(first.share, 2.0) : first.share;
            if (!reaches(in_child, static_cast<double>(child.shape().radius()), std::min(below, 1.0))) return;
            const std::optional<HullEntry> entry = entry_of(in_child, child.shape(), below);
            if (!entry) return;
            own = true;
            entered = body.id;
            first = {entry->share, part, body.frame.basis * (child.frame.basis * entry->normal)};
        });
}

} // namespace

RaySegment RaySegment::in(const Transform& frame) const {
    const glm::dmat3 basis(frame.basis);
    return {(from - glm::dvec3(frame.origin)) * basis, along * basis};
}

bool RaySegment::crosses(const Bounds& box, double until) const {
    double begin = 0.0, end = until;
    for (int axis = 0; axis < 3; ++axis) {
        const double slack = rounding * static_cast<double>(box.high[axis] - box.low[axis]);
        const double low = static_cast<double>(box.low[axis]) - slack - from[axis],
                     high = static_cast<double>(box.high[axis]) + slack - from[axis];
        if (along[axis] == 0.0) {
            if (low > 0.0 || high < 0.0) return false;
            continue;
        }
        const double a = low / along[axis], b = high / along[axis];
        begin = std::max(begin, std::min(a, b));
        end = std::min(end, std::max(a, b));
    }
    return begin <= end;
}

std::optional<HullEntry> entry_of(const RaySegment& ray, const HullShape& hull, double until) {
    const glm::vec3 from(ray.from), to(ray.from + ray.along);
    const float far = std::max({std::abs(from.x), std::abs(from.y), std::abs(from.z), std::abs(to.x), std::abs(to.y),
                                std::abs(to.z), hull.radius()});
    if (hull.is_beyond(from, to, hull.margin() + static_cast<float>(rounding) * far)) return std::nullopt;
    double enters = -1.0, leaves = std::min(until, 1.0);
    int entered = -1;
    for (int face = 0; face < hull.face_count(); ++face) {
        const glm::dvec3 normal(hull.normal_of(face));
        if (normal == glm::dvec3(0.0)) continue; // a face without area
        const double height = static_cast<double>(hull.height_of(face)) + static_cast<double>(hull.margin());
        const double above = glm::dot(normal, ray.from) - height, approach = -glm::dot(normal, ray.along);
        if (approach > 0.0) {
            const double share = above / approach;
            if (above > 0.0 && share > enters) {
                enters = share;
                entered = face;
            }
        } else if (above > 0.0) {
            return std::nullopt;
        } else if (approach < 0.0) {
            leaves = std::min(leaves, above / approach);
        }
        if (enters > leaves) return std::nullopt;
    }
    if (entered < 0 || enters >= until) return std::nullopt;
    return HullEntry{enters, hull.normal_of(entered)};
}

void cast_rays(const SweepBroadphase& broadphase, std::span<const Body* const> strays, std::span<const Ray> rays,
               std::span<std::optional<RayHit>> hits) {
    const std::vector<uint32_t> order = in_order(rays);
    NearBodies near;
    for (size_t begin = 0; begin < order.size(); begin += group_size) {
        const std::span<const uint32_t> group =
            std::span(order).subspan(begin, std::min(group_size, order.size() - begin));
        Bounds around = bounds_of(rays[group.front()]);
        for (const uint32_t i : group) around = both(around, bounds_of(rays[i]));
        near.find(broadphase, strays, around);
        for (const uint32_t i : group) {
            const RaySegment ray{glm::dvec3(rays[i].from), glm::dvec3(rays[i].to) - glm::dvec3(rays[i].from)};
            BodyEntry first;
            BodyId entered;
            near.for_each_overlap(bounds_of(rays[i]), [&](const Body& body) { enter(body, ray, first, entered); });
            if (first.share <= 1.0)
                hits[i] = RayHit{.body = entered,
                                 .part = first.part,
                                 .share = static_cast<float>(first.share),
                                 .point = glm::vec3(ray.from + first.share * ray.along),
                                 .normal = first.normal};
        }
    }
}

} // namespace brittle::physics

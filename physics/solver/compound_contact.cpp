#include "physics/solver/compound_contact.h"

#include <algorithm>
#include <span>
#include <vector>

#include "physics/solver/body.h"
#include "physics/solver/ground_contact.h"
#include "physics/solver/hull_contact.h"
#include "physics/solver/manifold.h"

namespace brittle::physics {

namespace {

uint32_t part_count(const Body& body) {
    return body.compound ? static_cast<uint32_t>(body.compound->children().size()) : 1;
}

HullOf hull_of(const Body& body, uint32_t part) {
    if (!body.compound) return {.body = &body, .shape = &body.hull()};
    const CompoundShape::Child& child = body.compound->children()[part];
    return {.body = &body,
            .shape = &child.shape(),
            .local = &child.frame,
            .part = part,
            .facet = child.hull->source->facet.get()};
}

Bounds bounds_of(const Body& body, uint32_t part) {
    const HullOf hull = hull_of(body, part);
    return hull.shape->bounds(hull.frame());
}

class CompoundContacts final : public PairContacts {
  public:
    CompoundContacts(const Body& a, const Body* b) : a_(a), b_(b) {}

    void update(const ContactStep& step) override {
        for (const Child& child : children_) child.contacts->refresh();
        std::vector<Child> now;
        for (const auto& [part_a, part_b] : b_ ? near_parts() : all_parts()) {
            const auto known = std::ranges::lower_bound(children_, std::pair(part_a, part_b), {}, &Child::key);
            if (known != children_.end() && known->key() == std::pair(part_a, part_b))
                now.push_back(std::move(*known));
            else
                now.push_back({part_a, part_b, make(part_a, part_b)});
        }
        children_ = std::move(now);
        for (const Child& child : children_) child.contacts->update(step);
    }
    void refresh() override {
        for (const Child& child : children_) child.contacts->refresh();
    }
    void collect(std::vector<AnyManifold>& to) const override {
        for (const Child& child : children_) child.contacts->collect(to);
    }

  private:
    struct Child {
        uint32_t part_a, part_b;
        std::unique_ptr<PairContacts> contacts;

        [[nodiscard]] std::pair<uint32_t, uint32_t> key() const { return {part_a, part_b}; }
    };
    using Parts = std::vector<std::pair<uint32_t, uint32_t>>;

    [[nodiscard]] std::unique_ptr<PairContacts> make(uint32_t part_a, uint32_t part_b) const {
        if (!b_) return make_ground_contacts(hull_of(a_, part_a));
        return make_hull_contacts(hull_of(a_, part_a), hull_of(*b_, part_b));
    }

    // Returns the pairs of parts with overlapping bounds, ascending. Queries the tree of the body with more parts for
    // each part of the other. Valid until the thread's next call.
    [[nodiscard]] const Parts& near_parts() const {
        thread_local Parts parts;
        parts.clear();
        const bool swapped = part_count(a_) < part_count(*b_);
        const Body &many = swapped ? *b_ : a_, &few = swapped ? a_ : *b_;
        const Transform to_many = many.frame.inverse();
        for (uint32_t part = 0; part < part_count(few); ++part) {
            const Bounds bounds = bounds_of(few, part);
            const HullOf hull = hull_of(few, part);
            many.compound->tree().for_each_overlap(hull.shape->bounds(to_many * hull.frame()), [&](uint32_t other) {
                if (!bounds_of(many, other).overlaps(bounds)) return;
                parts.push_back(swapped ? std::pair(part, other) : std::pair(other, part));
            });
        }
        std::ranges::sort(parts);
        return parts;
    }

    // Every part has contacts with the ground, because they are speculative; a part that is too high costs a
    // comparison.
    [[nodiscard]] const Parts& all_parts() const {
        thread_local Parts parts;
        parts.clear();
        for (uint32_t part = 0; part < part_count(a_); ++part) parts.push_back({part, 0});
        return parts;
    }

    const Body& a_;
    const Body* b_;               // null: the ground
    std::vector<Child> children_; // by key
};

} // namespace

std::unique_ptr<PairContacts> make_compound_contacts(const Body& a, const Body* b) {
    return std::make_unique<CompoundContacts>(a, b);
}

} // namespace brittle::physics

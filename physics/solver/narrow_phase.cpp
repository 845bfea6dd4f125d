#include "physics/solver/narrow_phase.h"

#include <cstddef>
#include <span>
#include <vector>

#include "physics/solver/body.h"
#include "physics/solver/compound_contact.h"
#include "physics/solver/ellipsoid_contact.h"
#include "physics/solver/ground_contact.h"
#include "physics/solver/hull_contact.h"
#include "physics/solver/prefetch.h"

namespace brittle::physics {

namespace {

// Fewer pairs than this are not worth waking another thread for.
constexpr uint32_t min_pairs = 128;

// Prefetches for the next pairs: their contacts and second bodies, then those bodies' shapes, then the points. Many
// consecutive pairs share the first body.
[[gnu::always_inline]] inline void prefetch_next(const SweptPairs& pairs, std::span<const uint32_t> next) {
    constexpr size_t points_ahead = 2, shape_ahead = 4, pair_ahead = 8, contact_bytes = 320;
    if (next.size() > pair_ahead) {
        const SweptPair& pair = pairs.at(next[pair_ahead]);
        if (pair.contacts) prefetch(pair.contacts.get(), contact_bytes);
        prefetch(pair.b->body, contact_bytes);
    }
    if (next.size() > shape_ahead && pairs.at(next[shape_ahead]).b->body)
        prefetch(pairs.at(next[shape_ahead]).b->body->form.get());
    if (next.size() <= points_ahead) return;
    const Body* const body = pairs.at(next[points_ahead]).b->body;
    if (!body || body->compound) return;
    const std::span<const float> points = body->hull().groups();
    prefetch(points.data(), points.size_bytes());
}

std::unique_ptr<PairContacts> make_contacts(const SweptPair& pair) {
    const Body& a = *(pair.a->body ? pair.a : pair.b)->body;
    const Body* const b = pair.a->body ? pair.b->body : nullptr;
    // A compound comes first, so that its parts are those of the first body of a manifold.
    if (b && touch_as_ellipsoids(a, *b)) return make_ellipsoid_contacts(a, *b);
    if (b && b->compound && !a.compound) return make_compound_contacts(*b, &a);
    if (a.compound) return make_compound_contacts(a, b);
    if (!b) return make_ground_contacts({.body = &a, .shape = &a.hull()});
    return make_hull_contacts({.body = &a, .shape = &a.hull()}, {.body = b, .shape = &b->hull()});
}

// Every body has a pair with the ground; it gets contacts only when the hull comes near.
bool is_high_above_ground(const SweptPair& pair, const ContactStep& step) {
    if (pair.contacts || (pair.a->body && pair.b->body)) return false;
    const Body& body = *(pair.a->body ? pair.a : pair.b)->body;
    return !body.compound && is_out_of_reach_of_ground(body, step);
}

void update(SweptPair& pair, const ContactStep& step) {
    const bool a_awake = pair.a->body && pair.a->body->awake(), b_awake = pair.b->body && pair.b->body->awake();
    if ((!a_awake && !b_awake) || is_high_above_ground(pair, step)) return;
    if (pair.a->body && pair.b->body && pair.a->body->is_apart_from(*pair.b->body)) return pair.contacts.reset();
    if (!pair.contacts) pair.contacts = make_contacts(pair);
    pair.contacts->update(step);
}

} // namespace

void find_contacts(SweptPairs& pairs, const ContactStep& step, fracture::Threads& threads) {
    const std::vector<uint32_t>& set = pairs.set();
    const auto count = static_cast<uint32_t>(set.size());
    threads.for_chunks(count, min_pairs, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (size_t i = begin; i < end; ++i) {
            prefetch_next(pairs, std::span(set).subspan(i, end - i));
            update(pairs.at(set[i]), step);
        }
    });
}

} // namespace brittle::physics

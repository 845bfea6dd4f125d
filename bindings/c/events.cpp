// Poses and changes of pieces in the C interface.
#include "bindings/c/events.h"

#include <memory>
#include <utility>

#include "bindings/c/handles.h"

using namespace brittle;

namespace brittle::c {

brittle_events* events_of(physics::DestructionEvents taken) {
    auto events = std::make_unique<brittle_events>();
    for (const physics::PieceRemoved& one : taken.removed) events->removed.push_back({one.id.value, one.slot});
    for (const physics::PieceFading& one : taken.fading) {
        events->fading.push_back({one.id.value, one.slot});
        events->shares.push_back(one.share);
    }
    for (physics::PieceAdded& one : taken.added)
        events->added.push_back(
            {{one.id.value, one.object.value, one.slot, one.depth, one.parent.value}, std::move(one.solid)});
    return events.release();
}

void put(const physics::Pose& pose, float* position, float* orientation) {
    for (int k = 0; k < 3; ++k) position[k] = pose.position[k];
    orientation[0] = pose.orientation.x;
    orientation[1] = pose.orientation.y;
    orientation[2] = pose.orientation.z;
    orientation[3] = pose.orientation.w;
}

Transforms::Transforms(const physics::Destruction& destruction, brittle_transform* out, uint64_t capacity)
    : piece_of_(destruction.slot_count()), out_(out), capacity_(capacity) {
    for (const physics::PieceId id : destruction.pieces()) piece_of_[destruction.slot(id)] = id;
}

void Transforms::add(uint32_t slot, const physics::Pose& pose) {
    if (out_ && count_ < capacity_) {
        brittle_transform& one = out_[count_];
        one.piece = piece_of_.empty() ? slot : piece_of_[slot].value;
        one.slot = slot;
        put(pose, one.position, one.orientation);
    }
    ++count_;
}

} // namespace brittle::c

using c::guarded;
using c::need;
using c::refuse;

extern "C" {

brittle_status brittle_events_array(const brittle_events* events, uint32_t which, brittle_array* out,
                                    brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const brittle_events& all = need(events, "events");
        switch (which) {
        case BRITTLE_EVENTS_REMOVED:
            *out = c::view<uint32_t>(all.removed);
            return;
        case BRITTLE_EVENTS_ADDED:
            *out = c::view(all.added, all.added.empty() ? nullptr : &all.added.front().row[0], 5);
            return;
        case BRITTLE_EVENTS_FADING:
            *out = c::view<uint32_t>(all.fading);
            return;
        case BRITTLE_EVENTS_FADING_SHARES:
            *out = c::view<float>(all.shares);
            return;
        default:
            c::refuse_which(which, BRITTLE_EVENTS_FADING_SHARES);
        }
    });
}

brittle_status brittle_events_added_array(const brittle_events* events, uint64_t row, uint32_t which,
                                          brittle_array* out, uint32_t* exterior_triangles, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const brittle_events& all = need(events, "events");
        if (row >= all.added.size())
            refuse("there is no added piece in row " + std::to_string(row) + "; there are "
                   + std::to_string(all.added.size()));
        const physics::SolidPiece& solid = *all.added[row].solid;
        switch (which) {
        case BRITTLE_ADDED_POSITIONS:
            *out = c::view<float>(solid.surface().positions);
            break;
        case BRITTLE_ADDED_TRIANGLES:
            *out = c::view<uint32_t>(solid.surface().mesh.triangles);
            break;
        case BRITTLE_ADDED_CENTRE:
            *out = {BRITTLE_FLOAT64, 3, 1, 3 * sizeof(double), &solid.mass.centre_of_mass.x};
            break;
        default:
            c::refuse_which(which, BRITTLE_ADDED_CENTRE);
        }
        if (exterior_triangles) *exterior_triangles = solid.surface().exterior_triangles;
    });
}

void brittle_events_free(brittle_events* events) {
    delete events;
}

} // extern "C"

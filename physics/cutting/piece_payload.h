// Data that a caller attaches to each piece of a breakable object, for example the piece's vertex buffers. Physics
// never reads it.
//
// A PayloadMaker runs on the thread that makes the piece, so its cost stays off the main thread. Destruction hands each
// payload over once, with the piece's PieceAdded event; the receiver owns it from then on. Destruction destroys the
// payload of a piece that is removed before its event is taken.
//
//     struct Buffers : PiecePayload { VertexBuffer vertices; };
//     desc.payload = [](const SolidPiece& solid, const SolidPiece*) { return std::make_unique<Buffers>(upload(solid)); };
//     for (PieceAdded& added : destruction.take_events().added) draw(static_cast<Buffers&>(*added.payload));
//
// Threads: a maker is called on several threads at once, and a payload is destroyed on any thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "physics/cutting/solid_piece.h"

namespace brittle::physics {

struct PiecePayload {
    virtual ~PiecePayload() = default;
};
using PayloadPtr = std::unique_ptr<PiecePayload>;
// The second solid is the one that the piece was cut from; null for one that was not cut. Must not throw.
using PayloadMaker = std::function<PayloadPtr(const SolidPiece& piece, const SolidPiece* cut_from)>;

// One payload a solid that was not cut, made in parallel on `threads` threads (0: one a core); null pointers for an empty maker.
[[nodiscard]] std::vector<PayloadPtr> payloads_of(std::span<const SolidPtr> solids, const PayloadMaker& maker,
                                                  uint32_t threads = 0);

} // namespace brittle::physics

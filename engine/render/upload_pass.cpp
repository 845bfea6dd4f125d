#include "engine/render/upload_pass.h"

namespace brittle::engine {

void declare_upload(Frame& frame) {
    if (frame.upload.empty()) return;
    Buffer* const arenas[piece_arenas] = {&frame.vertices, &frame.normals, &frame.indices};
    const Access used_as[piece_arenas] = {Access::vertex_read, Access::vertex_read, Access::index_read};
    std::array<Buffer, piece_arenas> old;
    for (size_t i = 0; i < piece_arenas; ++i) {
        const DeviceBuffer& buffer = frame.pieces.old_buffers()[i];
        if (!buffer.handle()) continue;
        old[i] = frame.graph.import_buffer("old " + std::string(PieceArena::name(i)), {buffer.size()},
                                           {.initial = used_as[i],
                                            .final = {},
                                            .read_only = true,
                                            .external = frame.external.add(buffer.handle())});
    }
    frame.graph.add_pass(
        "upload", PassKind::transfer,
        [&](PassBuilder& pass) {
            if (frame.staging.valid()) pass.read(frame.staging, Access::transfer_read);
            for (size_t i = 0; i < piece_arenas; ++i) {
                const PieceUpload::Arena& copies = frame.upload.arenas[i];
                if (!copies.from_old.empty()) pass.read(old[i], Access::transfer_read);
                if (!copies.from_old.empty() || !copies.from_staging.empty())
                    *arenas[i] = pass.write(*arenas[i], Access::transfer_write);
            }
        },
        [&frame, old](PassContext& context) {
            const Buffer to[piece_arenas] = {frame.vertices, frame.normals, frame.indices};
            const auto copy = [&](Buffer from, size_t arena, const std::vector<VkBufferCopy>& regions) {
                if (regions.empty()) return;
                vkCmdCopyBuffer(context.commands, context.buffer(from), context.buffer(to[arena]),
                                static_cast<uint32_t>(regions.size()), regions.data());
            };
            for (size_t i = 0; i < piece_arenas; ++i) {
                copy(frame.staging, i, frame.upload.arenas[i].from_staging);
                copy(old[i], i, frame.upload.arenas[i].from_old);
            }
        });
}

} // namespace brittle::engine

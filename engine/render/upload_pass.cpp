#include "engine/render/upload_pass.h"

#include <algorithm>

namespace brittle::engine {

void declare_upload(Frame& frame) {
    if (frame.upload.empty()) return;
    Buffer* const arenas[piece_arenas] = {&frame.vertices, &frame.normals, &frame.indices, &frame.corners};
    const Access used_as[piece_arenas] = {Access::vertex_read, Access::vertex_read, Access::index_read,
                                          Access::vertex_read};
    std::array<Buffer, piece_arenas> old;
    for (size_t i = 0; i < piece_arenas; ++i) {
        const DeviceBuffer& buffer = frame.pieces.old_buffers()[i];
        if (!buffer.handle()) continue;
        old[i] = frame.graph.import_buffer(
            "old " + std::string(PieceArena::name(i)), {buffer.size()},
            {.initial = used_as[i], .final = {}, .read_only = true, .external = frame.external.add(buffer.handle())});
    }
    frame.graph.add_pass(
        "upload", PassKind::transfer,
        [&](PassBuilder& pass) {
            const PieceUpload& upload = frame.upload;
            if (frame.staging.valid()) pass.read(frame.staging, Access::transfer_read);
            for (const Buffer& staged : frame.staged) pass.read(staged, Access::transfer_read);
            for (size_t i = 0; i < piece_arenas; ++i) {
                if (!upload.from_old[i].empty()) pass.read(old[i], Access::transfer_read);
                const bool from_batch = std::ranges::any_of(
                    upload.staged, [i](const PieceUpload::Staged& staged) { return !staged.copies[i].empty(); });
                if (from_batch || !upload.from_old[i].empty() || !upload.from_staging[i].empty())
                    *arenas[i] = pass.write(*arenas[i], Access::transfer_write);
            }
        },
        [&frame, old](PassContext& context) {
            const Buffer to[piece_arenas] = {frame.vertices, frame.normals, frame.indices, frame.corners};
            const auto copy = [&](Buffer from, size_t arena, const std::vector<VkBufferCopy>& regions) {
                if (regions.empty()) return;
                vkCmdCopyBuffer(context.commands, context.buffer(from), context.buffer(to[arena]),
                                static_cast<uint32_t>(regions.size()), regions.data());
            };
            for (size_t i = 0; i < piece_arenas; ++i) {
                copy(frame.staging, i, frame.upload.from_staging[i]);
                for (size_t k = 0; k < frame.staged.size(); ++k)
                    copy(frame.staged[k], i, frame.upload.staged[k].copies[i]);
                copy(old[i], i, frame.upload.from_old[i]);
            }
        });
}

} // namespace brittle::engine

#include "engine/render/cull_pass.h"

#include "compiled/cull_comp.h"

namespace brittle::engine {

CullPass::CullPass(const Device& device, VkPipelineLayout layout) : pipeline_(device, "cull", layout, cull_comp) {}

void CullPass::declare(Frame& frame, bool for_shadow) const {
    frame.graph.add_pass(
        "cull", PassKind::compute,
        [&](PassBuilder& pass) {
            pass.read(frame.uniforms, Access::uniform_read);
            pass.read(frame.poses, Access::storage_read_compute);
            pass.read(frame.draw_data, Access::storage_read_compute);
            pass.read(frame.commands, Access::storage_read_compute);
            frame.camera_commands = pass.write(frame.camera_commands, Access::storage_write_compute);
            if (for_shadow) frame.light_commands = pass.write(frame.light_commands, Access::storage_write_compute);
            frame.visible_counts = pass.write(frame.visible_counts, Access::storage_read_write_compute);
        },
        [this, &frame, for_shadow](PassContext& context) {
            vkCmdBindPipeline(context.commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.handle());
            vkCmdBindDescriptorSets(context.commands, VK_PIPELINE_BIND_POINT_COMPUTE, frame.layout.pipeline_layout(), 0,
                                    1, &frame.set, 0, nullptr);
            const uint32_t groups = (frame.pieces.draws() - 1) / shared::cull_group_size + 1;
            vkCmdDispatch(context.commands, groups, for_shadow ? shared::view_count : 1, 1);
        });
}

} // namespace brittle::engine

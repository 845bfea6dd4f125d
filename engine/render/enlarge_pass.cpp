#include "engine/render/enlarge_pass.h"

namespace brittle::engine {

namespace {

VkOffset3D far_corner(VkExtent2D extent) {
    return {static_cast<int32_t>(extent.width), static_cast<int32_t>(extent.height), 1};
}

} // namespace

void declare_enlarge(Frame& frame) {
    const Image small = frame.colour, target = frame.picture;
    frame.graph.add_pass(
        "enlarge", PassKind::transfer,
        [&](PassBuilder& pass) {
            pass.read(small, Access::transfer_read);
            frame.picture = pass.write(target, Access::transfer_write);
        },
        [small, target](PassContext& context) {
            constexpr VkImageSubresourceLayers layers{VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
            const VkImageBlit region{.srcSubresource = layers,
                                     .srcOffsets = {{0, 0, 0}, far_corner(context.extent(small))},
                                     .dstSubresource = layers,
                                     .dstOffsets = {{0, 0, 0}, far_corner(context.extent(target))}};
            vkCmdBlitImage(context.commands, context.image(small), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           context.image(target), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region,
                           VK_FILTER_LINEAR);
        });
}

} // namespace brittle::engine

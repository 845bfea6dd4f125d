#include "engine/render/upscale_pass.h"

namespace brittle::engine {

namespace {

struct Corners {
    VkOffset3D low, high;
};

Corners corners_of(const VkRect2D& part, int32_t by) {
    const VkOffset2D at = part.offset;
    const auto width = static_cast<int32_t>(part.extent.width), height = static_cast<int32_t>(part.extent.height);
    return {{by * at.x, by * at.y, 0}, {by * (at.x + width), by * (at.y + height), 1}};
}

// Returns the ratio of the large picture's sides to the small one's, or 0 unless it is one integer for both sides.
int32_t whole_ratio(VkExtent2D small, VkExtent2D large) {
    const uint32_t ratio = large.width / small.width;
    return ratio * small.width == large.width && ratio * small.height == large.height ? static_cast<int32_t>(ratio) : 0;
}

} // namespace

void declare_upscale(Frame& frame, Image small) {
    const Image target = frame.picture;
    frame.graph.add_pass(
        "upscale", PassKind::transfer,
        [&](PassBuilder& pass) {
            pass.read(small, Access::transfer_read);
            frame.picture = pass.write(target, Access::transfer_write);
        },
        [small, target, region = frame.scene.region](PassContext& context) {
            constexpr VkImageSubresourceLayers layers{VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
            const VkExtent2D drawn = context.extent(small), wanted = context.extent(target);
            Corners from = corners_of({{}, drawn}, 1), to = corners_of({{}, wanted}, 1);
            // The blit is restricted to the region only for an integer ratio: then the region's corners are pixel
            // corners of both pictures, and every pixel is interpolated from the same four texels as in the whole
            // picture.
            if (const int32_t ratio = whole_ratio(drawn, wanted)) {
                const VkRect2D part = pixel_rect(region, drawn, upscale_margin - 1);
                if (part.extent.width == 0 || part.extent.height == 0) return;
                from = corners_of(part, 1);
                to = corners_of(part, ratio);
            }
            const VkImageBlit region_of_both{.srcSubresource = layers,
                                             .srcOffsets = {from.low, from.high},
                                             .dstSubresource = layers,
                                             .dstOffsets = {to.low, to.high}};
            vkCmdBlitImage(context.commands, context.image(small), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           context.image(target), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region_of_both,
                           VK_FILTER_LINEAR);
        });
}

} // namespace brittle::engine

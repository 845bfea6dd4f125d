// Declaration and its checks; compile() is in plan.cpp.
#include "engine/graph/frame_graph.h"

#include <algorithm>

namespace brittle::engine {
namespace {

// "pass 'shade'".
std::string named(const char* what, std::string_view name) {
    return std::string(what).append(" '").append(name).append("'");
}

// Returns the mistake in an import's initial or final accesses, or "".
std::string edge_error(AccessSet set, const char* edge, Access forbidden, bool image) {
    std::string error;
    const AccessTraits* first = nullptr;
    set.for_each([&](Access access) {
        const AccessTraits& t = traits(access);
        if (!first) first = &t;
        if (image ? !t.images : !t.buffers)
            error = std::string(t.name) + " is not legal for " + (image ? "an image" : "a buffer");
        else if (access == forbidden || (edge == std::string_view("final") && access == Access::acquired))
            error = std::string(t.name) + " is not legal as " + edge + " access";
        else if (image && t.layout != first->layout)
            error = std::string(edge) + " accesses " + first->name + " and " + t.name + " need different image layouts";
    });
    return error;
}

} // namespace

// --- Resources -------------------------------------------------------------------------------------------

Image FrameGraph::create_image(std::string_view name, const ImageDesc& desc) {
    return Image(add_resource(name, desc, false, {}), 0);
}

Buffer FrameGraph::create_buffer(std::string_view name, const BufferDesc& desc) {
    return Buffer(add_resource(name, desc, false, {}), 0);
}

Image FrameGraph::import_image(std::string_view name, const ImageDesc& desc, const Import& import) {
    return Image(add_resource(name, desc, true, import), 0);
}

Buffer FrameGraph::import_buffer(std::string_view name, const BufferDesc& desc, const Import& import) {
    return Buffer(add_resource(name, desc, true, import), 0);
}

std::uint32_t FrameGraph::add_resource(std::string_view name, std::variant<ImageDesc, BufferDesc> desc, bool imported,
                                       const Import& import) {
    if (resources_.size() >= Image::max_resources) {
        fail(named("resource", name) + " exceeds the limit of " + std::to_string(Image::max_resources)
             + " resources in a graph");
        return Image::max_resources;
    }
    const auto* image = std::get_if<ImageDesc>(&desc);
    if (image) {
        if (!image->width || !image->height || !image->samples || !image->mip_levels || !image->layers)
            fail(named("image", name) + " is " + std::to_string(image->width) + "x" + std::to_string(image->height)
                 + " with " + std::to_string(image->samples) + " samples, " + std::to_string(image->mip_levels)
                 + " mip levels and " + std::to_string(image->layers) + " layers: none of these may be 0");
    } else if (!std::get<BufferDesc>(desc).size) {
        fail(named("buffer", name) + " has size 0");
    }
    for (const std::string& error : {edge_error(import.initial, "initial", Access::host_read, image != nullptr),
                                     edge_error(import.final, "final", Access::host_write, image != nullptr)})
        if (!error.empty()) fail(named("imported", name) + ": " + error);

    Plan::Resource& resource = resources_.emplace_back();
    resource.name = name;
    resource.desc = desc;
    resource.imported = imported;
    resource.import = import;
    writers_.push_back({no_pass});
    return static_cast<std::uint32_t>(resources_.size() - 1);
}

// --- Passes ----------------------------------------------------------------------------------------------

std::uint32_t FrameGraph::begin_pass(std::string_view name, PassKind kind, Execute execute) {
    passes_.push_back({std::string(name), kind, false, {}, {}, std::move(execute)});
    return static_cast<std::uint32_t>(passes_.size() - 1);
}

void PassBuilder::read(Image image, Access access) {
    graph_.add_use(pass_, {image.resource(), image.version(), access}, true, false);
}

void PassBuilder::read(Buffer buffer, Access access) {
    graph_.add_use(pass_, {buffer.resource(), buffer.version(), access}, false, false);
}

Image PassBuilder::write(Image image, Access access) {
    return {image.resource(), graph_.add_use(pass_, {image.resource(), image.version(), access}, true, true)};
}

Buffer PassBuilder::write(Buffer buffer, Access access) {
    return {buffer.resource(), graph_.add_use(pass_, {buffer.resource(), buffer.version(), access}, false, true)};
}

void PassBuilder::side_effect() {
    graph_.passes_[pass_].side_effect = true;
}

bool FrameGraph::contents_defined(std::uint32_t resource) const {
    const AccessSet initial = resources_[resource].import.initial;
    return newest(resource) > 0 || !(initial.empty() || initial == AccessSet(Access::acquired));
}

std::uint32_t FrameGraph::add_use(std::uint32_t pass_index, Plan::Use use, bool image, bool write) {
    Plan::Pass& pass = passes_[pass_index];
    // Also catches default-constructed handles and, where the indices disagree, handles of another graph.
    if (use.resource >= resources_.size() || resources_[use.resource].is_image() != image
        || use.version > newest(use.resource)) {
        fail(named("pass", pass.name) + (write ? " writes " : " reads ") + (image ? "an image" : "a buffer")
             + " handle that is not of this graph");
        return use.version;
    }
    const bool repeated = std::any_of(pass.uses.begin(), pass.uses.end(), [&](const Plan::Use& other) {
        return other.resource == use.resource && other.access == use.access;
    });
    if (repeated && !write) return newest(use.resource);

    std::string error = use_error(pass, use, write);
    if (!error.empty()) {
        fail(std::move(error));
        return newest(use.resource); // alive, so that one mistake is reported once
    }
    if (write) {
        writers_[use.resource].push_back(pass_index);
        ++use.version;
    }
    pass.uses.push_back(use);
    return use.version;
}

std::string FrameGraph::use_error(const Plan::Pass& pass, const Plan::Use& use, bool write) const {
    const AccessTraits& t = traits(use.access);
    const Plan::Resource& resource = resources_[use.resource];
    const bool image = resource.is_image();
    const std::uint32_t current = newest(use.resource);
    const auto wrong = [&](const std::string& why) {
        return named("pass", pass.name) + named(write ? " writes" : " reads", resource.name) + " as " + t.name + ", "
               + why;
    };

    if (!(image ? t.images : t.buffers))
        return wrong(image ? "which is not legal for an image" : "which is not legal for a buffer");
    if (!t.kinds) return wrong("which is legal only as an import's initial or final access");
    if (!(t.kinds >> static_cast<unsigned>(pass.kind) & 1))
        return wrong(std::string("which is not allowed in a ") + to_string(pass.kind) + " pass");
    if (use.access == Access::resolve_attachment && std::get<ImageDesc>(resource.desc).samples != 1)
        return wrong("which needs an image of one sample");
    if (t.writes != write) return wrong(write ? "which only reads" : "which writes");

    for (const Plan::Use& other : pass.uses) {
        if (other.resource != use.resource) continue;
        const AccessTraits& o = traits(other.access);
        if (write || o.writes)
            return wrong(std::string("but also uses it as ") + o.name
                         + ": a pass may read a resource or write it once; to do both, use a read_write or "
                           "_load access");
        if (image && o.layout != t.layout)
            return wrong(std::string("but also as ") + o.name + ": the two need different image layouts");
    }

    if (use.version != current)
        return wrong("but by its version " + std::to_string(use.version) + ", which "
                     + named("pass", passes_[writers_[use.resource][use.version + 1]].name)
                     + " has replaced: use the handle that its write() returned");
    if (write && resource.imported && resource.import.read_only) return wrong("but it is imported as read-only");
    if (t.reads && !contents_defined(use.resource))
        return wrong(resource.imported ? "but it was imported with undefined contents and no pass wrote it before"
                                       : "but no pass wrote it before");
    if (write && current == Image::max_version)
        return wrong("but it was written " + std::to_string(current) + " times already, which is the limit");
    return {};
}

void FrameGraph::check_final_accesses() {
    for (std::uint32_t r = 0; r < resources_.size(); ++r) {
        bool reads = false;
        resources_[r].import.final.for_each([&](Access access) { reads |= traits(access).reads; });
        if (reads && !contents_defined(r))
            fail(named("imported", resources_[r].name) + " has the final access "
                 + to_string(resources_[r].import.final) + ", but no pass wrote it");
    }
}

} // namespace brittle::engine

#include "engine/graph/plan.h"

#include <map>
#include <utility>

namespace brittle::engine {
namespace {

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        if (c == '\n')
            out += "\\n";
        else
            out += c;
    }
    return out;
}

std::string node(const char* prefix, std::size_t index) {
    return std::string(prefix).append(std::to_string(index));
}

class Writer {
  public:
    explicit Writer(const Plan& plan) : plan_(plan) {}

    void pass(const Plan::Pass& pass, const std::string& id, bool live) {
        text_ += "  " + id + " [shape=box, label=\"" + escaped(pass.name) + "\\n" + to_string(pass.kind);
        if (!pass.barriers.empty()) text_ += node("\\nbarriers: ", pass.barriers.size());
        text_ += live ? "\"];\n" : "\", color=grey, fontcolor=grey];\n";
        for (const Plan::Use& use : pass.uses) {
            const AccessTraits& t = traits(use.access);
            const char* colour = live ? "" : ", color=grey, fontcolor=grey";
            if (!t.writes || (t.keeps && use.version > 1) || t.reads)
                edge(version(use.resource, t.writes ? use.version - 1 : use.version, live), id, t.name, colour);
            if (t.writes) edge(id, version(use.resource, use.version, live), t.name, colour);
        }
    }

    std::string finish() {
        for (const auto& [key, live] : versions_) {
            const Plan::Resource& resource = plan_.resources[key.first];
            text_ += std::string("  ") + id(key) + " [shape=ellipse, label=\"" + escaped(resource.name) + "\\nversion "
                     + std::to_string(key.second);
            if (!resource.imported && resource.used())
                text_ += node("\\nheap ", resource.memory.heap) + " at " + std::to_string(resource.memory.offset) + ", "
                         + std::to_string(resource.memory.size) + " bytes";
            text_ += resource.imported ? "\", peripheries=2" : "\"";
            text_ += live ? "];\n" : ", color=grey, fontcolor=grey];\n";
        }
        return text_ + "}\n";
    }

  private:
    using Version = std::pair<std::uint32_t, std::uint32_t>; // resource, version

    static std::string id(Version key) { return node("r", key.first) + node("v", key.second); }
    std::string version(std::uint32_t resource, std::uint32_t version, bool live) {
        versions_[{resource, version}] |= live;
        return id({resource, version});
    }
    void edge(const std::string& from, const std::string& to, const char* label, const char* colour) {
        text_ += "  " + from + " -> " + to + " [label=\"" + label + "\"" + colour + "];\n";
    }

    const Plan& plan_;
    std::string text_ = "digraph frame {\n  rankdir=LR;\n  node [fontname=\"sans-serif\"];\n"
                        "  edge [fontname=\"sans-serif\", fontsize=10];\n";
    std::map<Version, bool> versions_; // every version that a pass mentions; true: a live pass does
};

} // namespace

std::string to_dot(const Plan& plan) {
    Writer writer(plan);
    for (std::size_t p = 0; p < plan.passes.size(); ++p) writer.pass(plan.passes[p], node("p", p), true);
    for (std::size_t p = 0; p < plan.culled.size(); ++p) writer.pass(plan.culled[p], node("c", p), false);
    return writer.finish();
}

} // namespace brittle::engine

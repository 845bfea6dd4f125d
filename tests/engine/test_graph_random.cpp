#include "tests/engine/graph_oracle.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <string>
#include <vector>

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

// SplitMix64.
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint32_t below(std::uint32_t bound) {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return static_cast<std::uint32_t>((z ^ (z >> 31)) >> 33) % bound;
    }

  private:
    std::uint64_t state_;
};

MemoryNeed random_need(const Plan::Resource& resource) {
    std::uint64_t seed = 0;
    for (const char c : resource.name) seed = seed * 131 + static_cast<unsigned char>(c);
    Random random(seed);
    return {.size = 1 + random.below(300), .alignment = 1u << random.below(7), .memory_class = random.below(8) == 0};
}

// A random legal graph, with the test's own record of the passes whose results each pass needs.
class RandomGraph {
  public:
    explicit RandomGraph(std::uint64_t seed) : random_(seed) {
        const std::uint32_t resources = 3 + random_.below(9);
        for (std::uint32_t r = 0; r < resources; ++r) add_resource(r);
        const std::uint32_t passes = 1 + random_.below(20);
        for (std::uint32_t p = 0; p < passes; ++p) add_pass(p);
    }

    FrameGraph graph;

    // Returns the names of the passes that an output depends on.
    [[nodiscard]] std::set<std::string> expected_live() const {
        std::set<std::string> live;
        for (std::size_t p = 0; p < passes_.size(); ++p)
            if (passes_[p].side_effect) mark(static_cast<int>(p), live);
        for (const Resource& resource : resources_)
            if (resource.imported) mark(resource.writer, live);
        return live;
    }

    // Returns whether the plan has every live pass as declared.
    [[nodiscard]] bool repeats_declaration(const Plan& plan) const {
        const auto same = [](const Plan::Use& a, const Plan::Use& b) {
            return a.resource == b.resource && a.version == b.version && a.access == b.access;
        };
        return std::all_of(plan.passes.begin(), plan.passes.end(), [&](const Plan::Pass& pass) {
            const std::vector<Plan::Use>& uses = passes_[std::stoul(pass.name.substr(4))].uses;
            return std::equal(uses.begin(), uses.end(), pass.uses.begin(), pass.uses.end(), same);
        });
    }

  private:
    struct Resource {
        bool is_image, imported, read_only, defined;
        Image image;
        Buffer buffer;
        int writer = -1; // the pass that made the newest version
        std::uint32_t version = 0;
        [[nodiscard]] std::uint32_t index() const { return is_image ? image.resource() : buffer.resource(); }
    };
    struct Pass {
        bool side_effect = false;
        std::vector<int> needs;
        std::vector<Plan::Use> uses;
    };

    void mark(int pass, std::set<std::string>& live) const {
        if (pass < 0 || !live.insert("pass" + std::to_string(pass)).second) return;
        for (const int needed : passes_[static_cast<std::size_t>(pass)].needs) mark(needed, live);
    }

    void add_resource(std::uint32_t r) {
        Resource resource{};
        resource.is_image = random_.below(2);
        resource.imported = random_.below(4) == 0;
        const std::string name = (resource.is_image ? "image" : "buffer") + std::to_string(r);
        if (resource.imported) {
            static const AccessSet image_edges[] = {Access::acquired,
                                                    {},
                                                    Access::sampled_fragment,
                                                    Access::transfer_read,
                                                    Access::sampled_fragment | Access::sampled_compute,
                                                    Access::storage_write_compute};
            static const AccessSet buffer_edges[] = {Access::host_write,
                                                     {},
                                                     Access::vertex_read | Access::index_read,
                                                     Access::storage_read_compute,
                                                     Access::transfer_write,
                                                     Access::storage_write_compute | Access::vertex_read};
            Import import{.initial = (resource.is_image ? image_edges : buffer_edges)[random_.below(6)]};
            resource.defined = !import.initial.empty() && import.initial != AccessSet(Access::acquired);
            resource.read_only = resource.defined && random_.below(4) == 0;
            import.read_only = resource.read_only;
            // A final access that reads needs contents; without them, compile() rightly fails.
            static const AccessSet final_edges[][3] = {
                {{}, Access::host_read, Access::vertex_read | Access::storage_read_compute},
                {{}, Access::present, Access::sampled_compute}};
            if (resource.defined) import.final = final_edges[resource.is_image][random_.below(3)];
            if (resource.is_image)
                resource.image = graph.import_image(name, small_image, import);
            else
                resource.buffer = graph.import_buffer(name, small_buffer, import);
        } else if (resource.is_image) {
            resource.image = graph.create_image(name, small_image);
        } else {
            resource.buffer = graph.create_buffer(name, small_buffer);
        }
        resources_.push_back(resource);
    }

    void add_pass(std::uint32_t p) {
        Pass& pass = passes_.emplace_back();
        const auto kind = static_cast<PassKind>(random_.below(3));
        graph.add_pass(
            "pass" + std::to_string(p), kind,
            [&](PassBuilder& builder) {
                if (random_.below(5) == 0) {
                    pass.side_effect = true;
                    builder.side_effect();
                }
                for (std::uint32_t uses = 1 + random_.below(4); uses > 0; --uses)
                    add_use(builder, pass, static_cast<int>(p), kind);
            },
            [](PassContext&) {});
    }

    // Returns all accesses that a pass of this kind may make to the resource at this point.
    [[nodiscard]] std::vector<AccessFacts> legal(const Resource& resource, const Pass& pass, PassKind kind) const {
        std::vector<AccessFacts> out;
        for (const AccessFacts& f : facts_table) {
            bool good = f.kind == kind && (resource.is_image ? f.image : f.buffer) && (!f.reads || resource.defined)
                        && (!f.writes || !resource.read_only);
            for (const Plan::Use& other : pass.uses) {
                if (other.resource != resource.index()) continue;
                const AccessFacts o = facts(other.access);
                good &= !f.writes && !o.writes && f.access != o.access && (!resource.is_image || f.layout == o.layout);
            }
            if (good) out.push_back(f);
        }
        return out;
    }

    void add_use(PassBuilder& builder, Pass& pass, int p, PassKind kind) {
        Resource& resource = resources_[random_.below(static_cast<std::uint32_t>(resources_.size()))];
        const std::vector<AccessFacts> choice = legal(resource, pass, kind);
        if (choice.empty()) return;
        const AccessFacts f = choice[random_.below(static_cast<std::uint32_t>(choice.size()))];
        if (!f.replaces) pass.needs.push_back(resource.writer);
        if (f.writes) {
            if (resource.is_image)
                resource.image = builder.write(resource.image, f.access);
            else
                resource.buffer = builder.write(resource.buffer, f.access);
            resource.writer = p;
            resource.defined = true;
            ++resource.version;
        } else if (resource.is_image) {
            builder.read(resource.image, f.access);
        } else {
            builder.read(resource.buffer, f.access);
        }
        pass.uses.push_back({resource.index(), resource.version, f.access});
    }

    Random random_;
    std::vector<Resource> resources_;
    std::vector<Pass> passes_;
};

} // namespace

TEST_CASE("random graphs: every hazard has a barrier, no barrier is superfluous, no two live resources share "
          "bytes") {
    std::size_t barriers = 0, aliased = 0, culled = 0, live = 0;
    for (std::uint64_t seed = 0; seed < 600; ++seed) {
        CAPTURE(seed);
        RandomGraph random(seed);
        const std::set<std::string> expected = random.expected_live();
        Plan plan = compiled(random.graph, random_need);
        const Names passes = names(plan.passes);
        REQUIRE(std::set<std::string>(passes.begin(), passes.end()) == expected);
        REQUIRE(random.repeats_declaration(plan));
        REQUIRE(barrier_fault(plan) == "");
        REQUIRE(memory_fault(plan, random_need) == "");
        REQUIRE(superfluous_barrier(plan) == "");
        live += plan.passes.size();
        culled += plan.culled.size();
        for (const std::vector<Plan::Barrier>* list : barrier_lists(plan))
            for (const Plan::Barrier& barrier : *list) {
                ++barriers;
                aliased += barrier.aliasing;
            }
    }
    // The random graphs cover every mechanism.
    MESSAGE(live, " live passes, ", culled, " culled, ", barriers, " barriers, ", aliased, " of them aliasing");
    CHECK(live > 3000);
    CHECK(culled > 1000);
    CHECK(barriers > 5000);
    CHECK(aliased > 200);
}

TEST_CASE("equal declarations give equal plans") {
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
        RandomGraph a(seed), b(seed);
        CHECK(to_dot(compiled(a.graph, random_need)) == to_dot(compiled(b.graph, random_need)));
    }
}

TEST_CASE("random graphs print well-formed DOT") {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        CAPTURE(seed);
        RandomGraph random(seed);
        check_dot(to_dot(compiled(random.graph, random_need)));
    }
}

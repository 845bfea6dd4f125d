#include "tests/engine/graph_oracle.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <tuple>
#include <type_traits>

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

constexpr PassKind G = PassKind::graphics, C = PassKind::compute, T = PassKind::transfer;

MemoryNeed need_100(const Plan::Resource&) {
    return {.size = 100};
}

Plan compiled(FrameGraph& graph) {
    return test::compiled(graph, need_100);
}

// Compiles a graph that has mistakes, and returns the error.
std::string error_of(FrameGraph& graph) {
    const CompileResult result = std::move(graph).compile(need_100);
    REQUIRE_FALSE(result);
    return result.error().message;
}

template<class Setup>
void add(FrameGraph& graph, const char* name, PassKind kind, Setup&& setup) {
    graph.add_pass(name, kind, setup, [](PassContext&) {});
}

void check_sound(Plan& plan, const MemoryNeeds& needs = need_100) {
    CHECK(barrier_fault(plan) == "");
    CHECK(memory_fault(plan, needs) == "");
    CHECK(superfluous_barrier(plan) == "");
}

} // namespace

// --- Degenerate ------------------------------------------------------------------------------------------

TEST_CASE("an empty graph compiles to an empty plan") {
    FrameGraph graph;
    const Plan plan = compiled(graph);
    CHECK(plan.passes.empty());
    CHECK(plan.final_barriers.empty());
    CHECK(plan.heaps.empty());
    CHECK(contains(to_dot(plan), "digraph"));
}

TEST_CASE("a resource that no live pass uses gets no memory and no barrier") {
    FrameGraph graph;
    (void)graph.create_image("unused", small_image);
    (void)graph.import_buffer("arena", small_buffer, {.initial = Access::vertex_read, .final = Access::vertex_read});
    const Plan plan = compiled(graph);
    CHECK_FALSE(plan.resources[0].used());
    CHECK(plan.heaps.empty());
    CHECK(plan.final_barriers.empty());
}

TEST_CASE("a default-constructed handle is invalid") {
    CHECK_FALSE(Image().valid());
    CHECK(Image(3, 2).valid());
    CHECK(Image(3, 2).resource() == 3);
    CHECK(Image(3, 2).version() == 2);
    CHECK(Image(3, 2) != Image(3, 1));
    static_assert(sizeof(Image) == 4);
    static_assert(!std::is_convertible_v<Image, Buffer>);
}

TEST_CASE("the traits of each access agree with the tests' own table") {
    for (const AccessFacts& f : facts_table) {
        CAPTURE(to_string(f.access));
        const AccessTraits& t = traits(f.access);
        CHECK(t.reads == f.reads);
        CHECK(t.writes == f.writes);
        CHECK((t.writes && !t.keeps) == f.replaces);
        CHECK(t.images == f.image);
        CHECK(t.buffers == f.buffer);
        if (f.image) CHECK(t.layout == f.layout);
        CHECK((t.kinds >> static_cast<unsigned>(f.kind) & 1) == 1);
    }
    CHECK(to_string(Access::vertex_read | Access::index_read) == "index_read|vertex_read");
    CHECK(to_string(AccessSet{}) == "nothing");
}

// --- Hazards ---------------------------------------------------------------------------------------------

TEST_CASE("a read after a write waits for it") {
    FrameGraph graph;
    Buffer data = graph.create_buffer("data", small_buffer);
    add(graph, "make", C, [&](PassBuilder& p) { data = p.write(data, Access::storage_write_compute); });
    add(graph, "use", G, [&](PassBuilder& p) {
        p.read(data, Access::vertex_read);
        p.side_effect();
    });
    Plan plan = compiled(graph);
    CHECK(names(plan.passes) == Names{"make", "use"});
    CHECK(plan.passes[0].barriers.empty());
    REQUIRE(plan.passes[1].barriers.size() == 1);
    const Plan::Barrier& barrier = plan.passes[1].barriers[0];
    CHECK(barrier.resource == data.resource());
    CHECK(barrier.before == AccessSet(Access::storage_write_compute));
    CHECK(barrier.after == AccessSet(Access::vertex_read));
    CHECK_FALSE(barrier.aliasing);
    check_sound(plan);
}

TEST_CASE("a write after a read waits for it") {
    FrameGraph graph;
    Buffer data = graph.import_buffer("data", small_buffer, {.initial = Access::vertex_read});
    add(graph, "draw", G, [&](PassBuilder& p) {
        p.read(data, Access::vertex_read);
        p.side_effect();
    });
    add(graph, "refill", T, [&](PassBuilder& p) { data = p.write(data, Access::transfer_write); });
    Plan plan = compiled(graph);
    CHECK(plan.passes[0].barriers.empty()); // the import's initial access includes the read
    REQUIRE(plan.passes[1].barriers.size() == 1);
    CHECK(plan.passes[1].barriers[0].before == AccessSet(Access::vertex_read));
    CHECK(plan.passes[1].barriers[0].after == AccessSet(Access::transfer_write));
    check_sound(plan);
}

TEST_CASE("a write after a write waits for it and keeps or discards the contents") {
    FrameGraph graph;
    Image colour = graph.import_image("colour", small_image, {.final = Access::transfer_read});
    add(graph, "fill", C, [&](PassBuilder& p) { colour = p.write(colour, Access::storage_write_compute); });
    add(graph, "over", G, [&](PassBuilder& p) { colour = p.write(colour, Access::colour_attachment_load); });
    Plan plan = compiled(graph);
    REQUIRE(plan.passes.size() == 2);
    CHECK(plan.passes[0].barriers.at(0).from == Layout::undefined);
    CHECK(plan.passes[0].barriers.at(0).to == Layout::general);
    CHECK(plan.passes[0].barriers.at(0).before.empty());
    CHECK(plan.passes[1].barriers.at(0).from == Layout::general);
    CHECK(plan.passes[1].barriers.at(0).to == Layout::attachment);
    CHECK(plan.final_barriers.at(0).from == Layout::attachment);
    check_sound(plan);

    FrameGraph other;
    colour = other.import_image("colour", small_image, {.initial = Access::sampled_fragment});
    add(other, "clear", G, [&](PassBuilder& p) { colour = p.write(colour, Access::colour_attachment); });
    plan = compiled(other);
    CHECK(plan.passes[0].barriers.at(0).from == Layout::undefined); // contents are discarded after the wait for readers
    CHECK(plan.passes[0].barriers.at(0).before == AccessSet(Access::sampled_fragment));
    check_sound(plan);
}

TEST_CASE("consecutive reads in different stages share one barrier with all their accesses") {
    FrameGraph graph;
    Image map = graph.create_image("map", small_image);
    add(graph, "make", G, [&](PassBuilder& p) { map = p.write(map, Access::depth_attachment); });
    for (const auto& [name, kind, access] :
         {std::tuple{"first", G, Access::sampled_fragment}, std::tuple{"second", C, Access::sampled_compute},
          std::tuple{"third", G, Access::depth_read}})
        add(graph, name, kind, [&, a = access](PassBuilder& p) {
            p.read(map, a);
            p.side_effect();
        });
    Plan plan = compiled(graph);
    REQUIRE(plan.passes[1].barriers.size() == 1);
    CHECK(plan.passes[1].barriers[0].after
          == (Access::sampled_fragment | Access::sampled_compute | Access::depth_read));
    CHECK(plan.passes[2].barriers.empty());
    CHECK(plan.passes[3].barriers.empty());
    check_sound(plan);
}

TEST_CASE("reads of an image in two layouts need a transition between them") {
    FrameGraph graph;
    Image image = graph.create_image("image", small_image);
    add(graph, "make", C, [&](PassBuilder& p) { image = p.write(image, Access::storage_write_compute); });
    add(graph, "sample", G, [&](PassBuilder& p) {
        p.read(image, Access::sampled_fragment);
        p.side_effect();
    });
    add(graph, "copy", T, [&](PassBuilder& p) {
        p.read(image, Access::transfer_read);
        p.side_effect();
    });
    Plan plan = compiled(graph);
    CHECK(plan.passes[2].barriers.at(0).from == Layout::read_only);
    CHECK(plan.passes[2].barriers.at(0).to == Layout::transfer_source);
    check_sound(plan);
}

TEST_CASE("a diamond of dependencies: both middle passes wait for the first, and the last for both") {
    FrameGraph graph;
    Buffer top = graph.create_buffer("top", small_buffer);
    Buffer left = graph.create_buffer("left", small_buffer);
    Buffer right = graph.create_buffer("right", small_buffer);
    Buffer out = graph.import_buffer("out", small_buffer, {.final = Access::host_read});
    add(graph, "top", C, [&](PassBuilder& p) { top = p.write(top, Access::storage_write_compute); });
    add(graph, "left", C, [&](PassBuilder& p) {
        p.read(top, Access::storage_read_compute);
        left = p.write(left, Access::storage_write_compute);
    });
    add(graph, "right", C, [&](PassBuilder& p) {
        p.read(top, Access::uniform_read);
        right = p.write(right, Access::storage_write_compute);
    });
    add(graph, "bottom", C, [&](PassBuilder& p) {
        p.read(left, Access::storage_read_compute);
        p.read(right, Access::storage_read_compute);
        out = p.write(out, Access::storage_write_compute);
    });
    Plan plan = compiled(graph);
    CHECK(names(plan.passes) == Names{"top", "left", "right", "bottom"});
    CHECK(plan.passes[1].barriers.size() == 1);
    CHECK(plan.passes[1].barriers[0].after == (Access::storage_read_compute | Access::uniform_read));
    CHECK(plan.passes[2].barriers.empty());
    CHECK(plan.passes[3].barriers.size() == 2);
    CHECK(plan.final_barriers.size() == 1);
    check_sound(plan);
}

// --- Imports ---------------------------------------------------------------------------------------------

TEST_CASE("a swapchain image goes from acquired to drawn to present") {
    FrameGraph graph;
    Image target = graph.import_image("swapchain", small_image,
                                      {.initial = Access::acquired, .final = Access::present, .external = 42});
    add(graph, "draw", G, [&](PassBuilder& p) { target = p.write(target, Access::colour_attachment); });
    Plan plan = compiled(graph);
    const Plan::Barrier& first = plan.passes.at(0).barriers.at(0);
    CHECK(first.before == AccessSet(Access::acquired)); // so that the transition waits for the semaphore
    CHECK(first.from == Layout::undefined);
    CHECK(first.to == Layout::attachment);
    const Plan::Barrier& last = plan.final_barriers.at(0);
    CHECK(last.before == AccessSet(Access::colour_attachment));
    CHECK(last.from == Layout::attachment);
    CHECK(last.to == Layout::present);
    CHECK(plan.resources[0].import.external == 42);
    CHECK(plan.resources[0].accesses == (Access::acquired | Access::colour_attachment | Access::present));
    CHECK(plan.heaps.empty());
    check_sound(plan);
}

TEST_CASE("a read that the import's initial reads do not cover gets a barrier, one that they cover does not") {
    FrameGraph graph;
    const Buffer data =
        graph.import_buffer("data", small_buffer, {.initial = Access::vertex_read | Access::index_read});
    add(graph, "covered", G, [&](PassBuilder& p) {
        p.read(data, Access::index_read);
        p.side_effect();
    });
    add(graph, "new stage", C, [&](PassBuilder& p) {
        p.read(data, Access::storage_read_compute);
        p.side_effect();
    });
    Plan plan = compiled(graph);
    CHECK(plan.passes[0].barriers.empty());
    CHECK(plan.passes[1].barriers.size() == 1);
    check_sound(plan);
}

TEST_CASE("a write waits for both reads of a pass of which the import covers only one") {
    FrameGraph graph;
    Image image = graph.import_image("image", small_image, {.initial = Access::sampled_fragment});
    add(graph, "read", G, [&](PassBuilder& p) {
        p.read(image, Access::sampled_fragment);
        p.read(image, Access::depth_read);
        p.side_effect();
    });
    add(graph, "write", C, [&](PassBuilder& p) { image = p.write(image, Access::storage_write_compute); });
    Plan plan = compiled(graph);
    CHECK(plan.passes[1].barriers.at(0).before == (Access::sampled_fragment | Access::depth_read));
    check_sound(plan);
}

TEST_CASE("a final read joins the consecutive reads before it") {
    FrameGraph graph;
    Image history = graph.import_image("history", small_image, {.final = Access::sampled_compute});
    add(graph, "make", G, [&](PassBuilder& p) { history = p.write(history, Access::colour_attachment); });
    add(graph, "show", G, [&](PassBuilder& p) {
        p.read(history, Access::sampled_fragment);
        p.side_effect();
    });
    Plan plan = compiled(graph);
    CHECK(plan.passes[1].barriers.at(0).after == (Access::sampled_fragment | Access::sampled_compute));
    CHECK(plan.final_barriers.empty());
    check_sound(plan);
}

// --- Culling ---------------------------------------------------------------------------------------------

TEST_CASE("passes that no output needs are culled, whole chains included") {
    FrameGraph graph;
    Buffer a = graph.create_buffer("a", small_buffer);
    Buffer b = graph.create_buffer("b", small_buffer);
    Image target = graph.import_image("target", small_image, {.final = Access::present});
    add(graph, "dead start", C, [&](PassBuilder& p) { a = p.write(a, Access::storage_write_compute); });
    add(graph, "dead end", C, [&](PassBuilder& p) {
        p.read(a, Access::storage_read_compute);
        b = p.write(b, Access::storage_write_compute);
    });
    add(graph, "draw", G, [&](PassBuilder& p) { target = p.write(target, Access::colour_attachment); });
    const Plan plan = compiled(graph);
    CHECK(names(plan.passes) == Names{"draw"});
    CHECK(names(plan.culled) == Names{"dead start", "dead end"});
    CHECK(plan.heaps.empty());
}

TEST_CASE("a write that replaces the image culls earlier writes, one that loads keeps them") {
    for (const bool load : {false, true}) {
        FrameGraph graph;
        Image target = graph.import_image("target", small_image, {.final = Access::present});
        add(graph, "first", G, [&](PassBuilder& p) { target = p.write(target, Access::colour_attachment); });
        add(graph, "second", G, [&](PassBuilder& p) {
            target = p.write(target, load ? Access::colour_attachment_load : Access::colour_attachment);
        });
        const Plan plan = compiled(graph);
        CHECK(names(plan.passes) == (load ? Names{"first", "second"} : Names{"second"}));
    }
}

TEST_CASE("two copies into one buffer are both live, because each may write a part") {
    FrameGraph graph;
    Buffer readback = graph.import_buffer("readback", small_buffer, {.final = Access::host_read});
    add(graph, "low half", T, [&](PassBuilder& p) { readback = p.write(readback, Access::transfer_write); });
    add(graph, "high half", T, [&](PassBuilder& p) { readback = p.write(readback, Access::transfer_write); });
    CHECK(names(compiled(graph).passes) == Names{"low half", "high half"});
}

// --- Memory ----------------------------------------------------------------------------------------------

TEST_CASE("a chain of passes needs the memory of two images") {
    FrameGraph graph;
    std::vector<Image> images;
    for (int i = 0; i < 8; ++i) {
        images.push_back(graph.create_image("image" + std::to_string(i), small_image));
        add(graph, "step", G, [&](PassBuilder& p) {
            if (i > 0) p.read(images[images.size() - 2], Access::sampled_fragment);
            images.back() = p.write(images.back(), Access::colour_attachment);
            if (i == 7) p.side_effect();
        });
    }
    Plan plan = compiled(graph);
    REQUIRE(plan.heaps.size() == 1);
    CHECK(plan.heaps[0].size == 200);
    // Image 2 reuses the bytes of image 0, whose last access is in pass 1.
    const std::vector<Plan::Barrier>& barriers = plan.passes[2].barriers;
    const auto born = std::find_if(barriers.begin(), barriers.end(),
                                   [&](const Plan::Barrier& b) { return b.resource == images[2].resource(); });
    REQUIRE(born != barriers.end());
    CHECK(born->aliasing);
    CHECK(born->before == AccessSet(Access::sampled_fragment));
    CHECK(born->from == Layout::undefined);
    check_sound(plan);
}

TEST_CASE("resources of different memory classes never share a heap, and offsets are aligned") {
    FrameGraph graph;
    Image image = graph.create_image("image", small_image);
    Buffer small = graph.create_buffer("small", small_buffer);
    Buffer big = graph.create_buffer("big", small_buffer);
    add(graph, "all", C, [&](PassBuilder& p) {
        image = p.write(image, Access::storage_write_compute);
        small = p.write(small, Access::storage_write_compute);
        big = p.write(big, Access::storage_write_compute);
        p.side_effect();
    });
    const MemoryNeeds needs = [](const Plan::Resource& r) -> MemoryNeed {
        if (r.is_image()) return {.size = 10, .alignment = 1, .memory_class = 7};
        return {.size = r.name == "big" ? 100u : 5u, .alignment = 64, .memory_class = 3};
    };
    Plan plan = compiled(graph, needs);
    REQUIRE(plan.heaps.size() == 2);
    CHECK(plan.heaps[0].memory_class == 7);
    CHECK(plan.heaps[1].memory_class == 3);
    CHECK(plan.heaps[1].alignment == 64);
    CHECK(plan.resources[big.resource()].memory.offset == 0);
    CHECK(plan.resources[small.resource()].memory.offset == 128);
    CHECK(plan.heaps[0].size == 10);
    CHECK(plan.heaps[1].size == 133);
    check_sound(plan, needs);
}

// --- Execute ---------------------------------------------------------------------------------------------

namespace brittle::engine {
class PassContext {
  public:
    std::string log;
};
} // namespace brittle::engine

TEST_CASE("the plan carries each pass's execute function") {
    FrameGraph graph;
    for (const char* name : {"a", "b"})
        graph.add_pass(
            name, G, [](PassBuilder& p) { p.side_effect(); }, [name](PassContext& context) { context.log += name; });
    const Plan plan = compiled(graph);
    PassContext context;
    for (const Plan::Pass& pass : plan.passes) pass.execute(context);
    CHECK(context.log == "ab");
}

// --- Impossible graphs -----------------------------------------------------------------------------------

TEST_CASE("reading a transient before any write is an error with its name") {
    FrameGraph graph;
    const Image shadow = graph.create_image("shadow", small_image);
    add(graph, "shade", G, [&](PassBuilder& p) { p.read(shadow, Access::sampled_fragment); });
    CHECK(error_of(graph) == "pass 'shade' reads 'shadow' as sampled_fragment, but no pass wrote it before");
}

TEST_CASE("loading an attachment that was never written is an error with its name") {
    FrameGraph graph;
    Image target = graph.import_image("target", small_image, {.initial = Access::acquired});
    add(graph, "overlay", G, [&](PassBuilder& p) { target = p.write(target, Access::colour_attachment_load); });
    CHECK(error_of(graph)
          == "pass 'overlay' writes 'target' as colour_attachment_load, but it was imported with undefined "
             "contents and no "
             "pass wrote it before");
}

TEST_CASE("the use of a dead handle is an error that names the pass which replaced it") {
    FrameGraph graph;
    const Buffer data = graph.create_buffer("data", small_buffer);
    add(graph, "make", C, [&](PassBuilder& p) { (void)p.write(data, Access::storage_write_compute); });
    SUBCASE("for reading") {
        add(graph, "use", C, [&](PassBuilder& p) { p.read(data, Access::storage_read_compute); });
        CHECK(error_of(graph)
              == "pass 'use' reads 'data' as storage_read_compute, but by its version 0, which pass 'make' "
                 "has replaced: use "
                 "the handle that its write() returned");
    }
    SUBCASE("for writing, which would make two writers of one version") {
        add(graph, "again", C, [&](PassBuilder& p) { (void)p.write(data, Access::storage_write_compute); });
        CHECK(contains(error_of(graph),
                       "pass 'again' writes 'data' as storage_write_compute, but by its version 0, which "
                       "pass 'make' has replaced"));
    }
}

TEST_CASE("writing a read-only import is an error with its name") {
    FrameGraph graph;
    const Buffer arena =
        graph.import_buffer("arena", small_buffer, {.initial = Access::vertex_read, .read_only = true});
    add(graph, "scribble", T, [&](PassBuilder& p) { (void)p.write(arena, Access::transfer_write); });
    CHECK(error_of(graph) == "pass 'scribble' writes 'arena' as transfer_write, but it is imported as read-only");
}

TEST_CASE("an access that does not fit the resource, the pass or the direction is an error with its name") {
    FrameGraph graph;
    const Buffer data = graph.create_buffer("data", small_buffer);
    const Image image = graph.create_image("image", small_image);
    SUBCASE("attachment access to a buffer") {
        add(graph, "p", G, [&](PassBuilder& p) { (void)p.write(data, Access::colour_attachment); });
        CHECK(error_of(graph) == "pass 'p' writes 'data' as colour_attachment, which is not legal for a buffer");
    }
    SUBCASE("vertex access to an image") {
        add(graph, "p", G, [&](PassBuilder& p) { p.read(image, Access::vertex_read); });
        CHECK(error_of(graph) == "pass 'p' reads 'image' as vertex_read, which is not legal for an image");
    }
    SUBCASE("attachment in a compute pass") {
        add(graph, "p", C, [&](PassBuilder& p) { (void)p.write(image, Access::depth_attachment); });
        CHECK(error_of(graph) == "pass 'p' writes 'image' as depth_attachment, which is not allowed in a compute pass");
    }
    SUBCASE("writing with a reading access") {
        add(graph, "p", C, [&](PassBuilder& p) { (void)p.write(data, Access::storage_read_compute); });
        CHECK(error_of(graph) == "pass 'p' writes 'data' as storage_read_compute, which only reads");
    }
    SUBCASE("resolving into samples") {
        const Image samples = graph.create_image("samples", {.width = 4, .height = 4, .samples = 4});
        add(graph, "p", G, [&](PassBuilder& p) { (void)p.write(samples, Access::resolve_attachment); });
        CHECK(error_of(graph) == "pass 'p' writes 'samples' as resolve_attachment, which needs an image of one sample");
    }
    SUBCASE("reading with a writing access") {
        add(graph, "p", C, [&](PassBuilder& p) { p.read(data, Access::storage_write_compute); });
        CHECK(error_of(graph) == "pass 'p' reads 'data' as storage_write_compute, which writes");
    }
    SUBCASE("an access for edges of the frame inside it") {
        add(graph, "p", G, [&](PassBuilder& p) { p.read(image, Access::present); });
        CHECK(error_of(graph)
              == "pass 'p' reads 'image' as present, which is legal only as an import's initial or final "
                 "access");
    }
}

TEST_CASE("conflicting uses of one resource in one pass are an error with its name") {
    FrameGraph graph;
    Image image = graph.import_image("image", small_image, {.initial = Access::sampled_fragment});
    SUBCASE("read and write") {
        add(graph, "p", G, [&](PassBuilder& p) {
            p.read(image, Access::sampled_fragment);
            image = p.write(image, Access::colour_attachment);
        });
        CHECK(contains(error_of(graph),
                       "pass 'p' writes 'image' as colour_attachment, but also uses it as sampled_fragment"));
    }
    SUBCASE("write and read of the new version") {
        add(graph, "p", G, [&](PassBuilder& p) {
            image = p.write(image, Access::colour_attachment);
            p.read(image, Access::sampled_fragment);
        });
        CHECK(contains(error_of(graph),
                       "pass 'p' reads 'image' as sampled_fragment, but also uses it as colour_attachment"));
    }
    SUBCASE("two writes") {
        add(graph, "p", G, [&](PassBuilder& p) {
            image = p.write(image, Access::colour_attachment);
            image = p.write(image, Access::colour_attachment);
        });
        CHECK(contains(error_of(graph), "but also uses it as colour_attachment"));
    }
    SUBCASE("reads in two layouts") {
        add(graph, "p", G, [&](PassBuilder& p) {
            p.read(image, Access::sampled_fragment);
            p.read(image, Access::storage_read_fragment);
        });
        CHECK(contains(error_of(graph), "the two need different image layouts"));
    }
}

TEST_CASE("several reads of one resource in one pass do not conflict") {
    FrameGraph graph;
    const Buffer arena = graph.import_buffer("arena", small_buffer, {.initial = Access::transfer_write});
    add(graph, "draw", G, [&](PassBuilder& p) {
        p.read(arena, Access::vertex_read);
        p.read(arena, Access::index_read);
        p.read(arena, Access::index_read);
        p.side_effect();
    });
    Plan plan = compiled(graph);
    CHECK(plan.passes[0].uses.size() == 2);
    CHECK(plan.passes[0].barriers.at(0).after == (Access::vertex_read | Access::index_read));
    check_sound(plan);
}

TEST_CASE("impossible resources are errors with their names") {
    FrameGraph graph;
    SUBCASE("zero-sized image") {
        (void)graph.create_image("minimised", {.width = 0, .height = 720});
        CHECK(contains(error_of(graph), "image 'minimised' is 0x720"));
    }
    SUBCASE("zero-sized buffer") {
        (void)graph.create_buffer("nothing", {.size = 0});
        CHECK(error_of(graph) == "buffer 'nothing' has size 0");
    }
    SUBCASE("initial accesses in two layouts") {
        (void)graph.import_image("torn", small_image, {.initial = Access::sampled_fragment | Access::transfer_read});
        CHECK(error_of(graph)
              == "imported 'torn': initial accesses transfer_read and sampled_fragment need different image "
                 "layouts");
    }
    SUBCASE("initial access of the wrong sort") {
        (void)graph.import_buffer("odd", small_buffer, {.initial = Access::present});
        CHECK(error_of(graph) == "imported 'odd': present is not legal for a buffer");
    }
    SUBCASE("initial accesses as final ones, and the reverse") {
        (void)graph.import_image("late", small_image, {.final = Access::acquired});
        (void)graph.import_buffer("early", small_buffer, {.initial = Access::host_read});
        (void)graph.import_buffer("after", small_buffer, {.final = Access::host_write});
        CHECK(error_of(graph)
              == "imported 'late': acquired is not legal as final access\n"
                 "imported 'early': host_read is not legal as initial access\n"
                 "imported 'after': host_write is not legal as final access");
    }
    SUBCASE("final read of contents that no pass wrote") {
        (void)graph.import_image("blank", small_image, {.initial = Access::acquired, .final = Access::present});
        CHECK(error_of(graph) == "imported 'blank' has the final access present, but no pass wrote it");
    }
}

TEST_CASE("handles that are not of the graph are errors") {
    FrameGraph graph, other;
    const Image foreign = other.create_image("foreign", small_image);
    const Buffer data = graph.create_buffer("data", small_buffer);
    add(graph, "a", G, [&](PassBuilder& p) { p.read(Image(), Access::sampled_fragment); });
    add(graph, "b", G, [&](PassBuilder& p) { (void)p.write(foreign, Access::colour_attachment); });
    add(graph, "c", C,
        [&](PassBuilder& p) { p.read(Buffer(data.resource(), data.version() + 1), Access::storage_read_compute); });
    const std::string error = error_of(graph);
    for (const char* part : {"pass 'a' reads an image handle that is not of this graph",
                             "pass 'b' writes an image handle that is not of this graph",
                             "pass 'c' reads a buffer handle that is not of this graph"})
        CHECK(contains(error, part));
}

TEST_CASE("every mistake is reported, each once") {
    FrameGraph graph;
    Image a = graph.create_image("a", small_image);
    Buffer b = graph.create_buffer("b", small_buffer);
    add(graph, "one", G, [&](PassBuilder& p) { p.read(a, Access::sampled_fragment); });
    add(graph, "two", G, [&](PassBuilder& p) { b = p.write(b, Access::colour_attachment); });
    add(graph, "three", C, [&](PassBuilder& p) { b = p.write(b, Access::storage_write_compute); });
    const std::string error = error_of(graph);
    CHECK(std::count(error.begin(), error.end(), '\n') == 1);
    CHECK(contains(error, "'one'"));
    CHECK(contains(error, "'two'"));
}

TEST_CASE("a resource has a bounded number of versions") {
    FrameGraph graph;
    Buffer data = graph.import_buffer("data", small_buffer, {.initial = Access::transfer_write});
    for (std::uint32_t i = 0; i < Buffer::max_version; ++i)
        add(graph, "fill", T, [&](PassBuilder& p) { data = p.write(data, Access::transfer_write); });
    SUBCASE("the last one is good") {
        CHECK(compiled(graph).passes.size() == Buffer::max_version);
    }
    SUBCASE("one more is refused") {
        add(graph, "too much", T, [&](PassBuilder& p) { data = p.write(data, Access::transfer_write); });
        CHECK(contains(error_of(graph),
                       "pass 'too much' writes 'data' as transfer_write, but it was written 4095 times"));
    }
}

// --- DOT --------------------------------------------------------------------------------------------------

TEST_CASE("the graph prints itself as DOT") {
    FrameGraph graph;
    Image odd = graph.create_image("a \"quoted\\\" {name\nin two lines", small_image);
    Image target = graph.import_image("target", small_image, {.initial = Access::acquired, .final = Access::present});
    Buffer waste = graph.create_buffer("waste", small_buffer);
    add(graph, "make", G, [&](PassBuilder& p) { odd = p.write(odd, Access::colour_attachment); });
    add(graph, "useless", C, [&](PassBuilder& p) { waste = p.write(waste, Access::storage_write_compute); });
    add(graph, "tonemap", G, [&](PassBuilder& p) {
        p.read(odd, Access::sampled_fragment);
        target = p.write(target, Access::colour_attachment);
    });
    const std::string dot = to_dot(compiled(graph));
    check_dot(dot);
    CHECK(contains(dot, "p1 [shape=box, label=\"tonemap\\ngraphics\\nbarriers: 2\"]"));
    CHECK(contains(dot, "c0 [shape=box, label=\"useless\\ncompute\", color=grey"));
    CHECK(contains(dot, "r0v1 -> p1 [label=\"sampled_fragment\"]"));
    CHECK(contains(dot, "p1 -> r1v1 [label=\"colour_attachment\"]"));
    CHECK(contains(dot, "peripheries=2"));
}

// The panels of the right column: simulation, view and statistics.
#include <algorithm>
#include <cstdio>
#include <string>

#include <imgui.h>
#include <unistd.h>

#include "tools/brittle/studio/panels.h"
#include "tools/brittle/studio/style.h"
#include "tools/brittle/studio/widgets.h"

namespace brittle::tools {

namespace {

constexpr float graph_height = 54.0f;
constexpr float graph_top = 100.0f; // ms, minimum of the graph's upper end

// Returns the resident memory of this process, MiB; 0 if the system does not report it.
double resident_memory() {
    std::FILE* file = std::fopen("/proc/self/statm", "r");
    if (!file) return 0.0;
    unsigned long all = 0, resident = 0;
    const int read = std::fscanf(file, "%lu %lu", &all, &resident);
    std::fclose(file);
    return read == 2 ? static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1024.0 * 1024.0)
                     : 0.0;
}

bool toggle(const char* name, const char* tip_text, bool& on) {
    const bool changed = ImGui::Checkbox(name, &on);
    tip(tip_text);
    return changed;
}

void second_column() {
    ImGui::SameLine(ImGui::GetWindowContentRegionMin().x
                    + 0.5f * (ImGui::GetWindowContentRegionMax().x - ImGui::GetWindowContentRegionMin().x));
}

void frame_graph(const FrameTimes& times, float scale) {
    const auto& ms = times.milliseconds();
    if (ms.empty()) return;
    const float top = std::max(graph_top, *std::max_element(ms.begin(), ms.end()));
    const float width = ImGui::GetContentRegionAvail().x;
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const float height = graph_height * scale;
    ImGui::PlotLines("##frame times", ms.data(), static_cast<int>(ms.size()), 0, nullptr, 0.0f, top, {width, height});
    tip("Milliseconds of each frame; orange: the pieces of a fracture arrived");
    const ImVec2 inset = ImGui::GetStyle().FramePadding;
    const float count = static_cast<float>(std::max<size_t>(ms.size() - 1, 1));
    for (const size_t mark : times.marks()) {
        const float x = corner.x + inset.x + (width - 2.0f * inset.x) * static_cast<float>(mark) / count;
        ImGui::GetWindowDrawList()->AddLine({x, corner.y + 2.0f}, {x, corner.y + height - 2.0f}, StudioColours{}.accent,
                                            1.5f * scale);
    }
}

// The menu of the panel's header. Returns whether the choice changed.
bool engine_menu(physics::EngineKind& engine) {
    tip("Right click: choose the physics engine");
    if (!ImGui::BeginPopupContextItem("physics engine")) return false;
    const physics::EngineKind before = engine;
    ImGui::TextDisabled("Physics engine, from the next break on");
    if (ImGui::MenuItem("Brittle's solver", nullptr, engine == physics::EngineKind::solver))
        engine = physics::EngineKind::solver;
    if (ImGui::MenuItem("Stock Bullet", nullptr, engine == physics::EngineKind::bullet))
        engine = physics::EngineKind::bullet;
    tip("A reference for comparison; there is no drag of the air");
    ImGui::EndPopup();
    return engine != before;
}

// Returns whether an option changed.
bool how_it_breaks(WorldOptions& world) {
    bool changed = toggle("Bonded", "Pieces hold together until blows or loads break their bonds", world.bonded);
    second_column();
    changed |=
        toggle("Anchored", "Parts that stand on the ground are fixed, and the pieces are bonded", world.anchored);
    changed |=
        toggle("Breakable", "Blows of the hammer, of balls and of falls cut pieces again and again", world.breakable);
    if (world.breakable) {
        control("Least piece", "Cube root of the volume of the smallest pieces, on the stage");
        auto least = static_cast<float>(world.min_size);
        if (slider("##Least piece", least, 0.01f, 0.5f, "%.2f m")) {
            world.min_size = static_cast<double>(least);
            changed = true;
        }
    }
    if (!world.anchored) {
        control("Drop height", "Initial height of the mesh above the ground");
        auto height = static_cast<float>(world.height);
        if (slider("##Height", height, 0.0f, 5.0f, "%.2f m")) {
            world.height = height;
            changed = true;
        }
    }
    return changed;
}

} // namespace

void Panels::simulation_panel(const PanelState& state) {
    if (!begin_panel("Simulation")) return;
    Session& session = state.session;
    WorldOptions world = session.recipe().world;
    bool changed = engine_menu(world.engine);
    if (!session.object().is_scene()) changed |= how_it_breaks(world);
    if (changed) edit(session, SetWorld{world});
    control("Time", "Speed of time; below 1 is slow motion");
    (void)slider("##Time", session.playback.speed, 0.02f, 1.0f, "%.2f x", ImGuiSliderFlags_Logarithmic);
    if (wide_button(session.playback.paused ? "Go on" : "Pause", "Pause or continue (P)", 0.5f))
        actions_.push_back(Command::pause);
    ImGui::SameLine();
    if (wide_button("Single step", "One step of 1/120 s (full stop)")) actions_.push_back(Command::step);
}

void Panels::view_panel(const PanelState& state) {
    if (!begin_panel("View")) return;
    PictureOptions& view = state.session.picture();
    control("Exploded", "Pieces drawn apart, by this share of their distance from the middle (X)");
    (void)slider("##Exploded", view.explode, 0.0f, 2.0f, "%.2f");
    const bool scene = state.session.object().is_scene(); // its objects' cells, sites and bonds are not drawn
    ImGui::BeginDisabled(scene);
    toggle("Cells", "Voronoi cells, on the mesh as it will break (V)", view.cells);
    second_column();
    toggle("Sites", "Voronoi sites as red spheres (S)", view.sites);
    ImGui::EndDisabled();
    toggle("Hulls", "Collision hulls: red awake, dark red asleep (D)", view.hulls);
    second_column();
    ImGui::BeginDisabled(scene);
    toggle("Bonds", "Bonds between pieces, coloured by load: grey without load, red about to break (B)",
           state.session.bonds);
    ImGui::EndDisabled();
    toggle("Smooth", "Round or flat exteriors (N)", view.smooth);
    if (state.has_line_mode) {
        second_column();
        toggle("Wireframe", "Edges of triangles (O)", view.wireframe);
    }
    bool dust = view.dust > 0.0f;
    if (toggle("Dust", "Dust and splinters of breaks; they move no piece", dust)) view.dust = dust ? 1.0f : 0.0f;
    second_column();
    bool materials = state.session.stage().shows_materials();
    if (toggle("Materials",
               "Materials and textures of the mesh, with a grain in the cuts; or a colour for each piece (C)",
               materials))
        view.colours = materials ? PieceColours::materials : PieceColours::pieces;
}

void Panels::certificate(const PanelState& state) {
    const auto& counts = state.session.counts();
    if (!counts) {
        if (state.session.preview().pieces() > 0) {
            value("Preview", "%u pieces", state.session.preview().pieces());
            value("Fracture", "%.1f ms", state.session.preview().current()->milliseconds);
        }
        return;
    }
    const fracture::Certificate& proof = counts->certificate;
    if (const physics::Destruction* destruction = state.session.stage().simulation().destruction()) {
        value("Pieces", "%u by %u cuts", counts->pieces, destruction->statistics().breaks);
        value("Awake", "%zu bodies", counts->awake);
        return; // the certificate describes the mesh before the cuts
    }
    value("Pieces", "%u from %u cells", proof.pieces, proof.cells);
    value("Awake", "%zu bodies", counts->awake);
    ImGui::PushStyleColor(ImGuiCol_Text, proof.closed ? IM_COL32(140, 209, 115, 255) : IM_COL32(250, 133, 107, 255));
    proof.closed ? value("Certificate", "all closed") : value("Certificate", "%u open", proof.open_pieces);
    ImGui::PopStyleColor();
    tip("Whether each piece bounds a solid: every edge has two triangles, in opposite directions");
    value("Volume error", "%.1e", proof.volume_error);
    value("Fracture", "%.1f ms", counts->milliseconds);
    if (ImGui::TreeNode("Phases")) {
        for (const fracture::Milliseconds& phase : counts->phases)
            value(phase.phase.c_str(), "%.2f ms", phase.milliseconds);
        ImGui::TreePop();
    }
}

void Panels::statistics_panel(const PanelState& state) {
    if (!begin_panel("Statistics")) return;
    const double median = state.times.median();
    value("Frame rate", "%.0f /s, %.1f ms", median > 0.0 ? 1000.0 / median : 0.0, median);
    frame_graph(state.times, state.scale);
    const engine::FrameStats& drawn = state.renderer.stats();
    value("Triangles", drawn.draws == 1 ? "%s in %u draw" : "%s in %u draws", grouped(drawn.triangles).c_str(),
          drawn.draws);
    value("Memory", "%.0f MiB", resident_memory());
    certificate(state);
    if (ImGui::TreeNode("Passes")) {
        for (const engine::PassTime& pass : state.renderer.timings())
            value(pass.name.c_str(), "%.2f ms", pass.milliseconds);
        ImGui::TreePop();
    }
    explain(state.device.c_str());
}

} // namespace brittle::tools
